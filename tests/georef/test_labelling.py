import numpy as np
import pytest
from georef_cases import departed, overhead, perturbed, seen_marks, tile_corners
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import CalibrationError, InputError
from georef.labelling import Departure, label

POINTS = tile_corners()
NOMINAL = overhead(position_m=(0.13, -0.07, 2.8))


def filmed(rng, hidden=0.3, false=2, camera=None):
    """Marks of a departed camera, some hidden and some false; and the true number of each mark, -1 for a false one."""
    true = camera or departed(NOMINAL, rng)
    numbers, image = seen_marks(true, POINTS)
    kept = rng.permutation(len(numbers))[: max(7, round((1 - hidden) * len(numbers)))]
    marks = image[kept] + rng.normal(0, 0.05, (len(kept), 2))
    marks = np.concatenate([marks, rng.uniform([0, 0], [1280, 720], (false, 2))])
    order = rng.permutation(len(marks))
    return marks[order], np.concatenate([numbers[kept], np.full(false, -1)])[order]


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.4), st.integers(0, 3))
def test_every_label_is_right_under_any_departure_with_hidden_and_false_marks(seed, hidden, false):
    marks, numbers = filmed(np.random.default_rng(seed), hidden, false)
    labelled = label(NOMINAL, marks, POINTS)
    right = numbers[labelled.marks] == labelled.points
    chance = numbers[labelled.marks] == -1  # a false mark that fell onto a hidden point is no error
    assert (right | chance).all()
    assert right.sum() >= (numbers >= 0).sum() - 1  # at most one may lose its point to a false mark beside it


def test_of_two_poses_one_tile_apart_that_see_the_same_the_nominal_one_decides():
    step = np.zeros(15)
    step[12] = 0.4
    next_tile = perturbed(NOMINAL, step)
    marks, numbers = filmed(np.random.default_rng(1), 0.0, 0, NOMINAL)
    here, there = label(NOMINAL, marks, POINTS), label(next_tile, marks, POINTS)
    assert (POINTS[numbers[here.marks]] == POINTS[here.points]).all()
    shift = POINTS[there.points] - POINTS[numbers[there.marks]]
    assert np.abs(shift - [0.4, 0.0, 0.0]).max() < 1e-9


@pytest.mark.parametrize("shift_m", [0.16, 0.2])
def test_a_camera_between_two_tiles_is_refused(shift_m):
    step = np.zeros(15)
    step[12] = shift_m
    marks, _ = filmed(np.random.default_rng(2), 0.0, 0, perturbed(NOMINAL, step))
    with pytest.raises(CalibrationError, match=r"within 0\.13 m and 4\.0 deg"):
        label(NOMINAL, marks, POINTS)


def test_a_permission_of_half_a_tile_and_more_is_ambiguous():
    step = np.zeros(15)
    step[12] = 0.2
    marks, _ = filmed(np.random.default_rng(3), 0.0, 0, perturbed(NOMINAL, step))
    with pytest.raises(CalibrationError, match="two labellings"):
        label(NOMINAL, marks, POINTS, Departure(position_m=0.35))


def test_marks_that_are_all_false_are_refused():
    marks = np.random.default_rng(4).uniform([0, 0], [1280, 720], (14, 2))
    with pytest.raises(CalibrationError, match="of 14 marks found only"):
        label(NOMINAL, marks, POINTS)


def test_too_few_marks_are_refused():
    marks, _ = filmed(np.random.default_rng(5), 0.0, 0)
    with pytest.raises(CalibrationError, match="4 control points were found in the image; 5 are needed"):
        label(NOMINAL, marks[:4], POINTS)


def test_a_departure_that_permits_nothing_is_refused():
    with pytest.raises(InputError, match="must be positive"):
        Departure(position_m=0.0)
