import cv2
import numpy as np
import pytest
from conftest import LABELS
from drawn_frames import Box, draw, floor, frame_of, random_boxes
from hypothesis import example, given, settings
from hypothesis import strategies as st

from contracts import Detections, Detector, ImageArray
from perception.hbp import HistogramBackProjection
from perception.hue_saturation import back_projection, histogram, hue_saturation_value, ratio_histogram

SAME_PX = 0.06  # how far equal scenes may differ once they fall on other pixels


@st.composite
def boxes(draw_value: st.DrawFn) -> Box:
    """A blue vehicle anywhere in the frame, leaning towards a point not far from the frame's middle."""
    centre = np.array([draw_value(st.floats(110, 530)), draw_value(st.floats(110, 250))])
    nadir = np.array([320 + draw_value(st.integers(-20, 20)), 180 + draw_value(st.integers(-20, 20))])
    lean = (nadir - centre) * draw_value(st.sampled_from([0.0, 0.02, 0.05]))
    return Box(
        "blue",
        (float(centre[0]), float(centre[1])),
        heading_rad=draw_value(st.floats(-3.2, 3.2)),
        lean_px=(float(lean[0]), float(lean[1])),
        shadow_px=draw_value(st.sampled_from([(0.0, 0.0), (14.0, -8.0), (-5.0, -12.0)])),
        wall_gains=draw_value(st.sampled_from([(0.4, 0.4), (0.25, 0.65), (0.6, 0.3)])),
    )


def detect(models, image: ImageArray) -> Detections:
    return HistogramBackProjection(models).detect(frame_of(image))


def test_the_coarse_chain_is_opencvs_back_projection_of_the_ratio(models, rng):
    hsv = hue_saturation_value(draw(floor(rng), random_boxes(rng, LABELS)))
    model, image = models.models[0].histogram, cv2.calcHist([hsv], [0, 1], None, [90, 32], [0, 180, 0, 256])
    ratio = np.minimum(model / np.maximum(image, 1), 1)
    expected = cv2.calcBackProject([hsv], [0, 1], (ratio * 255).astype(np.float32), [0, 180, 0, 256], 1)
    assert (back_projection(hsv, ratio_histogram(model, histogram(hsv))) == expected).all()


def test_each_vehicle_is_found_once_within_a_third_of_a_pixel(models, rng):
    detector = HistogramBackProjection(models)
    assert isinstance(detector, Detector)
    errors = []
    for _ in range(12):
        drawn = random_boxes(rng, LABELS)
        found = detector.detect(frame_of(draw(floor(rng), drawn, gain=rng.uniform(0.4, 1.2))))
        assert found.labels == LABELS
        errors.append(found.anchors_px - [box.centre_px for box in drawn])
    assert np.sqrt(np.mean(np.square(errors))) < 0.1
    assert np.abs(errors).max() < 0.33


HARD_WALL = Box("blue", (110.0, 121.75), lean_px=(4.2, 1.165), wall_gains=(0.25, 0.65))  # plain Gauss-Newton oscillates


@given(boxes())
@example(HARD_WALL)
@settings(max_examples=25, deadline=None)
def test_neither_wall_nor_shadow_nor_heading_pulls_the_anchor(models, box):
    found = detect(models, draw(floor(np.random.default_rng(0)), [box]))
    assert np.abs(found.anchors_px[0] - box.centre_px).max() < 0.33
    assert np.abs(np.sort(found.quads_px[0], axis=0) - np.sort(box.roof_quad_px, axis=0)).max() < 1.5


@given(boxes(), st.integers(-60, 60), st.integers(-40, 40))
@settings(max_examples=15, deadline=None)
def test_shifting_the_frame_by_whole_pixels_shifts_the_anchor_by_as_much(models, box, du, dv):
    image = draw(floor(np.random.default_rng(0)), [box])
    there = detect(models, np.roll(image, (dv, du), axis=(0, 1))).anchors_px[0]
    here = detect(models, image).anchors_px[0]
    assert np.abs(there - here - (du, dv)).max() < SAME_PX


@given(boxes())
@settings(max_examples=15, deadline=None)
def test_turning_the_frame_by_half_a_turn_turns_the_anchor(models, box):
    image = draw(floor(np.random.default_rng(0)), [box])
    turned = detect(models, np.ascontiguousarray(image[::-1, ::-1])).anchors_px[0]
    here = detect(models, image).anchors_px[0]
    assert np.abs(turned + here - (image.shape[1] - 1, image.shape[0] - 1)).max() < SAME_PX


NARROW_WALL = Box(
    "blue",
    (295.0, 198.0),
    heading_rad=1.0,
    lean_px=(1.25, -0.9),
    shadow_px=(14.0, -8.0),
    wall_gains=(0.4, 0.4),
)


@given(boxes(), st.floats(0.4, 1.2))
@example(NARROW_WALL, 0.5)
@settings(max_examples=15, deadline=None)
def test_brightness_does_not_move_the_anchor(models, box, gain):
    background = floor(np.random.default_rng(0))
    brighter = detect(models, draw(background, [box], gain=gain)).anchors_px[0]
    assert np.abs(brighter - detect(models, draw(background, [box])).anchors_px[0]).max() < 0.1


def test_a_frame_without_vehicles_gives_nothing(models, rng):
    assert len(detect(models, floor(rng))) == 0
    assert len(detect(models, np.zeros((90, 160, 3), np.uint8))) == 0
    assert len(detect(models, np.full((3, 2, 3), 255, np.uint8))) == 0


def test_things_of_another_hue_or_size_give_nothing(models, rng):
    strangers = random_boxes(rng, ("green", "yellow"))
    dots = [Box("blue", (100.0, 60.0), size_px=(12.0, 12.0)), Box("red", (400.0, 60.0), size_px=(260.0, 90.0))]
    assert len(detect(models, draw(floor(rng), strangers))) == 0
    assert len(detect(models, draw(floor(rng), dots))) == 0


def test_the_vehicle_is_told_from_a_smaller_thing_of_its_colour(models, rng):
    box = Box("blue", (400.0, 200.0), heading_rad=0.4)
    dot = Box("blue", (100.0, 60.0), size_px=(24.0, 24.0))
    found = detect(models, draw(floor(rng), [dot, box]))
    assert np.abs(found.anchors_px[0] - box.centre_px).max() < 0.33


def test_a_wall_as_bright_as_the_roof_is_recognised_by_the_roofs_size(models, rng):
    box = Box("blue", (520.0, 180.0), lean_px=(-9.0, 0.0), wall_gains=(1.0, 1.0))
    found = detect(models, draw(floor(rng), [box]))
    assert np.abs(found.anchors_px[0] - box.centre_px).max() < 1


@pytest.mark.parametrize("heading_rad", [0.0, 0.5, 1.2, 2.2])
def test_a_vehicle_that_leaves_the_image_is_completed_and_says_that_it_is_unsure(models, rng, heading_rad):
    box = Box("red", (22.0, 170.0), heading_rad=heading_rad, lean_px=(8.0, 0.0))
    found = detect(models, draw(floor(rng), [box]))
    error = found.anchors_px[0] - box.centre_px
    assert found.scores[0] < 1
    assert error @ np.linalg.inv(found.anchor_covs_px2[0]) @ error < 16


@pytest.mark.parametrize("cover_px", [10, 18])
def test_a_covered_end_shows_in_score_and_covariance(models, rng, cover_px):
    box = Box("red", (300.0, 170.0))
    image = draw(floor(rng), [box])
    image[:, 335 - cover_px : 360] = (60, 60, 60)
    found = detect(models, image)
    error = found.anchors_px[0] - box.centre_px
    assert found.scores[0] < 0.9
    assert error @ np.linalg.inv(found.anchor_covs_px2[0]) @ error < 4


def test_a_thing_before_a_part_of_one_side_does_not_pull_the_anchor(models, rng):
    box = Box("blue", (300.0, 170.0), heading_rad=0.2)
    image = draw(floor(rng), [box])
    image[140:158, 290:310] = (60, 60, 60)
    found = detect(models, image)
    assert np.abs(found.anchors_px[0] - box.centre_px).max() < 0.33


def test_a_strip_of_shadow_beside_the_roof_is_not_the_roof(models, rng):
    box = Box("blue", (300.0, 170.0), heading_rad=0.2, shadow_px=(1.5, -1.5))
    found = detect(models, draw(floor(rng), [box]))
    assert np.abs(found.anchors_px[0] - box.centre_px).max() < 0.33


def test_detection_repeats_and_leaves_the_frame_alone(models, rng):
    image = draw(floor(rng), random_boxes(rng, LABELS))
    frame, copy = frame_of(image), image.copy()
    detector = HistogramBackProjection(models)
    once = detector.detect(frame)
    detector.reset()
    again = detector.detect(frame)
    assert (image == copy).all()
    assert once.labels == again.labels
    for field in ("scores", "boxes_px", "quads_px", "anchors_px", "anchor_heights_m", "anchor_covs_px2"):
        assert (getattr(once, field) == getattr(again, field)).all()
