import cv2
import numpy as np
import pytest

from bench.footage import Footage
from contracts import InputError
from tests.bench.filmless import overhead_camera

CAMERA = overhead_camera()


def picture(level, size=(180, 320)):
    return np.full((*size, 3), level, np.uint8)


@pytest.fixture
def video(tmp_path):
    path = tmp_path / "street.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 20.0, (320, 180))
    for level in (40, 80, 120):
        writer.write(picture(level))
    writer.release()
    return path


@pytest.fixture
def folder(tmp_path):
    directory = tmp_path / "images"
    directory.mkdir()
    for name, level in (("b.png", 80), ("a.png", 40), ("c.JPG", 120)):
        cv2.imwrite(str(directory / name), picture(level))
    (directory / "notes.txt").write_text("not an image, not taken for one")
    return directory


def test_a_video_becomes_steps_without_truth(video):
    footage = Footage(video, CAMERA)
    steps = list(footage.steps())
    assert footage.fps == 20.0
    assert [step.truth for step in steps] == [None] * 3
    frames = [step.frames[0] for step in steps]
    assert [(frame.camera, frame.index, frame.time_ns) for frame in frames] == [
        ("west", 0, 0),
        ("west", 1, 50_000_000),
        ("west", 2, 100_000_000),
    ]
    for frame, level in zip(frames, (40, 80, 120), strict=True):
        assert np.abs(frame.image.astype(int) - level).max() <= 3  # JPEG inside


def test_the_steps_can_be_had_again(video):
    footage = Footage(video, CAMERA)
    first, again = list(footage.steps()), list(footage.steps())
    assert all(np.array_equal(a.frames[0].image, b.frames[0].image) for a, b in zip(first, again, strict=True))


def test_a_folder_is_taken_in_the_order_of_names(folder):
    steps = list(Footage(folder, CAMERA, fps=4.0).steps())
    assert [int(step.frames[0].image[0, 0, 0]) for step in steps] == [40, 80, 120]
    assert [step.frames[0].time_ns for step in steps] == [0, 250_000_000, 500_000_000]


def test_a_folder_must_be_told_its_frame_rate(folder):
    with pytest.raises(InputError, match="does not say how many frames it has per second"):
        Footage(folder, CAMERA)


def test_one_image_is_one_step(folder):
    (step,) = Footage(folder / "a.png", CAMERA).steps()
    assert step.frames[0].time_ns == 0


@pytest.mark.parametrize("name", ["street.avi", "a.png"])
def test_a_rate_of_nothing_is_refused_where_the_footage_says_its_own(video, name):
    cv2.imwrite(str(video.with_name("a.png")), picture(40))
    with pytest.raises(InputError, match="--fps 0 is no number"):
        Footage(video.with_name(name), CAMERA, fps=0.0)


def test_a_told_frame_rate_goes_before_the_video_s_own(video):
    assert [step.frames[0].time_ns for step in Footage(video, CAMERA, fps=1.0).steps()] == [0, 10**9, 2 * 10**9]


def test_a_file_that_is_no_video_is_named_once(tmp_path, capfd):
    (tmp_path / "no.mp4").write_text("no video")
    with pytest.raises(InputError, match=r"no\.mp4 is no video that can be read"):
        Footage(tmp_path / "no.mp4", CAMERA)
    assert capfd.readouterr().err == ""  # the decoder keeps quiet


def test_an_image_that_is_no_image_is_named_when_it_is_reached(folder):
    (folder / "b.png").write_text("no image")
    steps = Footage(folder, CAMERA, fps=4.0).steps()
    next(steps)
    with pytest.raises(InputError, match=r"b\.png is no image that can be read"):
        next(steps)


def test_a_missing_file_or_an_empty_folder_is_named(tmp_path):
    with pytest.raises(InputError, match="absent does not exist"):
        Footage(tmp_path / "absent", CAMERA)
    with pytest.raises(InputError, match="holds no image files"):
        Footage(tmp_path, CAMERA, fps=4.0)


def test_frames_of_another_size_are_refused(folder):
    cv2.imwrite(str(folder / "a.png"), picture(40, (90, 160)))
    with pytest.raises(InputError, match=r"a\.png is 160 x 90 pixels, but camera west has 320 x 180"):
        Footage(folder, CAMERA, fps=4.0)


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_frame_rate_is_refused(folder, fps):
    with pytest.raises(InputError, match=f"--fps {fps:g} is no number of frames per second"):
        Footage(folder, CAMERA, fps=fps)
