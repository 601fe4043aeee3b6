"""A first camera from picks some of which are wrong, without any guess of where it stands."""

import cv2
import numpy as np

from contracts import CalibrationError, Camera, FloatArray, Intrinsics, Pose
from georef.camera_models import centre_px
from georef.picks import PointPicks

_FOCAL_SHARES = np.geomspace(0.4, 5.0, 12)  # of the image's width: 103 to 11 degrees across
_SAMPLES = 60  # one of them is free of wrong picks with probability 1 - 1e-6 if 30 % are wrong
_SAMPLE_SIZE = 4
_CORE_SHARE = 0.005  # of the image's width: residuals that a camera without lens leaves with good picks
_KEPT = 4


def first_cameras(
    name: str, picks: PointPicks, width_px: int, height_px: int, rng: np.random.Generator
) -> list[Camera]:
    """The few most likely cameras without lens, principal point at the centre, best first.

    Random samples of four picks, a pose for each at each of several focal lengths (SQPnP: Terzakis & Lourakis 2020),
    judged by all picks with a heavy-tailed loss (MLESAC: Torr & Zisserman 2000).
    Raises CalibrationError if none has the picks before it.
    """
    origin = picks.points_m.mean(axis=0)
    points, centre = picks.points_m - origin, centre_px(width_px, height_px)
    core = _CORE_SHARE * width_px
    samples = [rng.choice(len(picks), _SAMPLE_SIZE, replace=False) for _ in range(_SAMPLES)]
    found: list[tuple[float, Camera]] = []
    for focal in _FOCAL_SHARES * width_px:
        normalised = (picks.pixels - centre) / focal
        poses = [pose for sample in samples if (pose := _pose(points[sample], normalised[sample])) is not None]
        if not poses:
            continue
        turns, shifts = np.stack([turn for turn, _ in poses]), np.stack([shift for _, shift in poses])
        losses = _losses(points @ np.swapaxes(turns, 1, 2) + shifts[:, None], normalised, focal, core)
        above = np.einsum("sji,sj->si", turns, -shifts)[:, 2] + origin[2] > 0
        best = int(np.where(above, losses, np.inf).argmin())
        if above[best]:
            numbers = float(focal), float(focal), float(centre[0]), float(centre[1])
            intrinsics = Intrinsics(width_px, height_px, *numbers, np.zeros(5))
            stands = Pose(turns[best].T, origin - turns[best].T @ shifts[best])
            found.append((float(losses[best]), Camera(name, intrinsics, stands)))
    if not found:
        raise CalibrationError("no camera above the ground has the picked points before it: check pixels and places")
    found.sort(key=lambda candidate: candidate[0])
    return [camera for _, camera in found[:_KEPT]]


def _pose(points: FloatArray, normalised: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    try:
        found, turn, shift = cv2.solvePnP(points, normalised, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP)
    except cv2.error:  # a sample on a line
        return None
    if not found or not (np.isfinite(turn).all() and np.isfinite(shift).all()):
        return None
    return np.asarray(cv2.Rodrigues(turn)[0], dtype=np.float64), np.asarray(shift[:, 0], dtype=np.float64)


def _losses(in_camera: FloatArray, normalised: FloatArray, focal: float, core: float) -> FloatArray:
    """(S,) of points (S, N, 3) in S cameras; a pick behind the camera costs as much as a far one."""
    depth = in_camera[..., 2]
    image = in_camera[..., :2] / np.where(depth > 0, depth, np.nan)[..., None]
    squares = focal**2 * ((image - normalised) ** 2).sum(axis=-1)
    losses: FloatArray = np.log1p(np.nan_to_num(squares, nan=focal**2) / core**2).sum(axis=-1)
    return losses
