import numpy as np
import pytest
from drawn_frames import draw, floor, frame_of, random_boxes, training_frames

from contracts import Detector
from perception.colour_models import ColourModels
from perception.hbp import HistogramBackProjection, disc
from perception.learning import learn

LABELS = ("blue", "red")


@pytest.fixture(scope="module")
def models() -> ColourModels:
    return learn(training_frames(1, LABELS, 25))


def test_each_vehicle_is_found_once_near_its_place(models):
    rng = np.random.default_rng(2)
    detector = HistogramBackProjection(models)
    assert isinstance(detector, Detector)
    for _ in range(10):
        boxes = random_boxes(rng, LABELS)
        found = detector.detect(frame_of(draw(floor(rng), boxes)))
        assert found.labels == LABELS
        offsets = found.anchors_px - [box.centre_px for box in boxes]
        assert np.abs(offsets).max() < 0.3


def test_an_empty_floor_gives_nothing(models):
    frame = frame_of(floor(np.random.default_rng(3)))
    assert len(HistogramBackProjection(models).detect(frame)) == 0


def test_vehicles_of_other_colours_give_nothing(models):
    rng = np.random.default_rng(4)
    frame = frame_of(draw(floor(rng), random_boxes(rng, ("green", "yellow"))))
    assert len(HistogramBackProjection(models).detect(frame)) == 0


def test_the_disc_has_the_area_asked_for():
    kernel = disc(7.0)
    assert abs(np.count_nonzero(kernel) - np.pi * 49) < 8
    assert abs(kernel.sum() - 1) < 1e-12
