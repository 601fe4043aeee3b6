import numpy as np
import pytest
from drawn_frames import Box, draw, floor, frame_of, labelled, training_frames

from contracts import InputError
from perception.learning import LabelledFrame, learn
from perception.view import straight_down

CAMERA = straight_down(800.0, 2.0, (640, 360))


def test_learning_is_deterministic_and_sorts_the_labels():
    once, again = (learn(training_frames(3, ("red", "blue"), 4)) for _ in range(2))
    assert [model.label for model in once.models] == ["blue", "red"]
    for a, b in zip(once.models, again.models, strict=True):
        assert (a.histogram == b.histogram).all()
        assert a.anchor_moments_px2 == b.anchor_moments_px2


def test_sizes_and_height_are_those_marked(models):
    for model in models.models:
        assert model.roof_size_m == pytest.approx((0.14, 0.07), abs=1e-4)
        assert model.roof_height_m == pytest.approx(0.06)


def test_the_stated_errors_grow_from_both_ends_to_one_to_none(models):
    for model in models.models:
        moments = model.anchor_moments_px2
        for axis in range(2):
            assert moments["both"][axis] < moments["single"][axis] < moments["rough"][axis]
        assert max(moments["both"]) < 0.2**2


def test_colours_of_the_background_are_suppressed(rng):
    boxes = [Box("red", (300.0, 180.0)), Box("green", (480.0, 200.0))]
    plain = labelled(draw(floor(rng), boxes), boxes)
    greenery = floor(rng)
    greenery[20:50, 20:80] = (60, 150, 40)
    before, after = learn([plain]), learn([plain, labelled(greenery, [])])
    green, red = (
        late.histogram / np.maximum(early.histogram, 1e-4)
        for early, late in zip(before.models, after.models, strict=True)
    )
    assert green[before.models[0].histogram > 0.4].min() < 0.8
    assert np.abs(red[before.models[1].histogram > 0.4] - 1).max() < 0.01


def test_nothing_to_learn_from_is_refused(rng):
    empty = labelled(floor(rng), [])
    outside = labelled(draw(floor(rng), []), [Box("red", (-10.0, 50.0))])
    for samples in ([], [empty], [outside]):
        with pytest.raises(InputError, match="wholly inside"):
            learn(samples)


def test_a_vehicle_like_its_background_is_refused(rng):
    box = Box("grey", (300.0, 180.0), colour_bgr=(118, 122, 126))
    with pytest.raises(InputError, match="grey"):
        learn([labelled(draw(floor(rng), [box]), [box])])


def test_marks_that_do_not_fit_the_labels_are_refused(rng):
    with pytest.raises(InputError, match="roof_quads_px"):
        LabelledFrame(frame_of(floor(rng)), CAMERA, ("red",), np.zeros((2, 4, 2)), np.zeros(1), np.ones(1))
    with pytest.raises(InputError, match="heights_m"):
        LabelledFrame(frame_of(floor(rng)), CAMERA, ("red",), np.zeros((1, 4, 2)), np.zeros(2), np.ones(1))
