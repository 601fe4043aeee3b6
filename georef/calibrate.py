"""The whole calibration of one camera, from its own images and what its owner knows."""

from collections.abc import Sequence

from contracts import CalibrationError, Camera, Checkerboard, FloatArray, Frame
from georef.calibrated import CalibratedCamera
from georef.control_points import find_marks_in
from georef.intrinsics import IntrinsicCalibration, calibrate_intrinsics
from georef.labelling import Departure, label
from georef.pose import calibrate_pose


def calibrate(
    nominal: Camera,
    board_views: Sequence[Frame],
    board: Checkerboard,
    frames: Frame | Sequence[Frame],
    control_points_m: FloatArray,
    *,
    departure: Departure | None = None,
) -> CalibratedCamera:
    """Calibrate a camera: Zhang's method for lens and K, control points for the pose, both together at the end.

    nominal: where the camera should be; its intrinsics are not used.
    frames: one view of the plant, or several of the unmoved camera, whose marks are averaged.
    control_points_m: (N, 3) places of the yellow marks in the world.
    departure: how far the camera may stand from ``nominal``.
    Raises CalibrationError, with the reason, where the images do not determine the camera.
    """
    return calibrate_with_lens(
        nominal, lens_of(nominal, board_views, board), frames, control_points_m, departure=departure
    )


def lens_of(nominal: Camera, board_views: Sequence[Frame], board: Checkerboard) -> IntrinsicCalibration:
    """The first half of ``calibrate``, for which no view of the plant is needed."""
    try:
        return calibrate_intrinsics(board_views, board)
    except CalibrationError as error:
        raise CalibrationError(f'camera "{nominal.name}": {error}') from error


def calibrate_with_lens(
    nominal: Camera,
    lens: IntrinsicCalibration,
    frames: Frame | Sequence[Frame],
    control_points_m: FloatArray,
    *,
    departure: Departure | None = None,
) -> CalibratedCamera:
    """The second half of ``calibrate``, with the lens known from its board views."""
    marks_px = find_marks_in([frames] if isinstance(frames, Frame) else list(frames))
    start = Camera(nominal.name, lens.intrinsics, nominal.pose)
    labelled = label(start, marks_px, control_points_m, departure)
    return calibrate_pose(labelled.camera, lens.covariance, control_points_m[labelled.points], marks_px[labelled.marks])
