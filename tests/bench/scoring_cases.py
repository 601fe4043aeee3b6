"""Recordings without a simulator: a recording of the truth itself, and ways to injure it."""

from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
from hypothesis import strategies as st

from bench.recording import Manifest, RecordedStep, Recording
from contracts import Camera, Detections, FloatArray, GroundTracks, Intrinsics, Motions, MotionState, Pose, Tracks
from contracts.motion import compass
from contracts.truth import CameraTruth, Truth
from georef.calibrated import CalibratedCamera

SIZE_M = np.array([0.12, 0.06, 0.06])
LOOKING_DOWN = np.diag([1.0, -1.0, -1.0])
VELOCITY_MPS = np.array([0.25, 0.0])
COLOURS = ("blue", "red", "green", "yellow", "purple", "orange")
LENS = np.array([-0.1, 0.05, 0.001, -0.001, 0.0])


def camera(name: str, position_m: tuple[float, float, float], *, tilt_rad: float = 0.02) -> Camera:
    tilt, _ = cv2.Rodrigues(np.array([tilt_rad, -tilt_rad, 0.01]))
    return Camera(
        name,
        Intrinsics(1280, 720, 1400.0, 1400.0, 641.0, 357.0, LENS),
        Pose(tilt @ LOOKING_DOWN, np.array(position_m)),
    )


def project(camera: Camera, points_m: FloatArray) -> FloatArray:
    """OpenCV's own projection, (N, 2)."""
    rotation = camera.pose.world_from_camera.T
    vector, _ = cv2.Rodrigues(rotation)
    moved = -rotation @ camera.pose.position_m
    pixels, _ = cv2.projectPoints(points_m, vector, moved, camera.intrinsics.matrix, camera.intrinsics.distortion)
    return pixels.reshape(-1, 2)


def truth_of_camera(camera: Camera, index: int, time_ns: int, positions_m: FloatArray) -> CameraTruth:
    """Every object wholly visible."""
    roofs_px = project(camera, positions_m + np.array([0.0, 0.0, SIZE_M[2]]))
    boxes_px = np.hstack([roofs_px - 30, roofs_px + 30])
    ones = np.ones(len(positions_m))
    return CameraTruth(camera.name, index, time_ns, ones, boxes_px, boxes_px, project(camera, positions_m), roofs_px)


def tracks_of_truth(view: CameraTruth, labels: tuple[str, ...]) -> Tracks:
    n = len(labels)
    boxes = view.full_boxes_px
    detections = Detections(
        camera=view.camera,
        index=view.index,
        time_ns=view.time_ns,
        labels=labels,
        scores=np.ones(n),
        boxes_px=boxes,
        quads_px=np.stack([boxes[:, [0, 1]], boxes[:, [2, 1]], boxes[:, [2, 3]], boxes[:, [0, 3]]], axis=1),
        anchors_px=view.roofs_px,
        anchor_heights_m=np.full(n, SIZE_M[2]),
        anchor_covs_px2=np.tile(np.eye(2) * 0.25, (n, 1, 1)),
    )
    return Tracks(np.arange(n) + 1, detections)


def ground_of_truth(source: str, truth: Truth) -> GroundTracks:
    n = len(truth.ids)
    return GroundTracks(
        source=source,
        time_ns=truth.time_ns,
        ids=np.arange(n) + 1,
        labels=truth.labels,
        positions_m=truth.positions_m[:, :2],
        covs_m2=np.tile(np.eye(2) * 1e-6, (n, 1, 1)),
        valid=np.ones(n, dtype=bool),
    )


def motions_of_truth(truth: Truth) -> Motions:
    """The true velocities; no vehicle stands."""
    n = len(truth.ids)
    headings_rad = np.arctan2(truth.velocities_mps[:, 1], truth.velocities_mps[:, 0])
    return Motions(
        time_ns=truth.time_ns,
        ids=np.arange(n) + 1,
        labels=truth.labels,
        velocities_mps=truth.velocities_mps,
        velocity_covs_m2ps2=np.tile(np.eye(2) * 1e-4, (n, 1, 1)),
        states=(MotionState.MOVING,) * n,
        directions=tuple(compass(heading_rad) for heading_rad in headings_rad.tolist()),
        valid=np.ones(n, dtype=bool),
    )


def perfect_step(index: int, positions_m: FloatArray, cameras: tuple[Camera, ...]) -> RecordedStep:
    n = len(positions_m)
    time_ns = index * 40_000_000
    views = tuple(truth_of_camera(camera, index, time_ns, positions_m) for camera in cameras)
    truth = Truth(
        index=index,
        time_ns=time_ns,
        ids=tuple(f"vehicle {k}" for k in range(n)),
        labels=COLOURS[:n],
        positions_m=positions_m,
        headings_rad=np.zeros(n),
        sizes_m=np.tile(SIZE_M, (n, 1)),
        velocities_mps=np.tile(VELOCITY_MPS, (n, 1)),
        cameras=views,
    )
    return RecordedStep(
        index=index,
        time_ns=time_ns,
        truth=truth,
        tracks=tuple(tracks_of_truth(view, truth.labels) for view in views),
        views=tuple(ground_of_truth(view.camera, truth) for view in views),
        fused=ground_of_truth("fused", truth),
        motions=motions_of_truth(truth),
        ledger=(),
    )


def perfect_recording(*, steps: int = 5, vehicles: int = 3, cameras: int = 2, phase_m: float = 0.0) -> Recording:
    """A recording whose estimates are the truth: vehicles half a metre apart that drive east at 0.25 m/s."""
    west_east = (camera("west", (-0.5, 0.0, 2.8)), camera("east", (0.5, 0.1, 2.8)))[:cameras]
    lattice = np.array([[0.5 * (k % 3) - 0.6, 0.5 * (k // 3) - 0.3, 0.0] for k in range(vehicles)]).reshape(-1, 3)
    moved = (lattice + np.array([phase_m + 0.01 * k, 0.0, 0.0]) for k in range(steps))
    manifest = Manifest(
        scenario="synthetic",
        title="The truth itself",
        world="rail",
        seed=0,
        fps=25.0,
        stages={"detector": "tests"},
        oracles=(),
        versions={},
        survey=None,
        true_cameras=west_east,
        calibrated_cameras=tuple(CalibratedCamera(camera, np.zeros((15, 15))) for camera in west_east),
    )
    return Recording(manifest, tuple(perfect_step(k, xyz, west_east) for k, xyz in enumerate(moved)))


def perfect_recordings(*, min_vehicles: int = 1, min_steps: int = 1) -> st.SearchStrategy[Recording]:
    return st.builds(
        perfect_recording,
        steps=st.integers(min_steps, 6),
        vehicles=st.integers(min_vehicles, 6),
        cameras=st.integers(1, 2),
        phase_m=st.floats(-0.2, 0.2),
    )


def edit_ground(recording: Recording, edit: Callable[[GroundTracks], GroundTracks]) -> Recording:
    """``edit`` done to the ground tracks of every camera and to the fused ones."""
    steps = (
        replace(step, views=tuple(edit(view) for view in step.views), fused=edit(step.fused))
        for step in recording.steps
    )
    return Recording(recording.manifest, tuple(steps))


def edit_tracks(recording: Recording, edit: Callable[[Tracks], Tracks]) -> Recording:
    """``edit`` done to the tracks of every camera."""
    steps = (replace(step, tracks=tuple(edit(tracks) for tracks in step.tracks)) for step in recording.steps)
    return Recording(recording.manifest, tuple(steps))


def edit_truth(recording: Recording, edit: Callable[[Truth], Truth]) -> Recording:
    steps = (replace(step, truth=edit(step.truth)) for step in recording.steps if step.truth is not None)
    return Recording(recording.manifest, tuple(steps))


def take(ground: GroundTracks, rows: object) -> GroundTracks:
    """The given rows in the given order."""
    rows = np.asarray(rows, dtype=int)
    return replace(
        ground,
        ids=ground.ids[rows],
        labels=tuple(ground.labels[k] for k in rows),
        positions_m=ground.positions_m[rows],
        covs_m2=ground.covs_m2[rows],
        valid=ground.valid[rows],
    )


def shifted(ground: GroundTracks, offset_m: FloatArray) -> GroundTracks:
    return replace(ground, positions_m=ground.positions_m + offset_m)


def with_ghost(ground: GroundTracks, position_m: tuple[float, float]) -> GroundTracks:
    """One estimate more, where nothing is."""
    return replace(
        ground,
        ids=np.append(ground.ids, 1000),
        labels=(*ground.labels, "ghost"),
        positions_m=np.vstack([ground.positions_m, position_m]),
        covs_m2=np.concatenate([ground.covs_m2, np.eye(2)[None] * 1e-6]),
        valid=np.append(ground.valid, True),
    )
