import tempfile
from pathlib import Path

import mcap.reader
import mcap.writer
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.ledger import ledger_of
from bench.recording import Manifest, RecordedStep, Recording
from bench.recording_file import RECORDING_NAME, Recorder, load_frames, load_recording
from contracts import Detections, Frame, GroundTracks, InputError, Motions, Tracks
from contracts.truth import Step
from tests.bench import strategies
from tests.bench.equality import same

NOISE = np.random.default_rng(1)


def record(directory, run, **kwargs):
    recording, images = run
    with Recorder(directory, recording.manifest, **kwargs) as recorder:
        for step, frames in zip(recording.steps, images, strict=True):
            recorder.write(step, frames)
    return Path(directory)


def plain_manifest():
    return Manifest("s", "t", "rail", 1, 25.0, {}, (), {}, None, (), ())


def noisy_run(steps):
    """A run that fills a file: images of noise do not compress."""
    moments = []
    for k in range(steps):
        image = NOISE.integers(0, 256, (64, 64, 3), dtype=np.uint8)
        frames = (Frame("west", k, 10 * k, image),)
        tracks = (Tracks([], Detections.empty("west", k, 10 * k)),)
        view = GroundTracks("west", 10 * k, [], (), [], [], [])
        fused = GroundTracks("fused", 10 * k, [], (), [], [], [])
        ledger = ledger_of(Step(frames, None), tracks, (view,))
        moments.append((RecordedStep(k, 10 * k, None, tracks, (view,), fused, Motions.unknown(fused), ledger), frames))
    return Recording(plain_manifest(), tuple(m[0] for m in moments)), tuple(m[1] for m in moments)


@pytest.fixture(scope="module")
def long_file(tmp_path_factory):
    return record(tmp_path_factory.mktemp("long"), noisy_run(130), keep_frames=True) / RECORDING_NAME


@settings(max_examples=12, deadline=None)
@given(strategies.runs(), st.booleans())
def test_a_run_is_read_back_as_it_was_written(run, keep_frames):
    with tempfile.TemporaryDirectory() as directory:
        record(directory, run, keep_frames=keep_frames)
        assert same(load_recording(directory), run[0])


@settings(max_examples=8, deadline=None)
@given(strategies.runs())
def test_frames_are_read_back_to_the_pixel(run):
    _, images = run
    with tempfile.TemporaryDirectory() as directory:
        record(directory, run, keep_frames=True)
        for place, name in enumerate([frame.camera for frame in images[0]] if images else []):
            loaded = list(load_frames(directory, name))
            assert all(map(same, loaded, [frames[place] for frames in images]))
            assert len(loaded) == len(images)


def test_another_reader_finds_the_topics_in_json(tmp_path):
    path = record(tmp_path, noisy_run(2), keep_frames=True) / RECORDING_NAME
    with path.open("rb") as stream:
        found = {
            channel.topic: (schema.name, schema.encoding, channel.message_encoding)
            for schema, channel, _ in mcap.reader.make_reader(stream).iter_messages()
        }
    assert found == {
        "/manifest": ("gantry.Manifest", "jsonschema", "json"),
        "/frames/west": ("foxglove.CompressedImage", "jsonschema", "json"),
        "/tracks/west": ("gantry.Tracks", "jsonschema", "json"),
        "/ground/west": ("gantry.GroundTracks", "jsonschema", "json"),
        "/ledger/west": ("gantry.LedgerEntry", "jsonschema", "json"),
        "/motion": ("gantry.Motions", "jsonschema", "json"),
        "/ground/fused": ("gantry.GroundTracks", "jsonschema", "json"),
    }


def test_a_failed_run_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError, match="lost"), Recorder(tmp_path, plain_manifest()):
        raise RuntimeError("lost")
    assert list(tmp_path.iterdir()) == []


def test_a_failed_run_leaves_the_earlier_recording_alone(tmp_path):
    earlier = record(tmp_path, noisy_run(1))
    before = (earlier / RECORDING_NAME).read_bytes()
    with pytest.raises(RuntimeError, match="lost"), Recorder(tmp_path, plain_manifest()):
        raise RuntimeError("lost")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {RECORDING_NAME: before}


def test_a_directory_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "taken").write_text("")
    with (
        pytest.raises(InputError, match="taken cannot hold a recording"),
        Recorder(tmp_path / "taken", plain_manifest()),
    ):
        pass


def test_a_camera_may_not_bear_the_name_of_all_together(tmp_path):
    fused = GroundTracks("fused", 0, [], (), [], [], [])
    with (
        pytest.raises(InputError, match="a camera cannot be named 'fused'"),
        Recorder(tmp_path, plain_manifest()) as recorder,
    ):
        recorder.write(RecordedStep(0, 0, None, (), (fused,), fused, Motions.unknown(fused), ()))


def test_a_missing_recording_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nowhere/run\.mcap does not exist"):
        load_recording(tmp_path / "nowhere")


def test_an_empty_recording_is_named(tmp_path):
    (tmp_path / RECORDING_NAME).touch()
    with pytest.raises(InputError, match=r"run\.mcap is empty"):
        load_recording(tmp_path)


@given(st.binary(min_size=1, max_size=64))
def test_a_file_that_is_no_mcap_is_named(data):
    with tempfile.TemporaryDirectory() as directory:
        (Path(directory) / RECORDING_NAME).write_bytes(data)
        with pytest.raises(InputError, match=r"run\.mcap is no MCAP file"):
            load_recording(directory)


def test_an_mcap_file_of_another_tool_is_named(tmp_path):
    writer = mcap.writer.Writer(str(tmp_path / RECORDING_NAME))
    writer.start()
    writer.finish()
    with pytest.raises(InputError, match="no recording of Gantry"):
        load_recording(tmp_path)


@pytest.fixture(scope="module")
def long_recording(long_file):
    return load_recording(long_file)


@settings(max_examples=10, deadline=None)
@given(share=st.floats(0.001, 0.999))
def test_a_cut_file_is_refused_but_its_whole_steps_can_be_saved(long_file, long_recording, share):
    data = long_file.read_bytes()
    with tempfile.TemporaryDirectory() as directory:
        (Path(directory) / RECORDING_NAME).write_bytes(data[: int(share * len(data))])
        with pytest.raises(InputError, match=r"run\.mcap is (cut short|no MCAP file|damaged)"):
            load_recording(directory)
        try:
            saved = load_recording(directory, salvage=True)
        except InputError:
            assert share < 0.8  # not one whole chunk of about a megabyte
        else:
            assert all(map(same, saved.steps, long_recording.steps))


@settings(max_examples=15, deadline=None)
@given(share=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_never_passes_for_other_data(long_file, long_recording, share, bit):
    data = bytearray(long_file.read_bytes())
    data[int(share * len(data))] ^= 1 << bit
    with tempfile.TemporaryDirectory() as directory:
        (Path(directory) / RECORDING_NAME).write_bytes(data)
        try:
            read = load_recording(directory)
        except InputError:
            return
        assert same(read, long_recording)  # the bit lay in the index, which is not needed here


def test_images_that_were_not_kept_are_missed_by_name(tmp_path):
    record(tmp_path, noisy_run(1))
    with pytest.raises(InputError, match=r"no images of camera 'west', only those of: none"):
        list(load_frames(tmp_path, "west"))


def test_the_cameras_whose_images_there_are_are_listed(tmp_path):
    record(tmp_path, noisy_run(1), keep_frames=True)
    with pytest.raises(InputError, match=r"no images of camera 'east', only those of: west"):
        list(load_frames(tmp_path, "east"))
