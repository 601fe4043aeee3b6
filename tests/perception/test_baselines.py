"""The baselines on drawn frames, and the laws of their masks and mixtures."""

import numpy as np
import pytest
from conftest import LABELS
from drawn_frames import Box, draw, floor, frame_of, random_boxes, training_frames
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.check import check_detector
from contracts import Detector, InputError
from perception.baselines.colour_mixture import ColourMixture
from perception.baselines.colour_range import ColourRange, in_hsv_range
from perception.baselines.colour_ratio import ColourRatio, component_ratios
from perception.baselines.colours import SHIPPED, Bounds, PlainColours
from perception.baselines.learning import learn_colours
from perception.baselines.mixture import Mixture, fit_mixture, log_sum
from perception.colour_models import ColourModels
from perception.hue_saturation import hue_saturation_value

BASELINES = [ColourRange, ColourRatio, ColourMixture]
every_baseline = pytest.mark.parametrize("baseline", BASELINES)


@pytest.fixture(scope="module")
def colours() -> PlainColours:
    return learn_colours(training_frames(1, LABELS, 20))


@every_baseline
def test_each_drawn_vehicle_is_found_once_within_a_third_of_a_pixel(models, colours, baseline, rng):
    detector = baseline(models, colours=colours)
    assert isinstance(detector, Detector)
    for _ in range(4):
        drawn = random_boxes(rng, LABELS)
        found = detector.detect(frame_of(draw(floor(rng), drawn, gain=rng.uniform(0.7, 1.1))))
        assert found.labels == LABELS
        assert np.abs(found.anchors_px - [box.centre_px for box in drawn]).max() < 0.33


@every_baseline
def test_a_frame_without_vehicles_gives_nothing(models, colours, baseline, rng):
    for image in (floor(rng), np.zeros((90, 160, 3), np.uint8), np.full((3, 2, 3), 255, np.uint8)):
        assert len(baseline(models, colours=colours).detect(frame_of(image))) == 0


@every_baseline
def test_the_vehicle_is_told_from_smaller_and_larger_things_of_its_colour(models, colours, baseline, rng):
    things = [Box("blue", (80.0, 60.0), size_px=(20.0, 20.0)), Box("blue", (480.0, 80.0), size_px=(240.0, 100.0))]
    box = Box("blue", (300.0, 270.0), heading_rad=0.4)
    found = baseline(models, colours=colours).detect(frame_of(draw(floor(rng), [*things, box])))
    assert found.labels == ("blue",)
    assert np.abs(found.anchors_px[0] - box.centre_px).max() < 0.33


@every_baseline
def test_the_shipped_baselines_keep_the_contract_of_a_detector(baseline):
    assert check_detector(baseline) == []


@every_baseline
def test_what_is_measured_is_the_mask_itself(models, colours, baseline, rng):
    image = draw(floor(rng), [Box("blue", (300.0, 170.0), heading_rad=0.3)])
    detector = baseline(models, colours=colours)
    outline = detector.silhouettes(image)["blue"]
    left, top = outline.origin_px
    height, width = outline.raw.shape
    mask = detector.masks(image)[0][top : top + height, left : left + width]
    assert set(np.unique(mask)) <= {0, 1}
    assert (outline.raw == (mask & outline.mask)).all()
    assert outline.rectangularity > 0.8


@given(st.integers(0, 179), st.integers(0, 179))
@settings(max_examples=30, deadline=None)
def test_a_hue_range_holds_the_same_hues_wherever_the_circle_is_cut(low, high):
    hues = np.arange(180, dtype=np.uint8)
    hsv = np.stack([hues, np.full(180, 200, np.uint8), np.full(180, 90, np.uint8)], axis=-1)[None]
    inside = in_hsv_range(hsv, Bounds([low, 100, 50], [high, 255, 255]))[0]
    assert (inside == ((hues.astype(int) - low) % 180 <= (high - low) % 180)).all()


def test_saturation_and_value_are_held_too():
    hsv = hue_saturation_value(np.array([[[200, 40, 40], [60, 50, 50], [20, 4, 4]]], np.uint8))
    assert in_hsv_range(hsv, Bounds([100, 150, 60], [140, 255, 255])).tolist() == [[1, 0, 0]]


def test_ratios_stay_when_the_light_scales():
    colour = np.array([[[30, 100, 180]]], np.uint8)
    assert np.abs(component_ratios(colour) / component_ratios(colour // 2) - 1).max() < 0.05
    assert np.isfinite(component_ratios(np.zeros((1, 1, 3), np.uint8))).all()


def test_a_mixture_recovers_the_parts_that_its_colours_were_drawn_from(rng):
    means = np.array([[40.0, 60.0, 50.0], [200.0, 180.0, 220.0]])
    drawn = np.concatenate([rng.normal(means[0], 6.0, (3000, 3)), rng.normal(means[1], 9.0, (1000, 3))])
    mixture = fit_mixture(drawn, 2)
    assert np.abs(mixture.weights - (0.75, 0.25)).max() < 0.001
    assert np.abs(mixture.means - means).max() < 1.0
    assert np.abs(np.sqrt(mixture.covariances[:, range(3), range(3)]) - [[6], [9]]).max() < 0.5


def test_densities_are_those_of_the_gaussian_formula(rng):
    root = rng.normal(0, 4, (2, 3, 3))
    covariances = root @ root.transpose(0, 2, 1) + np.eye(3)
    mixture = Mixture([0.3, 0.7], rng.uniform(0, 255, (2, 3)), covariances)
    colours = rng.uniform(0, 255, (50, 3))
    apart = colours[:, None] - mixture.means
    squares = np.einsum("nki,kij,nkj->nk", apart, np.linalg.inv(covariances), apart)
    expected = np.log(mixture.weights) - 0.5 * (squares + np.linalg.slogdet(2 * np.pi * covariances)[1])
    assert np.abs(mixture.log_densities(colours) - expected).max() < 1e-6 * np.abs(expected).max()
    assert np.abs(log_sum(expected) - np.logaddexp(*expected.T)).max() < 1e-9


def test_fitting_never_makes_the_colours_less_likely_than_one_gaussian(rng):
    drawn = rng.gamma(2.0, 20.0, (500, 3))
    one, four = fit_mixture(drawn, 1), fit_mixture(drawn, 4)
    assert log_sum(four.log_densities(drawn)).mean() >= log_sum(one.log_densities(drawn)).mean()


def test_colours_survive_their_file(colours, tmp_path):
    colours.save(tmp_path / "colours.json")
    again = PlainColours.load(tmp_path / "colours.json")
    for one, other in zip(colours.colours, again.colours, strict=True):
        assert one.label == other.label
        assert np.abs(one.mixture.covariances - other.mixture.covariances).max() < 1e-5
        assert np.abs(one.ratios.high - other.ratios.high).max() < 1e-5


def test_the_shipped_files_know_the_same_colours():
    shipped = [colour.label for colour in PlainColours.load(SHIPPED).colours]
    path = SHIPPED.with_name("rail.json")
    assert shipped == [model.label for model in ColourModels.load(path).models]


def test_wrong_input_is_refused_by_name(models, colours, tmp_path):
    with pytest.raises(InputError, match="know no red"):
        ColourRange(models, colours=PlainColours(colours.colours[:1]))
    with pytest.raises(InputError, match="unique"):
        PlainColours(colours.colours + colours.colours)
    with pytest.raises(InputError, match="there is no colour"):
        PlainColours(())
    with pytest.raises(InputError, match="none of the samples"):
        learn_colours([])
    with pytest.raises(InputError, match="at least 20 colours"):
        fit_mixture(np.zeros((5, 3)), 2)
    with pytest.raises(InputError, match="of sum 1"):
        Mixture([0.5, 0.6], np.zeros((2, 3)), np.stack([np.eye(3)] * 2))
    with pytest.raises(InputError, match="positive definite"):
        Mixture([1.0], np.zeros((1, 3)), np.zeros((1, 3, 3)))
    with pytest.raises(InputError, match="cannot be read"):
        PlainColours.load(tmp_path / "none.json")
    (tmp_path / "broken.json").write_text('{"colours": [{"label": 3}]}')
    with pytest.raises(InputError, match=r"broken\.json: these are no colours"):
        PlainColours.load(tmp_path / "broken.json")
