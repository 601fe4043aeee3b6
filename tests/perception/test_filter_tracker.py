"""Trackers by a filter alone: MOSSE's laws, and what both perceivers keep over drawn films."""

import numpy as np
import pytest
from drawn_frames import Box, draw, floor, frame_of, training_frames
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.check import check_perceiver
from contracts import InputError
from perception.filter_tracker import FilterTracker
from perception.hbp import HistogramBackProjection
from perception.kcf import CorrelationTracker
from perception.learning import learn
from perception.mosse import MosseFilter

BACKGROUND = floor(np.random.default_rng(21))
FILTERS = [CorrelationTracker, MosseFilter]
START = np.array([300.0, 180.0])


@pytest.fixture(scope="module")
def models():
    return learn(training_frames(4, ("blue", "red"), 6))


@given(st.integers(-6, 6), st.integers(-6, 6))
@settings(max_examples=15, deadline=None)
def test_mosse_finds_a_shift_of_the_whole_picture(du, dv):
    seeker = MosseFilter()
    image = draw(BACKGROUND, [Box("red", tuple(START))])
    seeker.start(image, START, (70.0, 35.0), 0.0)
    here = seeker.find(image, START, 0.0)
    there = seeker.find(np.roll(image, (dv, du), axis=(0, 1)), START, 0.0)
    assert np.abs(there.centre_px - here.centre_px - (du, dv)).max() < 1.5
    moved = seeker.find(np.roll(image, (dv, du), axis=(0, 1)), START + np.array([du, dv]), 0.0)
    assert np.abs(moved.centre_px - here.centre_px - (du, dv)).max() < 0.05


def test_mosse_tells_a_target_that_is_gone():
    seeker = MosseFilter()
    image = draw(BACKGROUND, [Box("red", tuple(START))])
    seeker.start(image, START, (70.0, 35.0), 0.0)
    assert seeker.find(image, START, 0.0).confidence > 2 * seeker.find(BACKGROUND, START, 0.0).confidence


def test_mosse_learns_what_it_is_shown():
    seeker = MosseFilter()
    red, blue = (draw(BACKGROUND, [Box(label, tuple(START))]) for label in ("red", "blue"))
    seeker.start(red, START, (70.0, 35.0), 0.0)
    before = seeker.find(blue, START, 0.0).height
    for _ in range(30):
        seeker.learn(blue, START, 0.0)
    assert seeker.find(blue, START, 0.0).height > before


def test_mosse_refuses_to_find_before_it_has_started_and_to_start_on_nothing():
    with pytest.raises(InputError, match="start"):
        MosseFilter().find(BACKGROUND, START, 0.0)
    with pytest.raises(InputError, match="size_px"):
        MosseFilter().start(BACKGROUND, START, (0.0, 10.0), 0.0)


@pytest.mark.parametrize("make_filter", FILTERS)
def test_a_vehicle_is_followed_between_searches_and_given_up_when_it_is_gone(models, make_filter):
    tracker = FilterTracker(HistogramBackProjection(models), make_filter)
    for index in range(25):
        box = Box("red", (150.0 + 8 * index, 180.0))
        tracks = tracker.perceive(frame_of(draw(BACKGROUND, [box]), index))
        assert tracks.objects.labels == ("red",)
        assert np.abs(tracks.objects.anchors_px[0] - box.centre_px).max() < 4.0
    assert not len(tracker.perceive(frame_of(BACKGROUND, 25)))


def test_a_turning_vehicle_keeps_its_outline(models):
    tracker = FilterTracker(HistogramBackProjection(models), CorrelationTracker)
    radius, step = 120.0, 0.06
    for index in range(25):
        angle = index * step
        box = Box("blue", (300 + radius * np.sin(angle), 300 - radius * np.cos(angle)), heading_rad=angle)
        tracks = tracker.perceive(frame_of(draw(BACKGROUND, [box]), index))
        assert np.abs(tracks.objects.anchors_px[0] - box.centre_px).max() < 4.0
    side = tracks.objects.quads_px[0][1] - tracks.objects.quads_px[0][0]
    off = (np.arctan2(side[1], side[0]) - angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(off) < 0.15


@pytest.mark.parametrize("make_filter", FILTERS)
def test_the_perceivers_contract_holds(models, make_filter):
    assert check_perceiver(lambda: FilterTracker(HistogramBackProjection(models), make_filter)) == []
