"""The correlation filter on drawn vehicles, whose place is known to a fraction of a pixel."""

import numpy as np
import pytest
from drawn_frames import Box, draw, floor
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import InputError
from perception.kcf import CorrelationTracker, Features, KcfSettings

SIZE = (70.0, 35.0)
START = np.array([200.0, 150.0])
SEEDS = st.integers(0, 2**32 - 1)
WITHIN_PX = {Features.COLOUR: 0.3, Features.GREY: 0.6}
CHANNELS = st.sampled_from([Features.COLOUR, Features.GREY])
FEATURES = st.sampled_from(list(Features))


def scene(seed):
    return floor(np.random.default_rng(seed), (300, 400))


def beside(u, v):
    return START + np.array([u, v])


def texture(seed, moved_px):
    """(300, 400, 3) soft noise, moved as a whole by any fraction of a pixel: exact, since it is periodic."""
    wave = np.fft.rfft2(np.random.default_rng(seed).normal(size=(300, 400)))
    v, u = np.fft.fftfreq(300)[:, None], np.fft.rfftfreq(400)
    soft = np.exp(-((u**2 + v**2) * (2 * np.pi * 2.0) ** 2) / 2)
    noise = np.fft.irfft2(wave * soft * np.exp(-2j * np.pi * (u * moved_px[0] + v * moved_px[1])), s=(300, 400))
    grey = np.clip(128 + 300 * noise, 0, 255).round().astype(np.uint8)
    return np.dstack([grey, grey, grey])


def vehicle(place, heading=0.0, label="red"):
    return Box(label, (float(place[0]), float(place[1])), heading_rad=heading)


def started(background, heading=0.0, features=Features.COLOUR, label="red", samples=None):
    samples = samples or (8192 if features == Features.HOG else 2048)
    tracker = CorrelationTracker(KcfSettings(features=features, samples=samples))
    tracker.start(draw(background, [vehicle(START, heading, label)]), START, SIZE, heading)
    return tracker


@settings(max_examples=20, deadline=None)
@given(SEEDS, st.floats(-3, 3), st.floats(-3, 3), st.floats(-np.pi, np.pi))
def test_a_shift_by_a_fraction_of_a_pixel_is_found_within_a_tenth(seed, u, v, heading):
    tracker = CorrelationTracker()
    tracker.start(texture(seed, (0.0, 0.0)), START, SIZE, heading)
    assert np.abs(tracker.find(texture(seed, (u, v)), START, heading).centre_px - beside(u, v)).max() < 0.1


@settings(max_examples=10, deadline=None)
@given(SEEDS, st.floats(-3, 3), st.floats(-3, 3), st.floats(-np.pi, np.pi))
def test_cells_of_gradients_find_the_fraction_within_a_quarter(seed, u, v, heading):
    tracker = CorrelationTracker(KcfSettings(features=Features.HOG, samples=8192))
    tracker.start(texture(seed, (0.0, 0.0)), START, SIZE, heading)
    assert np.abs(tracker.find(texture(seed, (u, v)), START, heading).centre_px - beside(u, v)).max() < 0.25


@settings(max_examples=12, deadline=None)
@given(SEEDS, CHANNELS, st.floats(-3, 3), st.floats(-3, 3), st.floats(-np.pi, np.pi))
def test_a_vehicle_that_moves_over_the_floor_is_found_where_it_is(seed, features, u, v, heading):
    background = scene(seed)
    found = started(background, heading, features).find(
        draw(background, [vehicle(beside(u, v), heading)]), START, heading
    )
    assert np.abs(found.centre_px - beside(u, v)).max() < WITHIN_PX[features]


@settings(max_examples=8, deadline=None)
@given(SEEDS, st.integers(-12, 12), st.integers(-12, 12))
def test_a_whole_image_that_moves_by_whole_pixels_moves_the_answer_by_exactly_that(seed, u, v):
    image = draw(scene(seed), [vehicle(START)])
    tracker = started(scene(seed), samples=4096)
    here = tracker.find(image, START, 0.0)
    there = tracker.find(np.roll(image, (v, u), axis=(0, 1)), beside(u, v), 0.0)
    np.testing.assert_allclose(there.centre_px - here.centre_px, (u, v), rtol=0, atol=0.02)


@settings(max_examples=8, deadline=None)
@given(SEEDS, CHANNELS, st.floats(0.6, 1.0), st.integers(0, 40))
def test_brightness_and_contrast_leave_the_answer_where_it_is(seed, features, gain, offset):
    image = draw(scene(seed), [vehicle(beside(1.3, -0.8))])
    tracker = started(scene(seed), features=features)
    other = np.round(image * gain + offset).astype(np.uint8)
    shift = tracker.find(other, START, 0.0).centre_px - tracker.find(image, START, 0.0).centre_px
    assert np.abs(shift).max() < 0.05


@settings(max_examples=8, deadline=None)
@given(SEEDS, st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi))
def test_a_turned_vehicle_is_found_where_it_is_if_its_heading_is_known(seed, before, after):
    background, place = scene(seed), beside(1.7, 2.2)
    found = started(background, before).find(draw(background, [vehicle(place, after)]), START, after)
    assert np.abs(found.centre_px - place).max() < 0.25


@settings(max_examples=10, deadline=None)
@given(SEEDS, FEATURES)
def test_a_target_that_is_gone_is_known_by_its_confidence(seed, features):
    background = scene(seed)
    tracker = started(background, features=features)
    here = tracker.find(draw(background, [vehicle(beside(2.0, 1.0))]), START, 0.0)
    gone = tracker.find(draw(background, []), START, 0.0)
    other = tracker.find(draw(scene(seed + 1), []), START, 0.0)
    assert max(gone.confidence, other.confidence) < 0.5 * here.confidence
    assert max(gone.height, other.height) < here.height


def test_it_follows_a_vehicle_round_a_circle_and_comes_back_unbiased(rng):
    background = floor(rng, (400, 400))
    on_circle = [(np.array([200 + 110 * np.sin(a), 200 - 110 * np.cos(a)]), a) for a in np.linspace(0, 2 * np.pi, 90)]
    tracker = CorrelationTracker()
    place, heading = on_circle[0]
    tracker.start(draw(background, [vehicle(place, heading)]), place, SIZE, heading)
    for true_place, heading in on_circle[1:]:
        image = draw(background, [vehicle(true_place, heading)])
        place = tracker.find(image, place, heading).centre_px
        tracker.learn(image, place, heading)
        assert np.hypot(*(place - true_place)) < 0.5


def test_finding_learns_nothing_and_learning_what_was_found_agrees_with_learning_from_afresh():
    background = scene(3)
    image = draw(background, [vehicle(beside(2.0, 1.0))])
    one, two = started(background), started(background)
    first = one.find(image, START, 0.0)
    again = one.find(image, START, 0.0)
    np.testing.assert_array_equal(first.centre_px, again.centre_px)
    one.learn(image, first.centre_px, 0.0)
    two.learn(image, first.centre_px, 0.0)
    a, b = one.find(image, START, 0.0), two.find(image, START, 0.0)
    np.testing.assert_allclose(a.centre_px, b.centre_px, rtol=0, atol=1e-6)


def test_what_is_learned_replaces_what_was(rng):
    background = scene(4)
    tracker = CorrelationTracker(KcfSettings(learning_rate=0.5, features=Features.GREY))
    tracker.start(draw(background, [vehicle(START, label="blue")]), START, SIZE, 0.0)
    image = draw(background, [vehicle(START, label="yellow")])
    before = tracker.find(image, START, 0.0).height
    for _ in range(6):
        tracker.learn(image, START, 0.0)
    assert tracker.find(image, START, 0.0).height > max(0.9, before)


def test_images_are_not_changed():
    image = draw(scene(5), [vehicle(START)])
    image.setflags(write=False)
    tracker = CorrelationTracker()
    tracker.start(image, START, SIZE, 0.1)
    tracker.find(image, START, 0.1)
    tracker.learn(image, START, 0.1)


@pytest.mark.parametrize(
    "wrong",
    [
        {"features": "sepia"},
        {"padding": 1.0},
        {"samples": 10},
        {"bandwidth": 0.0},
        {"ridge": float("nan")},
        {"target_sigma": -1.0},
        {"learning_rate": 1.5},
        {"looks": 0},
    ],
)
def test_impossible_settings_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        KcfSettings(**wrong)


def test_a_target_without_size_and_a_search_without_target_are_refused():
    image = draw(scene(6), [])
    with pytest.raises(InputError, match="start"):
        CorrelationTracker().find(image, START, 0.0)
    with pytest.raises(InputError, match="start"):
        CorrelationTracker().learn(image, START, 0.0)
    with pytest.raises(InputError, match="size_px"):
        CorrelationTracker().start(image, START, (0.0, 10.0), 0.0)
