from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.special import fresnel

from contracts import InputError
from rail.curves import Bend, Curve, Pose2, wrapped
from rail.pieces import biarc, line, shift, turn

coordinates = st.floats(-5.0, 5.0)
poses = st.builds(Pose2, coordinates, coordinates, st.floats(-pi, pi))
lengths = st.floats(0.01, 2.0)
curvatures = st.floats(-2.5, 2.5)
bends = st.builds(Bend, lengths, curvatures, curvatures)
curves = st.builds(Curve, poses, st.lists(bends, min_size=1, max_size=5).map(tuple))
shares = st.floats(0.0, 1.0)


def gap_m(a: Pose2, b: Pose2) -> float:
    return hypot(a.x_m - b.x_m, a.y_m - b.y_m)


@given(poses)
def test_a_pose_reversed_twice_is_itself(pose):
    back = pose.reversed().reversed()
    assert gap_m(pose, back) == 0.0
    assert abs(wrapped(back.heading_rad - pose.heading_rad)) < 1e-12


@given(st.floats(-50.0, 50.0))
def test_wrapping_keeps_the_direction_and_the_range(angle_rad):
    result = wrapped(angle_rad)
    assert -pi < result <= pi
    assert abs(cos(result) - cos(angle_rad)) < 1e-12
    assert abs(sin(result) - sin(angle_rad)) < 1e-12


@given(poses, coordinates, coordinates)
def test_left_of_is_the_left_offset(pose, forward_m, left_m):
    assert abs(pose.left_of(*pose.offset(forward_m, left_m)) - left_m) < 1e-12


@given(st.floats(0.35, 3.0), st.floats(0.01, 2 * pi), st.booleans(), poses)
def test_an_arc_stays_on_its_circle_and_turns_by_its_angle(radius_m, angle_rad, left, start):
    curve = Curve(start, turn(angle_rad if left else -angle_rad, radius_m))
    centre = start.offset(0.0, radius_m if left else -radius_m)
    assert np.abs(np.hypot(*(curve.points(0.05) - centre).T) - radius_m).max() < 1e-12
    assert abs(abs(curve.end.heading_rad - start.heading_rad) - angle_rad) < 1e-12


@given(st.floats(0.05, 1.0), st.floats(0.35, 3.0))
def test_a_clothoid_ends_where_fresnels_integrals_say(length_m, radius_m):
    assume(length_m / radius_m < 2 * pi)
    end = Bend(length_m, 0.0, 1.0 / radius_m).pose_from(Pose2(0.0, 0.0, 0.0), length_m)
    scale_m = (pi * radius_m * length_m) ** 0.5
    s, c = fresnel(length_m / scale_m)
    assert gap_m(end, Pose2(scale_m * c, scale_m * s, 0.0)) < 1e-12


@given(lengths, curvatures, poses, shares)
def test_closed_form_one_point_and_quadrature_agree(length_m, curvature_per_m, start, share):
    along_m = share * length_m
    arc = Bend(length_m, curvature_per_m, curvature_per_m)
    nearly = Bend(length_m, curvature_per_m, curvature_per_m + 1e-14)  # no arc to the bit, hence integrated
    one = arc.pose_from(start, along_m)
    for bend in (arc, nearly):
        x_m, y_m, heading_rad = bend.poses_from(start, along_m).tolist()
        assert gap_m(one, Pose2(x_m, y_m, heading_rad)) < 1e-12
        assert abs(one.heading_rad - heading_rad) < 1e-12


@given(curves, shares, shares)
def test_a_curve_is_parametrised_by_arc_length(curve, a, b):
    low, high = sorted((a * curve.length_m, b * curve.length_m))
    points = curve.poses_at(np.linspace(low, high, 500))[:, :2]
    chords_m = np.hypot(*np.diff(points, axis=0).T).sum()
    assert 0 <= high - low - chords_m + 1e-9 < 1e-3


@given(curves, shares)
def test_the_heading_is_the_direction_of_motion(curve, share):
    offset_m = share * (curve.length_m - 1e-6)
    a, b = curve.pose_at(offset_m), curve.pose_at(offset_m + 1e-6)
    assert abs((b.x_m - a.x_m) / 1e-6 - cos(a.heading_rad)) < 1e-4
    assert abs((b.y_m - a.y_m) / 1e-6 - sin(a.heading_rad)) < 1e-4


@given(curves)
def test_bends_join_without_gap_or_kink(curve):
    offset_m = 0.0
    for bend in curve.bends[:-1]:
        offset_m += bend.length_m
        before, after = curve.poses_at(np.array([offset_m - 1e-10, min(offset_m + 1e-10, curve.length_m)]))
        assert np.abs(after - before).max() < 1e-9


@given(curves, st.floats(0.003, 3.0))
def test_points_run_from_end_to_end_in_equal_steps(curve, step_m):
    points = curve.points(step_m)
    assert gap_m(curve.start, Pose2(*points[0], 0.0)) < 1e-12
    assert gap_m(curve.end, Pose2(*points[-1], 0.0)) < 1e-12
    assert np.hypot(*np.diff(points, axis=0).T).max() <= step_m + 1e-12


@given(curves)
def test_the_least_radius_bounds_the_curvature_everywhere(curve):
    greatest = max(abs(curve.curvature_at(offset)) for offset in np.linspace(0.0, curve.length_m, 50))
    assert greatest <= 1.0 / curve.min_radius_m + 1e-9


@given(poses, poses)
def test_a_biarc_leads_from_pose_to_pose(start, end):
    ahead = Pose2(start.x_m, start.y_m, start.heading_rad).offset(1.0, 0.0)
    assume(gap_m(start, end) > 0.01)
    assume((end.x_m - start.x_m) * (ahead[0] - start.x_m) + (end.y_m - start.y_m) * (ahead[1] - start.y_m) > 0.01)
    assume(abs(wrapped(end.heading_rad - start.heading_rad)) < 3.0)
    curve = Curve(start, biarc(start, end))
    assert gap_m(curve.end, end) < 1e-9
    assert abs(wrapped(curve.end.heading_rad - end.heading_rad)) < 1e-9


@given(poses, st.floats(-0.6, 0.6).filter(lambda left: abs(left) > 0.01), st.floats(0.35, 2.0))
def test_a_shift_ends_parallel_and_aside(start, left_m, radius_m):
    curve = Curve(start, shift(left_m, radius_m))
    assert abs(start.left_of(curve.end.x_m, curve.end.y_m) - left_m) < 1e-12
    assert abs(curve.end.heading_rad - start.heading_rad) < 1e-12
    assert curve.min_radius_m == pytest.approx(radius_m, abs=1e-12)


@given(st.floats(0.5, 3.0), st.floats(0.5, 1.5), st.floats(0.01, 0.2))
def test_clothoids_take_their_share_of_a_turn(angle_rad, radius_m, ease_m):
    curve = Curve(Pose2(0.0, 0.0, 0.0), turn(angle_rad, radius_m, ease_m))
    assert abs(curve.end.heading_rad - angle_rad) < 1e-12
    assert curve.curvature_at(0.0) == 0.0
    assert abs(curve.curvature_at(curve.length_m)) < 1e-12


def test_a_straight_biarc_is_a_line():
    curve = Curve(Pose2(0.0, 0.0, 0.0), biarc(Pose2(0.0, 0.0, 0.0), Pose2(2.0, 0.0, 0.0)))
    assert abs(curve.length_m - 2.0) < 1e-12


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Bend(0.0), "no length"),
        (lambda: Bend(float("nan")), "no length"),
        (lambda: Bend(1.0, 7.0, 7.0), "more than once"),
        (lambda: Curve(Pose2(0, 0, 0), ()), "at least one bend"),
        (lambda: turn(1.0, -0.4), "positive radius"),
        (lambda: turn(0.1, 0.5, 0.2), "too long"),
        (lambda: shift(0.9, 0.4), "takes a radius above"),
        (lambda: biarc(Pose2(0, 0, 0), Pose2(0, 0, 0)), "no pair of arcs"),
        (lambda: biarc(Pose2(0, 0, 0), Pose2(-1, 0, 0)), "no pair of arcs"),
        (lambda: Curve(Pose2(0, 0, 0), line(1.0)).pose_at(1.1), "off the curve"),
        (lambda: Curve(Pose2(0, 0, 0), line(1.0)).pose_at(float("nan")), "off the curve"),
        (lambda: Curve(Pose2(0, 0, 0), line(1.0)).points(0.0), "must be positive"),
    ],
)
def test_impossible_curves_are_refused(make, says):
    with pytest.raises(InputError, match=says):
        make()
