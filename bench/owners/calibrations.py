"""``gantry calibrate intrinsics`` and ``camera``: a lens from images of a board, a camera from picks on a map."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from contracts import Checkerboard, FloatArray, Frame, InputError
from contracts.errors import CalibrationError
from georef.calibrated import CalibratedCamera
from georef.camera_file import write_stored
from georef.camera_forms import CameraForm, StoredCamera
from georef.camera_models import Beliefs
from georef.geo_reference import GeoReference
from georef.ground_homography import GroundHomography
from georef.hd_map import Facility, HdMap, LaneMarking, PaintedArea, RoadMark, Sign, Signal, StopLine
from georef.hd_map_file import read_map
from georef.homography_file import write_homography
from georef.intrinsics import IntrinsicCalibration, calibrate_intrinsics
from georef.map_calibration import PickVerdict, calibrate_camera, calibrate_homography, calibrate_pan_tilt
from georef.mixture import Noise
from georef.next_pick import gains
from georef.picks_file import PicksFile, read_picks

_WRONG_BELOW = 0.5


@dataclass(frozen=True)
class Wanted:
    """What ``gantry calibrate camera`` was asked for."""

    model: str
    name: str
    size_px: tuple[int, int]
    noise_px: float
    height_m: float | None
    seed: int
    form: str

    def __post_init__(self) -> None:
        if min(self.size_px) <= 0:
            raise InputError(f"--size {self.size_px[0]}x{self.size_px[1]} must be positive")
        if not (np.isfinite(self.noise_px) and self.noise_px > 0):
            raise InputError(f"--noise-px {self.noise_px} must be positive")
        if self.height_m is not None and not (np.isfinite(self.height_m) and self.height_m > 0):
            raise InputError(f"--height-m {self.height_m} must be positive")
        if self.seed < 0:
            raise InputError(f"--seed {self.seed} must not be negative")
        if self.model == "homography" and self.form != CameraForm.GANTRY:
            raise InputError(f"a homography is no camera: the form {self.form} cannot say it; leave --form away")


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibration from a map.

    noise_px: of a good pick, as the residuals tell. picks: how many there were; wrong_picks: names of those that were
    not believed. next_pick: a name of the map and the drop in metres, or None.
    """

    found: CalibratedCamera | GroundHomography
    noise_px: float
    picks: int
    wrong_picks: tuple[str, ...] = ()
    next_pick: tuple[str, float] | None = None

    @classmethod
    def of(cls, found: CalibratedCamera | GroundHomography, verdict: PickVerdict) -> "Calibration":
        """Without the names of wrong picks and the next one."""
        return cls(found, verdict.noise_px, int(np.isfinite(verdict.good).sum()) + len(verdict.line_good))


def calibrate_lens(
    images: Sequence[Path], board: tuple[int, int, float], name: str, out: Path, form: str
) -> IntrinsicCalibration:
    """Zhang's method on image files; writes the camera file, without pose. Raises InputError, CalibrationError."""
    lens = calibrate_intrinsics(read_images(images, name), Checkerboard(*board), names=[str(path) for path in images])
    covariance = np.zeros((15, 15))
    covariance[:9, :9] = lens.covariance
    write_stored(out, StoredCamera(name, lens.intrinsics, None, covariance), CameraForm(form))
    return lens


def read_images(images: Sequence[Path], name: str) -> list[Frame]:
    """Image files as frames of the camera ``name``. Raises InputError naming the file that is none."""
    frames = []
    for index, path in enumerate(images):
        image = cv2.imread(str(path), cv2.IMREAD_COLOR) if path.is_file() else None
        if image is None:
            raise InputError(f"{path} is no image that can be read")
        frames.append(Frame(name, index, 0, np.asarray(image, dtype=np.uint8)))
    return frames


def calibrate_from_picks(
    table: Path, map_path: Path | None, origin_deg: tuple[float, float] | None, wanted: Wanted, out: Path
) -> Calibration:
    """Fit the wanted model and write its file. Raises InputError and CalibrationError."""
    if map_path is not None and origin_deg is not None:
        raise InputError("the map has an origin of its own: leave --origin away")
    hd_map = read_map(map_path) if map_path else None
    geo = GeoReference(*origin_deg) if origin_deg else None
    picks = read_picks(table, hd_map=hd_map, geo=geo, size_px=wanted.size_px)
    rng, noise = np.random.default_rng(wanted.seed), Noise(wanted.noise_px)
    found: CalibratedCamera | GroundHomography
    try:
        if wanted.model == "homography":
            flat = calibrate_homography(wanted.name, wanted.size_px, picks.points, rng=rng, noise=noise)
            found, verdict = flat.homography, flat.picks
            write_homography(out, flat.homography, picks.geo)
        else:
            calibrate = calibrate_camera if wanted.model == "full" else calibrate_pan_tilt
            knows = Beliefs(height_m=wanted.height_m)
            whole = calibrate(
                wanted.name, wanted.size_px, picks.points, picks.lines, rng=rng, noise=noise, beliefs=knows
            )
            found, verdict = whole.calibrated, whole.picks
            write_stored(out, StoredCamera.of(whole.calibrated, picks.geo), CameraForm(wanted.form))
    except CalibrationError as error:
        raise CalibrationError(f"{table}: {error}") from error
    return replace(
        Calibration.of(found, verdict),
        wrong_picks=_wrong(picks, verdict),
        next_pick=_next_pick(found, verdict, picks, hd_map),
    )


def _wrong(picks: PicksFile, verdict: PickVerdict) -> tuple[str, ...]:
    names = (*picks.points.names, *picks.lines.names)
    probabilities = (*verdict.good, *verdict.line_good)
    return tuple(name for name, good in zip(names, probabilities, strict=False) if good < _WRONG_BELOW)


def _next_pick(
    found: CalibratedCamera | GroundHomography, verdict: PickVerdict, picks: PicksFile, hd_map: HdMap | None
) -> tuple[str, float] | None:
    """The map's point that would help most, and the standard deviation (m) that places on the road would lose."""
    named = _map_points(hd_map) if hd_map else []
    free = [(name, place) for name, place in named if name not in picks.points.names]
    if not free:
        return None
    road = picks.points.points_m[np.abs(picks.points.points_m[:, 2]) < 1.0][:, :2]
    gain = gains(found, np.array([place for _, place in free]), road, sigma_px=verdict.noise_px)
    if gain.best is None:
        return None
    lost = np.sqrt(gain.now_m2) - np.sqrt(max(gain.now_m2 - float(gain.drops_m2[gain.best]), 0.0))
    return free[gain.best][0], float(lost)


def _map_points(hd_map: HdMap) -> list[tuple[str, FloatArray]]:
    """Every point, and every corner of paint, that an image can show, under the name that a pick gives it."""
    points: list[tuple[str, FloatArray]] = []
    for feature in hd_map.features():
        match feature:
            case Sign() | Signal() | RoadMark() | Facility():
                points.append((feature.id, feature.position_m))
            case LaneMarking() | StopLine():
                points += _corners(feature.id, feature.points_m)
            case PaintedArea():
                points += _corners(feature.id, feature.ring_m)
    return points


def _corners(name: str, places: FloatArray) -> list[tuple[str, FloatArray]]:
    return [(f"{name}#{number}", place) for number, place in enumerate(places, start=1)]
