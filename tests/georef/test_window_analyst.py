"""Direction and speed from places: laws of motion, known motions recovered, nothing said that noise alone says."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import Analyst, Compass, GroundTracks, InputError, Motions, MotionState
from contracts.motion import compass
from georef.motion import PLACES, WINDOWS_S, WindowAnalyst
from georef.velocity import parabolas

PERIOD_S = 0.04
SEEDS = st.integers(0, 2**32 - 1)
ANGLES = st.floats(-pi, pi)


def moments(paths_m, *, sigma_m=0.0, seed=0, times_s=None, stated_m=None):
    """GroundTracks of objects at ``paths_m`` (F, N, 2), moment by moment."""
    paths_m = np.asarray(paths_m, float)
    times_s = np.arange(len(paths_m)) * PERIOD_S if times_s is None else times_s
    noisy = paths_m + sigma_m * np.random.default_rng(seed).normal(size=paths_m.shape)
    n = paths_m.shape[1]
    covs = np.tile(np.eye(2) * (sigma_m if stated_m is None else stated_m) ** 2, (n, 1, 1))
    return [
        GroundTracks("fused", round(1e9 * t), np.arange(n) + 3, ("red",) * n, places, covs, np.ones(n, bool))
        for t, places in zip(times_s, noisy, strict=True)
    ]


def analysed(grounds) -> list[Motions]:
    analyst = WindowAnalyst()
    return [analyst.analyse(ground) for ground in grounds]


def straight(velocity_mps, steps=30, start_m=(0.0, 0.0)):
    return (np.arange(steps)[:, None] * PERIOD_S * np.asarray(velocity_mps) + np.asarray(start_m))[:, None]


def circle(speed_mps, radius_m, steps=40, phase_rad=0.0):
    turned = phase_rad + np.arange(steps) * PERIOD_S * speed_mps / radius_m
    return radius_m * np.stack([np.cos(turned), np.sin(turned)], axis=-1)[:, None]


def angle_between(a, b):
    return abs(np.arctan2(np.sin(a - b), np.cos(a - b)))


def turned(paths_m, angle_rad):
    c, s = cos(angle_rad), sin(angle_rad)
    return paths_m @ np.array([[c, -s], [s, c]]).T


WALKS = st.builds(
    lambda seed, speed, turn: (
        straight((speed * cos(turn), speed * sin(turn)), 20)
        + np.cumsum(np.random.default_rng(seed).normal(size=(20, 1, 2)), axis=0) * 1e-4
    ),
    SEEDS,
    st.floats(0.1, 0.6),
    ANGLES,
)


@given(WALKS, ANGLES)
@settings(max_examples=20, deadline=None)
def test_a_turned_world_turns_the_velocity(path_m, angle_rad):
    plain, other = (analysed(moments(one, stated_m=1e-3))[-1] for one in (path_m, turned(path_m, angle_rad)))
    assert np.abs(turned(plain.velocities_mps, angle_rad) - other.velocities_mps).max() < 1e-9
    assert angle_between(plain.headings_rad[0] + angle_rad, other.headings_rad[0]) < 1e-7


@given(WALKS, st.floats(-100, 100), st.floats(-100, 100))
@settings(max_examples=20, deadline=None)
def test_moving_the_world_changes_nothing(path_m, east_m, north_m):
    plain, other = (analysed(moments(one, stated_m=1e-3))[-1] for one in (path_m, path_m + np.array([east_m, north_m])))
    assert np.abs(plain.velocities_mps - other.velocities_mps).max() < 1e-9
    assert plain.states == other.states
    assert plain.directions == other.directions


@given(st.floats(0.1, 0.6), st.floats(0.8, 5.0), ANGLES)
@settings(max_examples=20, deadline=None)
def test_time_run_backwards_turns_a_circle_round(speed_mps, radius_m, phase_rad):
    path_m = circle(speed_mps, radius_m, 20, phase_rad)
    times_ns = np.arange(len(path_m)) * 40_000_000
    covs_m2 = np.tile(np.eye(2) * 1e-6, (len(path_m), 1, 1))
    (there,), (back,) = (parabolas(times_ns, one[:, 0], covs_m2, [0.8]) for one in (path_m, path_m[::-1]))
    turn_rad = there.span_s * speed_mps / radius_m
    assert np.abs(there.velocity_mps + turned(back.velocity_mps, turn_rad)).max() < 2e-5
    assert np.abs(there.covariance - back.covariance).max() < 1e-12


@given(st.floats(0.1, 0.6), ANGLES)
@settings(max_examples=20, deadline=None)
def test_the_way_back_has_the_opposite_direction(speed_mps, heading_rad):
    path_m = straight((speed_mps * cos(heading_rad), speed_mps * sin(heading_rad)))
    there, back = (analysed(moments(one, stated_m=1e-4))[-1] for one in (path_m, path_m[::-1]))
    assert np.abs(there.velocities_mps + back.velocities_mps).max() < 1e-9
    assert angle_between(there.headings_rad[0], heading_rad) < 1e-7


@given(st.floats(1.0, 5.0))
@settings(max_examples=15, deadline=None)
def test_a_covariance_k_times_as_wide_widens_the_sigmas_k_times(k):
    path_m = straight((0.3, 0.1))
    plain, wide = (analysed(moments(path_m, stated_m=stated_m))[-1] for stated_m in (1e-3, 1e-3 * k))
    assert abs(wide.speed_sigmas_mps[0] / plain.speed_sigmas_mps[0] - k) < 1e-6
    assert abs(wide.heading_sigmas_rad[0] / plain.heading_sigmas_rad[0] - k) < 1e-6


@given(ANGLES, SEEDS, st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
@settings(max_examples=20, deadline=None)
def test_an_error_that_all_places_share_hides_no_motion(heading_rad, seed, east_m, north_m):
    path_m = straight((1.4 * cos(heading_rad), 1.4 * sin(heading_rad)), 30, (east_m, north_m))
    said = analysed(moments(path_m, sigma_m=2e-3, seed=seed, stated_m=0.2))[-1]
    assert said.states == (MotionState.MOVING,)
    assert angle_between(said.headings_rad[0], heading_rad) < 5 * said.heading_sigmas_rad[0]
    assert 1e-3 < said.speed_sigmas_mps[0] < 0.1


@given(st.floats(1.0, 15.0), ANGLES, st.floats(-1.0, 1.0))
@settings(max_examples=20, deadline=None)
def test_a_shared_error_that_grows_along_the_way_is_in_the_stated_speed(speed_mps, heading_rad, share):
    growing = 1.0 + 0.01 * share  # calibration that is off by its stated 20 cm where it is off most, 20 m on
    path_m = growing * straight((speed_mps * cos(heading_rad), speed_mps * sin(heading_rad)), 30)
    said = analysed(moments(path_m, stated_m=0.2))[-1]
    assert said.states == (MotionState.MOVING,)
    assert abs(said.speeds_mps[0] - speed_mps) < 1.1 * said.speed_sigmas_mps[0]


@given(st.floats(0.15, 0.6), ANGLES, SEEDS, st.sampled_from([3e-4, 8e-4]))
@settings(max_examples=40, deadline=None)
def test_a_straight_motion_is_recovered_within_five_of_its_sigmas(speed_mps, heading_rad, seed, sigma_m):
    path_m = straight((speed_mps * cos(heading_rad), speed_mps * sin(heading_rad)), 40)
    said = analysed(moments(path_m, sigma_m=sigma_m, seed=seed))[-1]
    assert said.states == (MotionState.MOVING,)
    assert angle_between(said.headings_rad[0], heading_rad) < 5 * said.heading_sigmas_rad[0]
    assert abs(said.speeds_mps[0] - speed_mps) < 5 * said.speed_sigmas_mps[0]


@given(st.floats(0.2, 0.5), st.floats(0.4, 2.0), ANGLES)
@settings(max_examples=30, deadline=None)
def test_on_a_circle_the_heading_is_the_tangent_now(speed_mps, radius_m, phase_rad):
    said = analysed(moments(circle(speed_mps, radius_m, phase_rad=phase_rad)))[-1]
    tangent = phase_rad + 39 * PERIOD_S * speed_mps / radius_m + pi / 2
    assert angle_between(said.headings_rad[0], tangent) < 5e-4
    assert abs(said.speeds_mps[0] - speed_mps) < 2e-4


def test_many_noisy_circles_have_no_bias_and_keep_their_stated_sigma():
    speed_mps, radius_m, sigma_m = 0.35, 0.6, 5e-4
    phases = np.linspace(-pi, pi, 150, endpoint=False)
    paths = np.concatenate([circle(speed_mps, radius_m, 27, phase) for phase in phases], axis=1)
    said = analysed(moments(paths, sigma_m=sigma_m, seed=4))[-1]
    tangents = phases + 26 * PERIOD_S * speed_mps / radius_m + pi / 2
    errors = np.angle(np.exp(1j * (said.headings_rad - tangents)))
    assert abs(errors.mean()) < 0.006
    inside = np.abs(errors) < 1.645 * said.heading_sigmas_rad
    assert 0.75 < inside.mean() < 0.97


@given(SEEDS, st.sampled_from([3e-4, 8e-4, 3e-3]))
@settings(max_examples=10, deadline=None)
def test_noise_alone_never_moves_nor_turns(seed, sigma_m):
    said = analysed(moments(np.zeros((60, 5, 2)), sigma_m=sigma_m, seed=seed))
    assert {direction for one in said for direction in one.directions} == {None}
    assert set(said[-1].states) <= {MotionState.STANDING, MotionState.UNKNOWN}
    assert MotionState.STANDING in said[-1].states


def test_nothing_is_known_before_the_first_window_is_full_and_the_direction_soon_after():
    said = analysed(moments(straight((0.3, 0.0), 10)))
    full = next(k for k, one in enumerate(said) if one.valid[0])
    assert full * PERIOD_S >= 0.8 * WINDOWS_S[0]
    assert all(one.states == (MotionState.UNKNOWN,) and np.isnan(one.velocities_mps).all() for one in said[:full])
    assert said[-1].directions == (Compass.EAST,)


@pytest.mark.parametrize("sigma_m", [0.0, 3e-4, 8e-4])
def test_after_turning_round_it_is_right_again_within_a_window(sigma_m):
    times_s = np.arange(100) * PERIOD_S
    east_m = np.where(times_s < 2.0, 0.3 * times_s, 0.6 - 0.3 * (times_s - 2.0))
    said = analysed(moments(np.stack([east_m, 0 * east_m], axis=-1)[:, None], sigma_m=sigma_m, seed=1))
    directions = [one.directions[0] for one in said[10:]]
    assert set(directions) == {Compass.EAST, Compass.WEST}
    flip = directions.index(Compass.WEST)
    assert 2.0 < times_s[10 + flip] < 2.5
    assert set(directions[flip:]) == {Compass.WEST}


@pytest.mark.parametrize("sigma_m", [0.0, 3e-4, 8e-4])
def test_a_dead_stop_is_no_motion_backwards_and_soon_a_standing(sigma_m):
    times_s = np.arange(100) * PERIOD_S
    east_m = 0.45 * np.minimum(times_s, 2.0)
    said = analysed(moments(np.stack([east_m, 0 * east_m], axis=-1)[:, None], sigma_m=sigma_m, seed=2))
    assert {one.directions[0] for one in said} == {None, Compass.EAST}
    assert all(one.states[0] == MotionState.STANDING for one, t in zip(said, times_s, strict=True) if t > 2.7)


def test_one_place_that_is_off_does_not_start_a_standing_vehicle():
    path_m = np.zeros((60, 1, 2))
    path_m[40, 0, 0] = 0.003
    said = analysed(moments(path_m, sigma_m=3e-4, seed=3))
    assert {one.directions[0] for one in said} == {None}


def test_the_direction_survives_a_gap_and_counts_time_not_frames():
    kept = np.r_[0:20, 32:50]
    grounds = moments(straight((0.0, -0.3), 50)[kept], times_s=kept * PERIOD_S, stated_m=3e-4)
    said = analysed(grounds)
    assert {one.directions[0] for one in said[10:]} == {Compass.SOUTH}
    assert abs(said[20].velocities_mps[0, 1] + 0.3) < 1e-9


def test_after_a_gap_longer_than_any_window_everything_is_unknown():
    grounds = moments(straight((0.3, 0.0), 20), stated_m=3e-4)
    analyst = WindowAnalyst()
    for ground in grounds:
        analyst.analyse(ground)
    later = replace(grounds[-1], time_ns=grounds[-1].time_ns + round(1.2e9))
    assert analyst.analyse(later).states == (MotionState.UNKNOWN,)


def test_memory_is_bounded_whatever_comes():
    analyst = WindowAnalyst()
    for k in range(600):
        ground = GroundTracks(
            "fused", k * 1_000_000, [0, k + 1], "ab", np.zeros((2, 2)), np.zeros((2, 2, 2)), [True] * 2
        )
        analyst.analyse(ground)
    assert len(analyst._memories[0].places) == PLACES
    analyst.analyse(GroundTracks("fused", 10**10, [], (), [], [], []))
    assert analyst._memories == {}


def test_reset_forgets_everything():
    grounds = moments(straight((0.3, 0.1), 15), sigma_m=3e-4)
    analyst = WindowAnalyst()
    first = [analyst.analyse(ground).velocities_mps for ground in grounds]
    analyst.reset()
    again = [analyst.analyse(ground).velocities_mps for ground in grounds]
    assert np.array_equal(first, again, equal_nan=True)


def test_on_a_diagonal_the_direction_does_not_chatter():
    heading_rad = pi / 4
    path_m = straight((0.3 * cos(heading_rad), 0.3 * sin(heading_rad)), 100)
    said = analysed(moments(path_m, sigma_m=3e-4, seed=5))
    assert len({one.directions[0] for one in said[20:]}) == 1


def test_a_place_that_is_not_valid_is_unknown_and_forgets_nothing():
    grounds = moments(straight((0.3, 0.0), 20), stated_m=3e-4)
    hole = replace(grounds[10], valid=[False], positions_m=[[np.nan, np.nan]])
    said = analysed([*grounds[:10], hole, *grounds[11:]])
    assert said[10].states == (MotionState.UNKNOWN,)
    assert said[11].directions == (Compass.EAST,)


def test_it_is_an_analyst_and_an_empty_moment_has_no_motions():
    analyst = WindowAnalyst()
    assert isinstance(analyst, Analyst)
    assert len(analyst.analyse(GroundTracks("fused", 0, [], (), [], [], []))) == 0


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"time_ns": 0}, "must rise"),
        ({"ids": [3, 3]}, "twice"),
        ({"positions_m": [[0.0, np.nan], [0.0, 0.0]]}, "finite"),
        ({"covs_m2": np.tile(-np.eye(2), (2, 1, 1))}, "negative"),
    ],
)
def test_wrong_input_is_refused(change, says):
    first, second = moments(np.zeros((2, 2, 2)), stated_m=1e-3)
    analyst = WindowAnalyst()
    analyst.analyse(first)
    with pytest.raises(InputError, match=says):
        analyst.analyse(replace(second, **change))


@pytest.mark.parametrize("times_ns", [[], [0, 0], [10, 0]])
def test_a_parabola_needs_times_that_rise(times_ns):
    n = len(times_ns)
    with pytest.raises(InputError, match="rising times"):
        parabolas(np.array(times_ns, np.int64), np.zeros((n, 2)), np.zeros((n, 2, 2)), [1.0])


KNOWN = Motions.unknown(moments(np.zeros((1, 2, 2)))[0])


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"ids": [1]}, "ids"),
        ({"velocities_mps": np.zeros((2, 3))}, "velocities_mps"),
        ({"velocity_covs_m2ps2": np.zeros((2, 2))}, "covs"),
        ({"states": (MotionState.UNKNOWN,)}, "1 states"),
        ({"states": ("rolling", MotionState.UNKNOWN)}, "rolling"),
        ({"directions": ("up", None)}, "up"),
        ({"directions": (Compass.EAST, None)}, "cannot have the direction"),
        ({"states": (MotionState.MOVING, MotionState.UNKNOWN)}, "cannot have the direction None"),
    ],
)
def test_motions_that_contradict_themselves_are_refused(change, says):
    with pytest.raises(InputError, match=says):
        replace(KNOWN, **change)


@given(ANGLES)
def test_the_compass_is_the_nearest_of_four(heading_rad):
    nearest = min(Compass, key=lambda one: angle_between(one.heading_rad, heading_rad))
    assert angle_between(compass(heading_rad).heading_rad, heading_rad) < angle_between(
        nearest.heading_rad, heading_rad
    ) + (1e-9)
