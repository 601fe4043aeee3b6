"""A small run with truth, tracks and painted images, made without the simulator: roofs are filled polygons."""

from dataclasses import replace

import cv2
import numpy as np

from bench.ledger import ledger_of
from bench.recording import Manifest, RecordedStep, Recording
from bench.recording_file import Recorder
from bench.roofs import roof_quads_px
from contracts import Camera, Detections, Frame, GroundTracks, Intrinsics, Pose, Tracks
from contracts.truth import CameraTruth, Step, Truth
from georef.motion import WindowAnalyst

COLOURS_BGR = {"red": (40, 40, 210), "blue": (210, 70, 30)}
SIZE_M = (0.12, 0.06, 0.06)
PERIOD_NS = 40_000_000


def overhead_camera(name="west", x_m=0.0, distortion=(0.05, -0.02, 0.0, 0.0, 0.0)):
    """2.8 m above the floor, looking straight down, image up = north."""
    pose = Pose(np.diag([1.0, -1.0, -1.0]), np.array([x_m, 0.0, 2.8]))
    return Camera(name, Intrinsics(320, 180, 500.0, 500.0, 159.5, 89.5, np.array(distortion)), pose)


def truth_at(index, cameras, hidden=1.0):
    """Two vehicles that drive east, one of them ``hidden`` to a share."""
    positions = np.array([[-0.3 + 0.02 * index, 0.1, 0.0], [-0.1 + 0.01 * index, -0.2, 0.0]])
    truth = Truth(
        index,
        index * PERIOD_NS,
        ids=("a", "b"),
        labels=tuple(COLOURS_BGR),
        positions_m=positions,
        headings_rad=np.array([0.0, 0.4]),
        sizes_m=np.tile(SIZE_M, (2, 1)),
        velocities_mps=np.array([[0.5, 0.0], [0.25, 0.0]]),
    )
    return replace(truth, cameras=tuple(_view(truth, camera, hidden) for camera in cameras))


def _view(truth, camera, hidden):
    quads = roof_quads_px(truth, camera)
    boxes = np.concatenate([quads.min(axis=1), quads.max(axis=1)], axis=1)
    return CameraTruth(
        camera.name,
        truth.index,
        truth.time_ns,
        visible_fractions=np.array([1.0, hidden]),
        full_boxes_px=boxes,
        visible_boxes_px=boxes,
        footprints_px=quads.mean(axis=1),
        roofs_px=quads.mean(axis=1),
    )


def painted(truth, camera):
    image = np.full((camera.intrinsics.height_px, camera.intrinsics.width_px, 3), 128, np.uint8)
    for label, quad in zip(truth.labels, roof_quads_px(truth, camera), strict=True):
        cv2.fillConvexPoly(image, np.round(quad).astype(np.int32), COLOURS_BGR[label])
    return Frame(camera.name, truth.index, truth.time_ns, image)


def perfect_tracks(truth, camera):
    view = next(view for view in truth.cameras if view.camera == camera.name)
    objects = Detections(
        camera.name,
        truth.index,
        truth.time_ns,
        labels=truth.labels,
        scores=np.array([1.0, 0.5]),
        boxes_px=view.visible_boxes_px,
        quads_px=roof_quads_px(truth, camera),
        anchors_px=view.roofs_px,
        anchor_heights_m=np.full(2, SIZE_M[2]),
        anchor_covs_px2=np.tile(np.eye(2), (2, 1, 1)),
    )
    return Tracks([0, 7], objects)


def perfect_ground(truth, source):
    return GroundTracks(
        source, truth.time_ns, [0, 7], truth.labels, truth.positions_m[:, :2], np.zeros((2, 2, 2)), [True, True]
    )


def filmless_run(steps=4, hidden=1.0, geo=None):
    """(Recording, frames of every step)."""
    cameras = (overhead_camera(), overhead_camera("east", 0.4))
    manifest = Manifest("painted", "Painted roofs", "rail", 3, 25.0, {}, (), {}, None, cameras, (), geo)
    analyst = WindowAnalyst()
    moments = [_moment(truth_at(index, cameras, hidden), cameras, analyst) for index in range(steps)]
    return Recording(manifest, tuple(step for step, _ in moments)), tuple(frames for _, frames in moments)


def _moment(truth, cameras, analyst):
    frames = tuple(painted(truth, camera) for camera in cameras)
    tracks = tuple(perfect_tracks(truth, camera) for camera in cameras)
    views = tuple(perfect_ground(truth, camera.name) for camera in cameras)
    ledger = ledger_of(Step(frames, truth), tracks, views)
    fused = perfect_ground(truth, "fused")
    step = RecordedStep(truth.index, truth.time_ns, truth, tracks, views, fused, analyst.analyse(fused), ledger)
    return step, frames


def record(directory, run, *, keep_frames=True):
    recording, frames = run
    with Recorder(directory, recording.manifest, keep_frames=keep_frames) as recorder:
        for step, images in zip(recording.steps, frames, strict=True):
            recorder.write(step, images)
    return directory
