"""The watch over drawn frames: news is what has a vehicle's colour where none was."""

import numpy as np
import pytest
from drawn_frames import Box, draw, floor, training_frames
from hypothesis import given, settings
from hypothesis import strategies as st

from perception.colour_models import ColourModels
from perception.colour_table import coarse_colours, distinctive_colours
from perception.learning import learn
from perception.watch import STRIDE_PX, ColourWatch

BACKGROUND = floor(np.random.default_rng(5))
LABELS = ("blue", "red", "green")


@pytest.fixture(scope="module")
def models() -> ColourModels:
    return learn(training_frames(1, LABELS, 6))


def test_everything_is_news_before_the_first_search(models):
    assert ColourWatch(models).stirs(BACKGROUND, ())


@given(st.sampled_from(LABELS), st.floats(60, 580), st.floats(60, 300), st.floats(-np.pi, np.pi))
@settings(max_examples=15, deadline=None)
def test_a_vehicle_that_shows_up_is_news_until_it_is_followed_or_searched(models, label, u, v, heading):
    watch = ColourWatch(models)
    watch.settle(BACKGROUND)
    assert not watch.stirs(BACKGROUND, ())
    image = draw(BACKGROUND, [Box(label, (u, v), heading_rad=heading)])
    assert watch.stirs(image, ())
    assert watch.stirs(image, [other for other in LABELS if other != label])
    assert not watch.stirs(image, [label])
    watch.settle(image)
    assert not watch.stirs(image, ())
    watch.reset()
    assert watch.stirs(image, ())


def test_what_stands_still_is_no_news_though_it_moves_by_a_cell(models):
    watch = ColourWatch(models)
    watch.settle(draw(BACKGROUND, [Box("red", (300.0, 180.0))]))
    assert not watch.stirs(draw(BACKGROUND, [Box("red", (300.0 + STRIDE_PX, 180.0))]), ())
    assert watch.stirs(draw(BACKGROUND, [Box("red", (300.0 + 10 * STRIDE_PX, 180.0))]), ())


def test_no_coarse_colour_belongs_to_two_vehicles(models):
    assert distinctive_colours(models.models).sum(axis=0).max() == 1


def test_a_vehicles_colour_is_found_in_the_table_at_any_light(models):
    for row, model in enumerate(models.models):
        for gain in (0.5, 1.0, 1.2):
            image = draw(BACKGROUND, [Box(model.label, (300.0, 180.0), size_px=(200.0, 100.0))], gain=gain)
            roof = coarse_colours(image[150:210, 250:350])
            assert distinctive_colours(models.models)[row][roof].mean() > 0.99
