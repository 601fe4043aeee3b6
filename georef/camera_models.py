"""Two cameras that map points can calibrate: the whole one, and the traffic paper's with pan and tilt only."""

from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from contracts import Camera, FloatArray, InputError, Intrinsics, Pose
from georef.calibrated import PARAMETERS
from georef.line_picks import across_lines
from georef.mixture import Observed
from georef.picks import LinePicks, PointPicks
from georef.projection import project_with_derivatives
from georef.refinement import moved_camera

_LEAST_FOCAL_PX = 1.0
_USUAL_K1 = -0.2


@dataclass(frozen=True)
class Beliefs:
    """What an owner knows of a camera before any pick; standard deviations, None for nothing known.

    principal_point_share: how far the principal point may lie from the image's centre, as a share of the width.
    k1, k2: how strong the lens may be; surveillance lenses lie within -0.4 .. 0.1.
    tangential: p1 and p2, how badly its glass may be centred; for ``FullState.tangential`` only.
    height_m, height_sigma_m: of the optical centre above the map's z = 0.
    position_m, position_sigma_m: of the optical centre, where the pole has been surveyed; per axis.
    focal_px, focal_share: the data sheet's focal length, and its error as a share of it; for the whole camera only.
    """

    principal_point_share: float = 0.02
    k1: float = 0.3
    k2: float = 0.2
    tangential: float = 0.0005
    height_m: float | None = None
    height_sigma_m: float = 0.5
    position_m: tuple[float, float, float] | None = None
    position_sigma_m: float = 0.1
    focal_px: float | None = None
    focal_share: float = 0.01

    def __post_init__(self) -> None:
        lens = (self.principal_point_share, self.k1, self.k2, self.tangential, self.focal_share)
        sigmas = (*lens, self.height_sigma_m, self.position_sigma_m)
        if not (np.isfinite(sigmas).all() and min(sigmas) > 0):
            raise InputError(f"Beliefs: the standard deviations {sigmas} must be positive")


def centre_px(width_px: int, height_px: int) -> FloatArray:
    """The image's centre (2,), the first pixel's centre being (0, 0)."""
    return np.array([width_px - 1, height_px - 1]) / 2


class CameraState(Protocol):
    """What a fit moves: a camera with fewer free parameters than the fifteen."""

    @property
    def camera(self) -> Camera:
        """As a camera."""
        ...

    @property
    def by_free(self) -> FloatArray:
        """(15, p) how ``georef.calibrated.PARAMETERS`` move with the free parameters."""
        ...

    def moved(self, step: FloatArray) -> Self:
        """After a step (p,)."""
        ...

    def beliefs(self, beliefs: Beliefs) -> tuple[FloatArray, FloatArray]:
        """Residuals (q,) in standard deviations and derivatives (q, p)."""
        ...


_FULL = np.zeros((len(PARAMETERS), 11))  # f, cx, cy, k1, k2, rx, ry, rz, x, y, z
_FULL[[0, 1], 0] = 1.0
_FULL[[2, 3, 4, 5, 9, 10, 11, 12, 13, 14], np.arange(1, 11)] = 1.0
_WITH_TANGENTIAL = np.insert(_FULL, [5], np.eye(len(PARAMETERS))[:, 6:8], axis=1)  # p1, p2 after k2


@dataclass(frozen=True, eq=False)
class FullState:
    """The whole camera: square pixels, principal point, k1, k2, and its pose in six parameters.

    tangential: whether p1 and p2 are free too; picks by hand are too coarse to tell them.
    """

    camera: Camera
    tangential: bool = False

    @classmethod
    def near(cls, camera: Camera) -> tuple["FullState", "FullState"]:
        """Starts with no lens and with a usual one: from either alone, strong lenses may be missed."""
        k = camera.intrinsics
        usual = replace(k, distortion=np.array([_USUAL_K1, 0.0, 0.0, 0.0, 0.0]))
        return cls(camera), cls(replace(camera, intrinsics=usual))

    @property
    def by_free(self) -> FloatArray:
        """(15, 11), or (15, 13)."""
        return _WITH_TANGENTIAL if self.tangential else _FULL

    def moved(self, step: FloatArray) -> "FullState":
        """After a step (11,) in f, cx, cy, k1, k2, rotation, position; (13,) with p1, p2 after k2."""
        return replace(self, camera=moved_camera(self.camera, self.by_free @ step))

    def beliefs(self, beliefs: Beliefs) -> tuple[FloatArray, FloatArray]:
        """Principal point, lens, focal length and place."""
        k = self.camera.intrinsics
        offset = np.array([k.cx_px, k.cy_px]) - centre_px(k.width_px, k.height_px)
        sigmas = np.array([*2 * [beliefs.principal_point_share * k.width_px], beliefs.k1, beliefs.k2])
        if self.tangential:
            sigmas = np.append(sigmas, 2 * [beliefs.tangential])
        size, parameters = len(sigmas), self.by_free.shape[1]
        residuals = np.concatenate([offset, k.distortion])[:size] / sigmas
        rows = np.zeros((size, parameters))
        rows[np.arange(size), np.arange(1, size + 1)] = 1 / sigmas
        if beliefs.focal_px is not None:
            sigma_px = beliefs.focal_share * beliefs.focal_px
            residuals = np.append(residuals, (k.fx_px - beliefs.focal_px) / sigma_px)
            rows = np.concatenate([rows, np.eye(parameters)[:1] / sigma_px])
        return _with_place(residuals, rows, self.camera, beliefs)


@dataclass(frozen=True, eq=False)
class PanTiltState:
    """The traffic paper's camera: world_from_camera = Rz(pan) Rx(tilt), principal point at the centre, no lens.

    pan_rad: of the image's right from east, counter-clockwise. tilt_rad: -pi / 2 looks to the horizon, -pi straight
    down. The last entry of the paper's printed matrix is cos(tilt), not sin.
    """

    name: str
    width_px: int
    height_px: int
    focal_px: float
    pan_rad: float
    tilt_rad: float
    position_m: FloatArray

    @classmethod
    def near(cls, camera: Camera) -> tuple["PanTiltState"]:
        """With the focal length, place and viewing direction of ``camera``."""
        k, ahead = camera.intrinsics, camera.pose.world_from_camera[:, 2]
        pan, tilt = np.arctan2(-ahead[0], ahead[1]), -np.arctan2(np.hypot(ahead[0], ahead[1]), ahead[2])
        focal = (k.fx_px + k.fy_px) / 2
        return (cls(camera.name, k.width_px, k.height_px, focal, float(pan), float(tilt), camera.pose.position_m),)

    @property
    def camera(self) -> Camera:
        """As a camera."""
        centre = centre_px(self.width_px, self.height_px)
        numbers = self.focal_px, self.focal_px, float(centre[0]), float(centre[1])
        intrinsics = Intrinsics(self.width_px, self.height_px, *numbers, np.zeros(5))
        return Camera(self.name, intrinsics, Pose(_pan_tilt(self.pan_rad, self.tilt_rad), self.position_m))

    @property
    def by_free(self) -> FloatArray:
        """(15, 6): the pan turns about the world's z, the tilt about the image's own right."""
        columns = np.zeros((len(PARAMETERS), 6))
        columns[[0, 1], 0] = 1.0
        columns[11, 1] = 1.0
        columns[[9, 10], 2] = np.cos(self.pan_rad), np.sin(self.pan_rad)
        columns[[12, 13, 14], [3, 4, 5]] = 1.0
        return columns

    def moved(self, step: FloatArray) -> "PanTiltState":
        """After a step (6,) in f, pan, tilt, position."""
        focal = max(self.focal_px + float(step[0]), _LEAST_FOCAL_PX)
        pan, tilt = self.pan_rad + float(step[1]), self.tilt_rad + float(step[2])
        return PanTiltState(self.name, self.width_px, self.height_px, focal, pan, tilt, self.position_m + step[3:])

    def beliefs(self, beliefs: Beliefs) -> tuple[FloatArray, FloatArray]:
        """Place alone."""
        return _with_place(np.empty(0), np.empty((0, 6)), self.camera, beliefs)


def _pan_tilt(pan_rad: float, tilt_rad: float) -> FloatArray:
    """Rz(pan) Rx(tilt)."""
    cp, sp, ct, st = np.cos(pan_rad), np.sin(pan_rad), np.cos(tilt_rad), np.sin(tilt_rad)
    return np.array([[cp, -sp * ct, sp * st], [sp, cp * ct, -cp * st], [0.0, st, ct]])


def _with_place(
    residuals: FloatArray, rows: FloatArray, camera: Camera, beliefs: Beliefs
) -> tuple[FloatArray, FloatArray]:
    """With the beliefs in the camera's height and place, whose parameters are the last three, if there are any."""
    by_place, here = np.eye(rows.shape[1])[-3:], camera.pose.position_m
    if beliefs.height_m is not None:
        residuals = np.append(residuals, (here[2] - beliefs.height_m) / beliefs.height_sigma_m)
        rows = np.concatenate([rows, by_place[2:] / beliefs.height_sigma_m])
    if beliefs.position_m is not None:
        residuals = np.append(residuals, (here - beliefs.position_m) / beliefs.position_sigma_m)
        rows = np.concatenate([rows, by_place / beliefs.position_sigma_m])
    return residuals, rows


@dataclass(frozen=True, eq=False)
class CameraModel:
    """How picks look through a camera; implements ``georef.mixture.Model``."""

    points: PointPicks
    lines: LinePicks
    knowledge: Beliefs

    def observe(self, state: CameraState) -> tuple[Observed, ...]:
        """Points, and lines if any were picked."""
        camera, by_free = state.camera, state.by_free
        seen = project_with_derivatives(camera, self.points.points_m)
        points = Observed(
            seen.pixels - self.points.pixels,
            seen.by_parameters @ by_free,
            np.nan_to_num(self.points.sigmas_m[:, None, None] ** 2 * seen.by_point @ np.swapaxes(seen.by_point, 1, 2)),
        )
        return (points, across_lines(camera, by_free, self.lines)) if len(self.lines) else (points,)

    def beliefs(self, state: CameraState) -> tuple[FloatArray, FloatArray]:
        """What was known beforehand."""
        return state.beliefs(self.knowledge)

    def move(self, state: CameraState, step: FloatArray) -> CameraState:
        """After a step in the free parameters."""
        return state.moved(step)
