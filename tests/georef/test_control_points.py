import cv2
import numpy as np
import pytest
from georef_cases import overhead, seen_marks, tile_corners

from contracts import Frame, InputError
from georef.control_points import find_marks, find_marks_in

RADIUS_PX = 6.3
FLOOR_BGR, YELLOW_BGR = np.array([162.0, 171.0, 176.0]), np.array([20.0, 190.0, 225.0])


def drawn(marks, noise=1.5, seed=0, index=0, level=1.0):
    """Yellow discs with exact subpixel edges on a grey floor, (720, 1280)."""
    v, u = np.mgrid[0:720, 0:1280]
    share = np.zeros((720, 1280))
    for mark in marks:
        window = np.s_[max(int(mark[1]) - 9, 0) : int(mark[1]) + 11, max(int(mark[0]) - 9, 0) : int(mark[0]) + 11]
        away = np.hypot(u[window] - mark[0], v[window] - mark[1])
        share[window] = np.maximum(share[window], np.clip(RADIUS_PX + 0.5 - away, 0.0, 1.0))
    image = level * (FLOOR_BGR + share[..., None] * (YELLOW_BGR - FLOOR_BGR))
    image += np.random.default_rng(seed).normal(0, noise, image.shape)
    return Frame("west", index, index, np.clip(np.rint(image), 0, 255).astype(np.uint8))


def errors(found, marks):
    nearest = np.hypot(*np.moveaxis(found[:, None] - marks, -1, 0)).argmin(axis=1)
    assert len(set(nearest.tolist())) == len(found)
    return found - marks[nearest]


_, MARKS = seen_marks(overhead(tilt_rad=(0.02, 0.03, 0.1)), tile_corners())


@pytest.mark.parametrize("level", [1.0, 0.35])
def test_marks_are_found_to_a_few_hundredths_of_a_pixel_in_bright_and_dim_light(level):
    found = find_marks(drawn(MARKS, level=level))
    assert len(found) == len(MARKS)
    error = errors(found, MARKS)
    assert np.abs(error.mean(axis=0)).max() < 0.02
    assert np.sqrt(np.mean(error**2)) < 0.04


def test_large_long_and_cut_off_yellow_things_are_no_marks():
    image = drawn(MARKS).image.copy()
    cv2.rectangle(image, (20, 20), (80, 60), YELLOW_BGR.tolist(), -1)
    cv2.rectangle(image, (560, 20), (620, 24), YELLOW_BGR.tolist(), -1)
    cv2.circle(image, (1279, 20), 6, YELLOW_BGR.tolist(), -1)
    found = find_marks(Frame("west", 0, 0, image))
    assert len(found) == len(MARKS)
    errors(found, MARKS)


def test_a_frame_without_yellow_has_no_marks():
    assert find_marks(Frame("west", 0, 0, np.full((72, 128, 3), 128, np.uint8))).shape == (0, 2)


def test_marks_of_many_frames_are_averaged_and_passing_ones_dropped():
    passing = np.array([[400.0, 90.0]])
    frames = [drawn(MARKS, noise=4.0, seed=k, index=k) for k in range(3)]
    frames.append(drawn(np.concatenate([MARKS, passing]), noise=4.0, seed=9, index=3))
    found = find_marks_in(frames)
    assert len(found) == len(MARKS)
    single = np.sqrt(np.mean(errors(find_marks(frames[0]), MARKS) ** 2))
    assert np.sqrt(np.mean(errors(found, MARKS) ** 2)) < single


def test_no_frames_are_refused():
    with pytest.raises(InputError, match="no frame"):
        find_marks_in([])
