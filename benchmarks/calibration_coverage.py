"""Do the stated ellipses hold? Positions inside their own 90 % ellipse, over many independent calibrations.

    python -m benchmarks.calibration_coverage [--filmed 24 --drawn 200 --json]

The calibration's error is common to a whole run, so that one run proves nothing. Here every calibration has its own
true camera, boards and noise. Some are *filmed*: board views and a first frame, corners and marks found in them. The
rest are *drawn*: exact corners and marks with the Gaussian noise measured on the filmed ones, sent through the same
estimators. Each is judged at points spread over the image, at a roof's height: the error of the position that the
calibration places there, against the covariance that it states. Once with exact anchors, so that the calibration
stands alone, and once with anchors as noisy as they claim to be.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from bench.scores import Score, to_json
from contracts import Camera, Checkerboard, FloatArray, Survey
from georef.calibrated import CalibratedCamera
from georef.control_points import find_marks
from georef.intrinsics import IntrinsicCalibration, calibrate_from_corners, calibrate_intrinsics
from georef.labelling import label
from georef.location import place
from georef.pose import calibrate_pose
from scenarios.loader import build_world, load_scenario
from sim.board import board_poses
from sim.projection import project
from sim.streams import stream

SCENARIO = "oval-two-vehicles"
ROOF_M = 0.06
ANCHOR_SIGMA_PX = 0.15
CHI2_90 = 4.605170185988092  # two degrees of freedom
FIRST_FILMED_SEED, FIRST_DRAWN_SEED = 5_000, 6_000
OWN_MARK_PX = 1.0  # a found mark is the control point whose true image is this near
EDGE_PX = 8.0  # a drawn mark nearer to the image's border than this would not be found whole


@dataclass(frozen=True, eq=False)
class Trial:
    """One calibration of one camera.

    calibration, whole: share of places inside their 90 % ellipse with exact and with noisy anchors.
    corner_noise_px: as the board's residuals say. mark_errors_px: (N, 2) found less true.
    """

    calibration: float
    whole: float
    corner_noise_px: float
    mark_errors_px: FloatArray


def filmed(seed: int) -> list[Trial]:
    """Calibrate both cameras of a world from what they film."""
    scenario = load_scenario(SCENARIO)
    world = build_world(replace(scenario, duration_s=1 / scenario.fps), seed=seed)
    frames = {frame.camera: frame for frame in next(iter(world.steps())).frames}
    trials = []
    for true in world.cameras:
        lens = calibrate_intrinsics(tuple(world.board_views(true.name)), world.survey.board)
        marks_px = find_marks(frames[true.name])
        exact_px, in_field = project(true, world.survey.control_points_m)
        apart = marks_px[:, None] - exact_px[in_field][None]  # (marks, points, 2)
        nearest = np.linalg.norm(apart, axis=-1).argmin(axis=1)
        errors_px = apart[np.arange(len(marks_px)), nearest]
        errors_px = errors_px[np.linalg.norm(errors_px, axis=1) < OWN_MARK_PX]
        trials.append(_judged(true, _finished(true.name, lens, marks_px, world.survey), seed, lens, errors_px))
    return trials


def drawn(seed: int, corner_noise_px: float, mark_noise_px: float) -> list[Trial]:
    """Calibrate both cameras of a world from exact corners and marks with noise added."""
    world = build_world(load_scenario(SCENARIO), seed=seed, film=False)
    trials = []
    for true in world.cameras:
        rng = stream(seed, f"coverage/{true.name}")
        corners_px = _corners(true, world.survey.board, rng)
        corners_px += rng.normal(0.0, corner_noise_px, corners_px.shape)
        size = true.intrinsics
        lens = calibrate_from_corners(corners_px, world.survey.board, size.width_px, size.height_px)
        exact_px, _ = project(true, world.survey.control_points_m)
        edge_px = np.minimum(exact_px, [size.width_px - 1, size.height_px - 1] - exact_px).min(axis=1)
        seen_px = exact_px[edge_px > EDGE_PX]
        errors_px = rng.normal(0.0, mark_noise_px, seen_px.shape)
        calibrated = _finished(true.name, lens, seen_px + errors_px, world.survey)
        trials.append(_judged(true, calibrated, seed, lens, errors_px))
    return trials


def _corners(true: Camera, board: Checkerboard, rng: np.random.Generator) -> FloatArray:
    """Exact images of the board's corners in poses as they are filmed, (views, corners, 2)."""
    in_camera = [pose.corners_in_camera(board) for pose in board_poses(true.intrinsics, board, rng)]
    in_world = [corners @ true.pose.world_from_camera.T + true.pose.position_m for corners in in_camera]
    return np.stack([project(true, corners)[0] for corners in in_world])


def _finished(name: str, lens: IntrinsicCalibration, marks_px: FloatArray, survey: Survey) -> CalibratedCamera:
    nominal = next(camera for camera in survey.cameras if camera.name == name)
    labelled = label(Camera(name, lens.intrinsics, nominal.pose), marks_px, survey.control_points_m)
    points_m = survey.control_points_m[labelled.points]
    return calibrate_pose(labelled.camera, lens.covariance, points_m, marks_px[labelled.marks])


def _judged(
    true: Camera, found: CalibratedCamera, seed: int, lens: IntrinsicCalibration, mark_errors_px: FloatArray
) -> Trial:
    rng = stream(seed, f"coverage/places/{true.name}")
    size = true.intrinsics
    pixels = rng.uniform([20.0, 20.0], [size.width_px - 20.0, size.height_px - 20.0], (50, 2))
    truth_m = place(true, pixels, ROOF_M).positions_m
    shares = []
    for sigma_px in (0.0, ANCHOR_SIGMA_PX):
        placed = place(found.camera, pixels + sigma_px * rng.standard_normal(pixels.shape), ROOF_M)
        errors_m = placed.positions_m - truth_m
        covs_m2 = placed.by_parameters @ found.covariance @ np.swapaxes(placed.by_parameters, 1, 2)
        covs_m2 += sigma_px**2 * placed.by_pixel @ np.swapaxes(placed.by_pixel, 1, 2)
        squares = np.einsum("ni,nij,nj->n", errors_m, np.linalg.inv(covs_m2), errors_m)
        shares.append(float(np.mean(squares <= CHI2_90)))
    return Trial(shares[0], shares[1], lens.corner_noise_px, mark_errors_px)


def measure(filmed_count: int, drawn_count: int) -> list[Score]:
    """All figures; each world holds two independent calibrations."""
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        seen = [t for two in pool.map(filmed, _seeds(FIRST_FILMED_SEED, filmed_count)) for t in two]
        corner_px = float(np.sqrt(np.mean([trial.corner_noise_px**2 for trial in seen])))
        mark_px = float(np.sqrt(np.mean(np.concatenate([trial.mark_errors_px for trial in seen]) ** 2)))
        seeds = _seeds(FIRST_DRAWN_SEED, drawn_count)
        noises = [[px] * len(seeds) for px in (corner_px, mark_px)]
        made = [t for two in pool.map(drawn, seeds, *noises, chunksize=8) for t in two]
    marks = sum(len(trial.mark_errors_px) for trial in seen)
    return [
        Score.of("coverage.corner_noise_px", corner_px, "px", len(seen)),
        Score.of("coverage.mark_noise_px", mark_px, "px", marks),
        *_shares("filmed", seen),
        *_shares("drawn", made),
        *_shares("all", seen + made),
    ]


def _seeds(first: int, calibrations: int) -> range:
    return range(first, first + (calibrations + 1) // 2)


def _shares(name: str, trials: Sequence[Trial]) -> list[Score]:
    n = len(trials)
    return [
        Score.of(f"coverage.{name}_calibration_90", float(np.mean([t.calibration for t in trials])), "1", n),
        Score.of(f"coverage.{name}_90", float(np.mean([t.whole for t in trials])), "1", n),
    ]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--filmed", type=int, default=24, help="calibrations that are filmed")
    parser.add_argument("--drawn", type=int, default=200, help="calibrations that are drawn")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    arguments = parser.parse_args()
    scores = measure(arguments.filmed, arguments.drawn)
    if arguments.json:
        print(to_json(scores))
        return
    for score in scores:
        print(f"{score.name:32} {score.value:8.4f} {score.unit:3} n = {score.n}", file=sys.stdout)


if __name__ == "__main__":
    main()
