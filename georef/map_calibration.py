"""Cameras calibrated from points and lines of a map that were picked in their images by hand.

Three models, from the whole camera to the least: ``calibrate_camera`` (focal length, principal point, k1, k2, pose),
``calibrate_pan_tilt`` (the traffic paper's: focal length, pan, tilt, position) and ``calibrate_homography`` (the ground
alone). Picks carry noise and some are wrong; see ``georef.mixture``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from contracts import CalibrationError, Camera, FloatArray, InputError
from contracts.arrays import freeze
from georef.calibrated import CalibratedCamera
from georef.camera_models import Beliefs, CameraModel, CameraState, FullState, PanTiltState
from georef.camera_start import first_cameras
from georef.ground_homography import GroundHomography, HomographyModel
from georef.mixture import Fit, Model, Noise, State, best_fit
from georef.pick_checks import check_enough, check_spread
from georef.picks import LinePicks, PointPicks

LEAST_NEAR = 40
LEAST_POINTS = {"full": 8, "pan-tilt": 6, "homography": 6}
_GOOD_POINTS = 25
_LARGEST_WRONG_SHARE = 0.4
_LARGEST_NOISE_SHARE = 0.01  # of the image's width
_ON_GROUND_M = 1e-6
_MEDIAN_TO_SIGMA = 1.1774  # Rayleigh's median
_CAMERA_STARTS, _HOMOGRAPHY_STARTS = (3.0,), (1.0, 3.0)  # noise to begin with, over that of the start's residuals


@dataclass(frozen=True, eq=False)
class PickVerdict:
    """What a calibration says of the picks.

    good: (N,) probability that each point was picked right; NaN where it was not used.
    residuals_px: (N, 2) image less pick; NaN behind the camera.
    line_good: (M,) the same of pixels on lines. line_residuals_px: (M,) across the line.
    noise_px: standard deviation per axis of the good picks, estimated.
    """

    good: FloatArray
    residuals_px: FloatArray
    line_good: FloatArray
    line_residuals_px: FloatArray
    noise_px: float

    def __post_init__(self) -> None:
        freeze(self, "good", shape=(None,), finite=False)
        freeze(self, "residuals_px", shape=(len(self.good), 2), finite=False)
        freeze(self, "line_good", shape=(None,))
        freeze(self, "line_residuals_px", shape=(len(self.line_good),), finite=False)


@dataclass(frozen=True, eq=False)
class CameraFromMap:
    """A calibrated camera and what became of the picks."""

    calibrated: CalibratedCamera
    picks: PickVerdict


@dataclass(frozen=True, eq=False)
class HomographyFromMap:
    """A calibrated homography and what became of the picks; those above the ground are not used."""

    homography: GroundHomography
    picks: PickVerdict


def calibrate_camera(
    name: str,
    size_px: tuple[int, int],
    points: PointPicks,
    lines: LinePicks | None = None,
    *,
    rng: np.random.Generator,
    noise: Noise | None = None,
    beliefs: Beliefs | None = None,
) -> CameraFromMap:
    """The whole camera from at least eight points, and pixels on lines: f, principal point, k1, k2 and pose.

    size_px: width and height of the image. rng: draws the first samples; another seed changes the result by rounding.
    Raises CalibrationError, with the reason, for picks that do not determine it.
    """
    model = CameraModel(points, lines or LinePicks.none(), beliefs or Beliefs())
    return _calibrate("full", FullState.near, name, size_px, model=model, noise=noise or Noise(), rng=rng)


def calibrate_near(
    start: Camera,
    points: PointPicks,
    lines: LinePicks,
    *,
    start_noise_px: float,
    noise: Noise | None = None,
    beliefs: Beliefs | None = None,
) -> CameraFromMap:
    """The whole camera, p1 and p2 too, from picks that a program matched with the help of a first guess.

    points: may lack altogether. start_noise_px: how far the picks may lie from their images in ``start``.
    Raises CalibrationError, with the reason, for picks that do not determine it.
    """
    name, size = start.name, start.intrinsics
    check_enough(name, len(points) + len(lines), "points and pixels on lines", least=LEAST_NEAR)
    model = CameraModel(points, lines, beliefs or Beliefs())
    extent_px = float(np.hypot(size.width_px, size.height_px))
    begin = [(FullState(start, tangential=True), start_noise_px)]
    try:
        found = best_fit(model, begin, noise or Noise(), extent_px=extent_px)
    except CalibrationError as error:
        raise CalibrationError(f'camera "{name}": the picks do not fit one camera: {error}') from error
    return _from_fit(found, len(lines))


def calibrate_pan_tilt(
    name: str,
    size_px: tuple[int, int],
    points: PointPicks,
    lines: LinePicks | None = None,
    *,
    rng: np.random.Generator,
    noise: Noise | None = None,
    beliefs: Beliefs | None = None,
) -> CameraFromMap:
    """The traffic paper's camera: f, pan, tilt and position; principal point at the centre, no roll, no lens.

    Arguments and errors as in ``calibrate_camera``; at least six points.
    """
    model = CameraModel(points, lines or LinePicks.none(), beliefs or Beliefs())
    return _calibrate("pan-tilt", PanTiltState.near, name, size_px, model=model, noise=noise or Noise(), rng=rng)


def calibrate_homography(
    name: str,
    size_px: tuple[int, int],
    points: PointPicks,
    *,
    rng: np.random.Generator,
    noise: Noise | None = None,
) -> HomographyFromMap:
    """The homography of the ground z = 0 from at least six points on it; points above it are left out.

    The normalised direct linear transform (Hartley & Zisserman 2004, algorithm 4.2) through many samples of four picks,
    then the most likely homography of all (their algorithm 4.3 with the mixture as its loss).
    Raises CalibrationError, with the reason, for picks that do not determine it.
    """
    width_px, height_px = _checked_size(size_px)
    on_ground = np.abs(points.points_m[:, 2]) < _ON_GROUND_M
    used = points.chosen(on_ground)
    check_enough(name, len(used), "points on the ground, z = 0", least=LEAST_POINTS["homography"], good=_GOOD_POINTS)
    check_spread(name, used, width_px, height_px)
    model = HomographyModel(used, width_px, height_px)
    extent = float(np.hypot(width_px, height_px))
    noise = noise or Noise()
    found = _best(name, model, [model.first(rng)], _HOMOGRAPHY_STARTS, noise=noise, extent_px=extent)
    _check_fit(name, used, LinePicks.none(), found, size_px)
    homography = model.finished(name, (width_px, height_px), found.state, found.covariance)
    good, residuals = np.full(len(points), np.nan), np.full((len(points), 2), np.nan)
    good[on_ground], residuals[on_ground] = found.good[0], found.residuals[0]
    return HomographyFromMap(homography, PickVerdict(good, residuals, np.empty(0), np.empty(0), found.noise_px))


def _calibrate(
    kind: str,
    states_near: Callable[[Camera], Sequence[CameraState]],
    name: str,
    size_px: tuple[int, int],
    *,
    model: CameraModel,
    noise: Noise,
    rng: np.random.Generator,
) -> CameraFromMap:
    width_px, height_px = _checked_size(size_px)
    points, lines = model.points, model.lines
    check_enough(name, len(points), "points", least=LEAST_POINTS[kind], good=_GOOD_POINTS)
    check_spread(name, points, width_px, height_px, on_lines_px=lines.pixels)
    first = first_cameras(name, points, width_px, height_px, rng)
    starts = [state for camera in first for state in states_near(camera)]
    found = _best(name, model, starts, _CAMERA_STARTS, noise=noise, extent_px=float(np.hypot(width_px, height_px)))
    camera = found.state.camera
    if camera.pose.position_m[2] <= 0:
        raise CalibrationError(f'camera "{name}": the picks put it below the ground: check the points\' heights')
    _check_fit(name, points, lines, found, size_px)
    return _from_fit(found, len(lines))


def _from_fit(found: Fit[CameraState], lines: int) -> CameraFromMap:
    """lines: number of pixels picked on lines."""
    by_free = found.state.by_free
    covariance = by_free @ found.covariance @ by_free.T
    line_good, line_residuals = (found.good[1], found.residuals[1][:, 0]) if lines else (np.empty(0), np.empty(0))
    return CameraFromMap(
        CalibratedCamera(found.state.camera, 0.5 * (covariance + covariance.T)),
        PickVerdict(found.good[0], found.residuals[0], line_good, line_residuals, found.noise_px),
    )


def _best(
    name: str, model: Model[State], starts: Sequence[State], factors: Sequence[float], *, noise: Noise, extent_px: float
) -> Fit[State]:
    """From every start, with its residuals' noise times each of ``factors``.

    With too little, corners that a lens bends are taken for wrong picks and never come back; with too much, where the
    lens is no part of the model, wrong picks are taken for noise. The likelihood tells which happened.
    """
    tried = []
    for start in starts:
        lengths = np.linalg.norm(model.observe(start)[0].residuals, axis=1)
        typical_px = float(np.median(np.nan_to_num(lengths, nan=extent_px))) / _MEDIAN_TO_SIGMA
        tried += [(start, max(noise.sigma_px, factor * typical_px)) for factor in factors]
    try:
        return best_fit(model, tried, noise, extent_px=extent_px)
    except CalibrationError as error:
        raise CalibrationError(f'camera "{name}": the picks do not fit one camera: {error}') from error


def _checked_size(size_px: tuple[int, int]) -> tuple[int, int]:
    width_px, height_px = size_px
    if min(width_px, height_px) < 1:
        raise InputError(f"image size {width_px} x {height_px} px is not positive")
    return int(width_px), int(height_px)


def _check_fit(name: str, points: PointPicks, lines: LinePicks, found: Fit[State], size_px: tuple[int, int]) -> None:
    good = found.good[0] > 0.5
    if (~good).sum() > _LARGEST_WRONG_SHARE * len(points):
        raise CalibrationError(
            f'camera "{name}": {(~good).sum()} of {len(points)} picks do not fit one camera with the others'
        )
    if found.noise_px > _LARGEST_NOISE_SHARE * size_px[0]:
        raise CalibrationError(
            f'camera "{name}": the picks do not fit one camera; residuals of {found.noise_px:.1f} px remain'
        )
    on_lines_px = lines.pixels[found.good[1] > 0.5] if len(lines) else None
    check_spread(name, points.chosen(good), *size_px, on_lines_px=on_lines_px)
