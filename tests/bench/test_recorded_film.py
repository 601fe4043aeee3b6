from itertools import islice

import cv2
import numpy as np
import pytest

from bench.diff import first_difference
from bench.learn import labelled_frames
from bench.ledger import ledger_of, value_hash
from bench.recording import Manifest, RecordedStep, Recording
from bench.recording_file import Recorder, load_recording
from bench.roofs import roof_quads_px
from contracts import GroundTracks, Motions
from scenarios.loader import build_world, load_scenario
from tests.bench.equality import same

STEPS = 2


@pytest.fixture(scope="module")
def filmed():
    """A world's cameras and its first steps: four frames in all."""
    world = build_world(load_scenario("oval-one-vehicle"))
    return world, tuple(islice(world.steps(), STEPS))


@pytest.fixture(scope="module")
def directory(filmed, tmp_path_factory):
    path = tmp_path_factory.mktemp("film")
    recording = recorded(filmed)
    with Recorder(path, recording.manifest, keep_frames=True) as recorder:
        for step, made in zip(recording.steps, filmed[1], strict=True):
            recorder.write(step, made.frames)
    return path


def recorded(filmed):
    world, steps = filmed
    manifest = Manifest("oval", "Oval", "rail", 1, 25.0, {}, (), {}, world.survey, world.cameras, ())
    return Recording(manifest, tuple(_recorded(step) for step in steps))


def _recorded(step):
    nothing = GroundTracks("fused", step.truth.time_ns, [], (), [], [], [])
    still = Motions.unknown(nothing)
    return RecordedStep(
        step.truth.index, step.truth.time_ns, step.truth, (), (), nothing, still, ledger_of(step, (), ())
    )


@pytest.mark.film
def test_filmed_steps_are_read_back_without_their_masks(filmed, directory):
    loaded = load_recording(directory)
    assert all(view.instances is None for step in loaded.steps for view in step.truth.cameras)
    assert [step.ledger for step in loaded.steps] == [step.ledger for step in recorded(filmed).steps]
    assert value_hash(loaded.manifest) == value_hash(recorded(filmed).manifest)
    assert first_difference(loaded, load_recording(directory)) is None


@pytest.mark.film
def test_training_frames_are_the_film_to_the_pixel(filmed, directory):
    expected = {(frame.camera, frame.index): frame for step in filmed[1] for frame in step.frames}
    samples = list(labelled_frames(directory))
    assert len(samples) == len(expected) == 2 * STEPS
    assert all(same(sample.frame, expected[sample.frame.camera, sample.frame.index]) for sample in samples)


@pytest.mark.film
def test_the_marks_lie_where_the_simulator_put_the_roofs(filmed):
    """The simulator projects with OpenCV, the marks with georef: two ways to the same pixel."""
    world, steps = filmed
    for step in steps:
        for camera, view in zip(world.cameras, step.truth.cameras, strict=True):
            diagonals_meet = np.array([_crossing(quad) for quad in roof_quads_px(step.truth, camera)])
            assert np.abs(diagonals_meet - view.roofs_px).max() < 0.05  # px; the lens bends diagonals a little


def _crossing(quad):
    lines = [np.cross([*quad[k], 1], [*quad[k + 2], 1]) for k in (0, 1)]
    u, v, w = np.cross(*lines)
    return u / w, v / w


@pytest.mark.film
def test_the_marks_hold_the_vehicle_s_colour_and_no_ground(filmed, directory):
    shown = [sample for sample in labelled_frames(directory) if sample.labels]
    assert len(shown) == STEPS
    for sample in shown:
        quad = sample.roof_quads_px[0]
        inner = quad + (quad.mean(axis=0) - quad) * 0.1
        mask = cv2.fillConvexPoly(np.zeros(sample.frame.image.shape[:2], np.uint8), np.round(inner).astype(np.int32), 1)
        saturation = cv2.cvtColor(sample.frame.image, cv2.COLOR_BGR2HSV)[..., 1]
        assert saturation[mask == 1].min() > 120  # of 255; the grey floor has below 60
