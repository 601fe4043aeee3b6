"""A roof followed over drawn frames: against the truth of the drawing, and against the full measurement."""

import itertools
from dataclasses import replace

import cv2
import numpy as np
import pytest
from drawn_frames import Box, draw, floor
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import FloatArray, ImageArray
from perception.roof import measure_roof
from perception.roof_cover import covered_sides
from perception.roof_following import REFIT_EVERY, FollowedRoof, follow_part, follow_roof, start_following
from perception.roof_window import RoofPose

BACKGROUND = floor(np.random.default_rng(3))
BOX = Box("blue", (300.3, 180.7), heading_rad=0.4, lean_px=(4.0, -2.0), shadow_px=(9.0, 6.0))
PLAIN = Box("blue", (300.3, 180.7), heading_rad=0.4)


def started(box: Box) -> FollowedRoof:
    followed = start_following(draw(BACKGROUND, [box]), box.roof_quad_px)
    assert followed is not None
    return followed


def error_px(followed: FollowedRoof | None, box: Box) -> float:
    assert followed is not None
    return float(np.abs(followed.pose.centre_px - box.centre_px).max())


def driven(box: Box, frames: int, speed_px: float, turn_rad: float) -> list[Box]:
    """The box moving ahead along a circle."""
    boxes = [box]
    for _ in range(frames):
        last = boxes[-1]
        heading = last.heading_rad + turn_rad
        u, v = last.centre_px
        centre = (u + speed_px * np.cos(heading), v + speed_px * np.sin(heading))
        boxes.append(replace(last, centre_px=centre, heading_rad=heading))
    return boxes


def full_px(image: ImageArray, followed: FollowedRoof) -> FloatArray:
    """The same roof by the full measurement, the oracle."""
    return measure_roof(image, followed.pose.corners_px).centre_px


@given(
    st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-np.pi, np.pi), st.floats(-1.2, 1.2), st.floats(-0.02, 0.02)
)
@settings(max_examples=20, deadline=None)
def test_a_roof_that_moved_a_little_is_found_where_it_is(du, dv, heading, ahead_px, turn_rad):
    box = replace(PLAIN, centre_px=(300 + du, 180 + dv), heading_rad=heading)
    moved = driven(box, 1, ahead_px, turn_rad)[1]
    before = started(box)
    after = follow_roof(draw(BACKGROUND, [moved]), before, before.pose)
    assert error_px(after, moved) < 0.25


@given(st.floats(-8.0, 8.0), st.floats(-0.04, 0.04), st.booleans())
@settings(max_examples=8, deadline=None)
def test_a_vehicle_on_a_curve_is_followed_without_drift(speed_px, turn_rad, leaning):
    box = BOX if leaning else PLAIN
    boxes = driven(box, 2 * REFIT_EVERY + 3, speed_px, turn_rad)
    followed = started(boxes[0])
    for before, after in itertools.pairwise(boxes):
        step = np.subtract(after.centre_px, before.centre_px)
        image = draw(BACKGROUND, [after])
        followed = follow_roof(image, followed, followed.pose.displaced(step, turn_rad))
        assert error_px(followed, after) < 0.3
    if not leaning:  # a wall beside a shadow has more than one explanation
        assert np.abs(followed.pose.centre_px - full_px(image, followed)).max() < 0.03


@given(st.floats(0.6, 1.25))
@settings(max_examples=10, deadline=None)
def test_the_lights_strength_does_not_move_the_roof(gain):
    before = started(BOX)
    after = follow_roof(draw(BACKGROUND, [BOX], gain=gain), before, before.pose)
    assert error_px(after, BOX) < 0.2


@pytest.mark.parametrize("age", [0, REFIT_EVERY - 1])
def test_where_the_vehicle_is_gone_nothing_is_followed(age):
    before = replace(started(BOX), age=age)
    assert follow_roof(BACKGROUND, before, before.pose) is None


def test_a_cover_over_half_of_the_roof_is_no_roof():
    before = started(BOX)
    image = draw(BACKGROUND, [BOX])
    cv2.rectangle(image, (300, 100), (400, 260), (70, 70, 70), thickness=-1)
    assert follow_roof(image, before, before.pose) is None


def seen_again(image: ImageArray, before: FollowedRoof, step_px: FloatArray) -> FollowedRoof | None:
    expected = before.pose.displaced(step_px, 0.0)
    return follow_roof(image, before, expected) or follow_part(image, before, expected)


def under_bridge(box: Box) -> ImageArray:
    image = draw(BACKGROUND, [box])
    image[:, 360:480] = (70, 80, 90)
    return image


@given(st.floats(3.0, 10.0), st.floats(-0.5, 0.5))
@settings(max_examples=10, deadline=None)
def test_a_vehicle_is_followed_under_a_bridge_and_back_as_far_as_enough_of_it_shows(speed_px, sideways_px):
    """It goes in, stops there for three frames, and comes out backwards: the front is hidden all that time."""
    box, steps = Box("blue", (310.3, 180.7)), [speed_px] * 30
    followed, shown = started(box), 1.0
    ways = [step for k, step in enumerate(steps) if 310.3 + speed_px * (k + 1) < 360 + 35 - 0.45 * 70]
    for step in [*ways, 0.0, 0.0, 0.0, *(-way for way in ways)]:
        box = replace(box, centre_px=(box.centre_px[0] + step, 180.7 + sideways_px))
        followed = seen_again(under_bridge(box), followed, np.array([step, 0.0]))
        assert error_px(followed, box) < 0.65  # half of what may be hidden unnoticed, and a little
        shown = min(shown, followed.shown)
        assert followed.whole == (box.centre_px[0] + 35 < 360 + 1.2) or 360 <= box.centre_px[0] + 35 < 362
    assert shown < 0.6
    assert followed.whole


@pytest.mark.parametrize("speed_px", [0.1, 0.4, 1.1])
def test_a_cover_that_comes_slowly_is_noticed(speed_px):
    box = Box("blue", (320.3, 180.7))
    followed = started(box)
    for _ in range(int(12 / speed_px)):
        box = replace(box, centre_px=(box.centre_px[0] + speed_px, 180.7))
        followed = seen_again(under_bridge(box), followed, np.array([speed_px, 0.0]))
        assert error_px(followed, box) < 0.7  # half of what a roof may seem shorter, and a little
    assert not followed.whole
    assert error_px(followed, box) < 0.2


@given(st.floats(-np.pi, np.pi), st.floats(3.0, 9.0))
@settings(max_examples=12, deadline=None)
def test_a_vehicle_is_followed_over_the_border_and_back(heading, speed_px):
    """Whatever way it lies, the border may cut an end of it, a side, or a corner."""
    box = Box("blue", (50.0, 180.7), heading_rad=heading)
    followed = started(box)
    step = -speed_px
    while box.centre_px[0] <= 50.0:
        box = replace(box, centre_px=(box.centre_px[0] + step, 180.7))
        followed = seen_again(draw(BACKGROUND, [box]), followed, np.array([step, 0.0]))
        assert error_px(followed, box) < 0.5
        step = speed_px if followed.shown < 0.62 else step
    assert followed.whole


def test_a_roof_that_the_border_cuts_is_measured_where_a_detector_completed_it():
    edge = Box("blue", (20.0, 180.0))
    followed = start_following(draw(BACKGROUND, [edge]), edge.roof_quad_px)
    assert error_px(followed, edge) < 0.2
    assert followed.hidden.sum() == 1
    assert followed.shown < 0.8


@given(st.floats(20, 60), st.floats(2, 9), st.floats(-1.5, 6.0), st.booleans(), st.floats(-np.pi, np.pi))
def test_what_covers_a_roof_stands_still_so_it_hides_the_end_that_did_not_show_before(shown, missing, on, ahead, turn):
    """A whole roof moved on; a cover now hides ``missing`` of the end that leads, or of the other one, moving back."""
    last = RoofPose(np.array([100.0, 80.0]), np.eye(2), np.array([shown + missing, 20.0])).displaced(np.zeros(2), turn)
    way = (1 if ahead else -1) * last.axes[0]
    middle = last.centre_px + (max(on, 0.0) + missing / 2) * way
    part = RoofPose(middle, last.axes, np.array([shown, 20.0]))
    none, side = np.zeros(4, np.bool_), 1 if ahead else 3
    hidden = covered_sides(part, np.array([missing, 0.0]), last, none, none)
    assert hidden.tolist() == [k == side for k in range(4)]
    beyond = RoofPose(part.centre_px + (shown + 15) * way, last.axes, part.size_px)  # it shows behind the cover
    hidden = covered_sides(beyond, np.array([missing, 0.0]), part, hidden, none)
    assert hidden.tolist() == [k == (side + 2) % 4 for k in range(4)]


@given(st.floats(-np.pi, np.pi), st.floats(20, 90), st.floats(10, 50), st.booleans())
def test_a_rectangles_corners_give_the_rectangle_back(heading, length, width, mirrored):
    corners = RoofPose(np.array([100.0, 80.0]), np.eye(2), np.array([length, width])).corners_px
    turned = RoofPose.of(corners).displaced(np.array([3.0, -2.0]), heading).corners_px
    quad = turned[[1, 0, 3, 2]] if mirrored else turned
    again = RoofPose.of(quad)
    assert np.abs(again.corners_px - quad).max() < 1e-9
    assert np.abs(again.axes @ again.axes.T - np.eye(2)).max() < 1e-12
    assert np.abs(again.size_px - (length, width)).max() < 1e-9
