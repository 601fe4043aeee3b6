"""Hypothesis strategies for everything that is recorded."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bench.ledger import ledger_of
from bench.recording import Manifest, RecordedStep, Recording
from contracts import (
    Camera,
    Checkerboard,
    Compass,
    Detections,
    Event,
    EventKind,
    Frame,
    GroundTracks,
    Intrinsics,
    Motions,
    MotionState,
    Pose,
    Survey,
    SwitchState,
    Tracks,
)
from contracts.ground import FUSED
from contracts.truth import CameraTruth, Place, Step, Truth
from georef.calibrated import PARAMETERS, CalibratedCamera

NAMES = st.text(st.characters(codec="utf-8", exclude_characters="/"), min_size=1, max_size=8).filter(
    lambda s: s != FUSED
)
WORDS = st.text(max_size=8)
TIMES_NS = st.integers(0, 2**62)
FINITE = st.floats(allow_nan=False, allow_infinity=False)
OR_NAN = st.floats(allow_nan=True, allow_infinity=False)


def arrays(shape, elements=FINITE):
    return hnp.arrays(np.float64, shape, elements=elements)


@st.composite
def boxes(draw, n):
    corners = draw(arrays((n, 2, 2), st.floats(-1e4, 1e4)))
    return np.concatenate([corners.min(axis=1), corners.max(axis=1)], axis=1)  # (n, 4)


@st.composite
def detections(draw, camera="west", index=0, time_ns=0, max_size=4):
    n = draw(st.integers(0, max_size))
    return Detections(
        camera,
        index,
        time_ns,
        labels=tuple(draw(st.lists(WORDS, min_size=n, max_size=n))),
        scores=draw(arrays(n, st.floats(0, 1))),
        boxes_px=draw(boxes(n)),
        quads_px=draw(arrays((n, 4, 2))),
        anchors_px=draw(arrays((n, 2))),
        anchor_heights_m=draw(arrays(n)),
        anchor_covs_px2=draw(arrays((n, 2, 2))),
    )


@st.composite
def tracks(draw, camera="west", index=0, time_ns=0):
    objects = draw(detections(camera, index, time_ns))
    n = len(objects)
    return Tracks(draw(st.lists(st.integers(-(2**63), 2**63 - 1), min_size=n, max_size=n, unique=True)), objects)


@st.composite
def ground_tracks(draw, source="west", time_ns=0):
    n = draw(st.integers(0, 4))
    return GroundTracks(
        source,
        time_ns,
        ids=draw(hnp.arrays(np.int64, n)),
        labels=tuple(draw(st.lists(WORDS, min_size=n, max_size=n))),
        positions_m=draw(arrays((n, 2), OR_NAN)),
        covs_m2=draw(arrays((n, 2, 2), OR_NAN)),
        valid=draw(hnp.arrays(np.bool_, n)),
    )


@st.composite
def motions(draw, ground):
    n = len(ground)
    directions = tuple(draw(st.lists(st.none() | st.sampled_from(Compass), min_size=n, max_size=n)))
    at_rest = st.sampled_from([MotionState.UNKNOWN, MotionState.STANDING])
    return Motions(
        ground.time_ns,
        ground.ids,
        ground.labels,
        velocities_mps=draw(arrays((n, 2), OR_NAN)),
        velocity_covs_m2ps2=draw(arrays((n, 2, 2), OR_NAN)),
        states=tuple(MotionState.MOVING if direction else draw(at_rest) for direction in directions),
        directions=directions,
        valid=draw(hnp.arrays(np.bool_, n)),
    )


@st.composite
def intrinsics(draw):
    sizes = st.integers(1, 4096)
    lengths = st.floats(1, 1e5)
    return Intrinsics(
        draw(sizes), draw(sizes), draw(lengths), draw(lengths), draw(FINITE), draw(FINITE), draw(arrays(5))
    )


@st.composite
def poses(draw):
    quaternion = np.array(draw(st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)))
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    rotation = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return Pose(np.array(rotation), draw(arrays(3)))


@st.composite
def cameras(draw, name="west"):
    return Camera(name, draw(intrinsics()), draw(poses()))


@st.composite
def calibrated_cameras(draw, name="west"):
    return CalibratedCamera(draw(cameras(name)), draw(arrays((len(PARAMETERS), len(PARAMETERS)))))


@st.composite
def surveys(draw, names=("west",)):
    board = Checkerboard(draw(st.integers(3, 20)), draw(st.integers(3, 20)), draw(st.floats(1e-3, 1)))
    lines = tuple(draw(arrays((count, 2))) for count in draw(st.lists(st.integers(2, 4), max_size=2)))
    marks = draw(arrays((draw(st.integers(0, 4)), 3)))
    return Survey(tuple(draw(cameras(name)) for name in names), marks, board, lines)


@st.composite
def manifests(draw, names=("west",)):
    known = draw(st.booleans())
    return Manifest(
        scenario=draw(WORDS),
        title=draw(WORDS),
        world=draw(WORDS),
        seed=draw(st.integers(0, 2**63 - 1)),
        fps=draw(st.floats(1, 1000)),
        stages=draw(st.dictionaries(WORDS, WORDS, max_size=2)),
        oracles=tuple(draw(st.lists(WORDS, max_size=2))),
        versions=draw(st.dictionaries(WORDS, WORDS, max_size=2)),
        survey=draw(surveys(names)) if known else None,
        true_cameras=tuple(draw(cameras(name)) for name in names) if known else (),
        calibrated_cameras=tuple(draw(calibrated_cameras(name)) for name in names),
    )


@st.composite
def camera_truths(draw, n, camera="west", index=0, time_ns=0):
    return CameraTruth(
        camera,
        index,
        time_ns,
        visible_fractions=draw(arrays(n, st.floats(0, 1))),
        full_boxes_px=draw(arrays((n, 4), OR_NAN)),
        visible_boxes_px=draw(arrays((n, 4), OR_NAN)),
        footprints_px=draw(arrays((n, 2), OR_NAN)),
        roofs_px=draw(arrays((n, 2), OR_NAN)),
    )


PLACES = st.none() | st.builds(Place, section=WORDS, offset_m=FINITE, direction=st.sampled_from([-1, 1]))
EVENTS = st.builds(
    Event,
    time_ns=TIMES_NS,
    kind=st.sampled_from(EventKind),
    subjects=st.lists(WORDS, max_size=2).map(tuple),
    detail=WORDS,
)


@st.composite
def truths(draw, names=("west",), index=0, time_ns=0):
    ids = tuple(draw(st.lists(NAMES, max_size=3, unique=True)))
    n = len(ids)
    return Truth(
        index,
        time_ns,
        ids=ids,
        labels=tuple(draw(st.lists(WORDS, min_size=n, max_size=n))),
        positions_m=draw(arrays((n, 3))),
        headings_rad=draw(arrays(n)),
        sizes_m=draw(arrays((n, 3))),
        velocities_mps=draw(arrays((n, 2))),
        places=tuple(draw(st.lists(PLACES, min_size=n, max_size=n))),
        switches=draw(st.none() | st.dictionaries(WORDS, st.sampled_from(SwitchState), max_size=2)),
        events=tuple(draw(st.lists(EVENTS, max_size=2))),
        cameras=tuple(draw(camera_truths(n, name, index, time_ns)) for name in names),
    )


@st.composite
def frames(draw, camera="west", index=0, time_ns=0):
    height, width = draw(st.tuples(st.integers(1, 8), st.integers(1, 8)))
    return Frame(camera, index, time_ns, draw(hnp.arrays(np.uint8, (height, width, 3))))


@st.composite
def steps_with_frames(draw, names=("west",), index=0, time_ns=0):
    """A RecordedStep and the frames that its ledger speaks of."""
    truth = draw(st.none() | truths(names, index, time_ns))
    images = tuple(draw(frames(name, index, time_ns)) for name in names)
    seen = tuple(draw(tracks(name, index, time_ns)) for name in names)
    views = tuple(draw(ground_tracks(name, time_ns)) for name in names)
    fused = draw(ground_tracks(FUSED, time_ns))
    moves = draw(motions(fused))
    entries = ledger_of(Step(images, truth), seen, views)
    return RecordedStep(index, time_ns, truth, seen, views, fused, moves, entries), images


@st.composite
def runs(draw, min_steps=0, min_cameras=0):
    """A Recording and its frames, one tuple of them per step."""
    names = tuple(draw(st.lists(NAMES, min_size=min_cameras, max_size=2, unique=True)))
    start, period = draw(st.integers(0, 2**40)), draw(st.integers(1, 10**9))
    count = draw(st.integers(min_steps, 3))
    moments = [draw(steps_with_frames(names, index, start + index * period)) for index in range(count)]
    manifest = draw(manifests(names))
    return Recording(manifest, tuple(step for step, _ in moments)), tuple(images for _, images in moments)


def recordings(**kwargs):
    return runs(**kwargs).map(lambda run: run[0])
