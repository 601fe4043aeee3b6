"""Table 1 of paper R: the calibrated cameras; beside them, since the bench knows them, the true ones.

The paper's world axes are the camera's own: x right, y down in the picture, z down into the scene. Its vectors are
OpenCV's: a point of the world goes to ``Rodrigues(rotation) point + translation`` in the camera.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from bench.recording import Manifest
from bench.scores import Score
from bench.scoring.calibration import calibration_scores
from bench.tables.part import Grid, Part, number
from contracts import Camera, FloatArray

WORLD_FROM_PAPER = np.diag([1.0, -1.0, -1.0])  # y and z turned over
PAPER = (
    (4380.7, 4378.2, 1005.9, 697.02, -0.02823308, 0.08623225, 0.01563199, -5.47884374, -3.08581371, 24.15112048),
    (4463.6, 4464.2, 956.39, 664.47, -0.04811656, -0.11802668, -0.11802668, -8.95359027, -3.01504595, 24.83908461),
)
NAMES = ("fx, px", "fy, px", "cx, px", "cy, px", "r1", "r2", "r3", "t1, m", "t2, m", "t3, m")
FORMS = (".2f", ".2f", ".2f", ".2f", ".5f", ".5f", ".5f", ".4f", ".4f", ".4f")


def table1(manifests: Sequence[Manifest]) -> Part:
    """The cameras of the first sequence in full; of all sequences, how far each is from the truth."""
    first = manifests[0]
    calibrated = {one.camera.name: one.camera for one in first.calibrated_cameras}
    grids = [
        _parameters(camera, calibrated[camera.name], PAPER[k] if k < len(PAPER) else None)
        for k, camera in enumerate(first.true_cameras)
        if camera.name in calibrated
    ]
    scores = [score for manifest in manifests for score in _scores(manifest)]
    says = (
        f"The cameras of “{first.scenario}” as calibrated from the checkerboard and the marks on its own first "
        "frame, beside the true ones, in the paper's axes (z down). Focal length and height trade against each "
        "other for a camera that looks straight down; the last table says what that leaves on image and floor, for "
        "every sequence. The paper's cameras are others, and its translation is in a unit that it does not name "
        "(2.8 m of height are 24 of it); it prints camera 2's r2 twice."
    )
    return Part("table1", "Table 1: calibration", says, (*grids, _errors(manifests)), scores=tuple(scores))


def in_paper_axes(camera: Camera) -> FloatArray:
    """(10,) fx, fy, cx, cy, rotation vector, translation, as ``NAMES``."""
    camera_from_paper = camera.pose.world_from_camera.T @ WORLD_FROM_PAPER
    rotation, _ = cv2.Rodrigues(camera_from_paper)
    translation = -camera.pose.world_from_camera.T @ camera.pose.position_m
    lens = camera.intrinsics
    return np.array([lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px, *rotation.ravel(), *translation])


def _parameters(truth: Camera, estimate: Camera, paper: Sequence[float] | None) -> Grid:
    true, found = in_paper_axes(truth), in_paper_axes(estimate)
    rows = tuple(
        (
            name,
            number(found[k], form),
            number(true[k], form),
            number(found[k] - true[k], f"+{form}"),
            number(paper[k] if paper else None, form),
        )
        for k, (name, form) in enumerate(zip(NAMES, FORMS, strict=True))
    )
    return Grid((f"camera {truth.name}", "estimated", "true", "error", "paper's camera"), rows)


def _scores(manifest: Manifest) -> list[Score]:
    cameras = tuple(camera.name for camera in manifest.true_cameras)
    return [
        Score(f"table1.{manifest.scenario}.{one.name}", one.value, one.unit, one.n, one.valid)
        for one in calibration_scores(manifest, cameras)
    ]


def _errors(manifests: Sequence[Manifest]) -> Grid:
    rows = []
    for manifest in manifests:
        value = {score.name: score.value for score in _scores(manifest)}
        for camera in manifest.true_cameras:
            prefix = f"table1.{manifest.scenario}.calibration.{camera.name}"
            rows.append(
                (
                    manifest.scenario,
                    camera.name,
                    number(value[f"{prefix}.focal_error_px"]),
                    number(value[f"{prefix}.rotation_error_rad"], ".2f", 1e3),
                    number(value[f"{prefix}.position_error_m"], ".2f", 1e3),
                    number(value[f"{prefix}.reprojection_rms_px"], ".3f"),
                    number(value[f"{prefix}.ground_rms_m"], ".3f", 1e3),
                )
            )
    head = ("sequence", "camera", "focal, px", "rotation, mrad", "position, mm", "on the image, px", "on the floor, mm")
    return Grid(head, tuple(rows))
