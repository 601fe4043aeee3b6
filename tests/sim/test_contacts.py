from functools import partial

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenarios.strategies import boxes
from sim.boxes import Box, separation_m
from sim.contacts import TOUCH_M, first_touch

FRAME_S = 0.04
SAMPLES = 1501


def flown(box: Box, velocity_mps: tuple[float, float], spin_radps: float, time_s: float) -> Box:
    x, y = box.x_m + velocity_mps[0] * time_s, box.y_m + velocity_mps[1] * time_s
    return Box(x, y, box.heading_rad + spin_radps * time_s, box.length_m, box.width_m)


def point_speed_mps(box: Box, velocity_mps: tuple[float, float], spin_radps: float) -> float:
    return float(np.hypot(*velocity_mps) + abs(spin_radps) * np.hypot(box.length_m, box.width_m) / 2)


@st.composite
def flights(draw):
    box = draw(boxes())
    speed = st.floats(-10.0, 10.0)
    velocity, spin = (draw(speed), draw(speed)), draw(st.floats(-20.0, 20.0))
    return partial(flown, box, velocity, spin), point_speed_mps(box, velocity, spin)


def sampled_gaps(a, b, until_s: float) -> tuple[np.ndarray, np.ndarray]:
    """The oracle: gaps at many moments."""
    times = np.linspace(0.0, until_s, SAMPLES)
    return times, np.array([separation_m(a(t), b(t)) for t in times])


@given(flights(), flights())
def test_no_contact_that_fine_sampling_finds_is_missed_and_none_is_invented(first, second):
    (a, speed_a), (b, speed_b) = first, second
    time_s = first_touch(a, b, closing_mps=speed_a + speed_b, until_s=FRAME_S)
    times, gaps = sampled_gaps(a, b, FRAME_S)
    touching = times[gaps <= 0.0]
    if time_s is None:
        assert not touching.size
    else:
        assert separation_m(a(time_s), b(time_s)) <= TOUCH_M
        assert not touching.size or time_s <= touching[0]
        assert (gaps[times < time_s] > 0.0).all()


@given(st.floats(0.05, 0.9), st.floats(0.5, 5.0))
def test_a_contact_much_shorter_than_a_frame_is_found_at_its_time(start_share, speed_mps):
    """A thin box flies past the corner of another and grazes it by 50 um: seen at no frame."""
    standing = Box(0.0, 0.0, np.pi / 4, 0.1, 0.1)
    corner_m = 0.1 / np.sqrt(2.0)
    touch_s = start_share * FRAME_S
    depth_m = 50e-6
    height_m = corner_m + 0.005 - depth_m
    thin = Box(-depth_m - 0.0005 - speed_mps * touch_s, height_m, 0.0, 0.001, 0.01)
    passing = partial(flown, thin, (speed_mps, 0.0), 0.0)
    time_s = first_touch(lambda _: standing, passing, closing_mps=speed_mps, until_s=FRAME_S)
    assert separation_m(standing, passing(0.0)) > 0.0
    assert time_s is not None
    assert abs(time_s - touch_s) * speed_mps < 1e-5


def test_boxes_that_do_not_approach_are_looked_at_once():
    calls = []

    def still(x_m: float, time_s: float) -> Box:
        calls.append(time_s)
        return Box(x_m, 0.0, 0.0, 0.1, 0.1)

    assert first_touch(partial(still, 0.0), partial(still, 0.2), closing_mps=0.0, until_s=1.0) is None
    assert calls == [0.0, 0.0]
