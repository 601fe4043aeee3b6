"""Paint found in drawn pictures whose every edge is known."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import Frame, InputError
from perception.road_paint import (
    brightness,
    corners_near,
    edges_across,
    still_picture,
    strokes_across,
)

ASPHALT, PAINT, FINE = 76.0, 224.0, 48
ONE = np.array([1.0])


def drawn(outline: np.ndarray) -> np.ndarray:
    """A picture of a polygon, (100, 120) levels: drawn 48 times as large, as OpenCV fills half a pixel too much."""
    big = np.full((100 * FINE, 120 * FINE), ASPHALT, np.uint8)
    corners = np.rint((outline + 0.5) * FINE * 16).astype(np.int32) - 8
    cv2.fillConvexPoly(big, corners, PAINT, cv2.LINE_8, 4)
    small = cv2.resize(big, (120, 100), interpolation=cv2.INTER_AREA).astype(np.float32)
    return cv2.GaussianBlur(small, (0, 0), 0.6)  # as a lens does


def stripe(middle: np.ndarray, angle: float, width: float, length: float = 300.0) -> np.ndarray:
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    return np.array(
        [middle + a * length / 2 * along + b * width / 2 * across for a, b in [(-1, -1), (1, -1), (1, 1), (-1, 1)]]
    )


@settings(max_examples=40)
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.0, np.pi), st.floats(2.0, 9.0), st.floats(-2.5, 2.5))
def test_the_middle_of_a_stroke_is_found_to_a_tenth_of_a_pixel(u, v, angle, width, beside):
    middle = np.array([60.0 + u, 50.0 + v])
    across = np.array([-np.sin(angle), np.cos(angle)])
    light = drawn(stripe(middle, angle, width))
    expected = middle + beside * across
    found = strokes_across(light, expected[None], across[None], width * ONE, 4.0 * ONE, uneven=1.0)
    assert found.seen[0]
    assert abs((found.pixels[0] - middle) @ across) < 0.1


@settings(max_examples=40)
@given(st.floats(-0.5, 0.5), st.floats(0.0, 2 * np.pi), st.floats(-2.5, 2.5))
def test_an_edge_is_found_to_a_tenth_of_a_pixel(shift, angle, beside):
    outwards = np.array([np.cos(angle), np.sin(angle)])
    edge = np.array([60.0, 50.0]) + shift * outwards
    light = drawn(stripe(edge - 40.0 * outwards, angle + np.pi / 2, 80.0))
    found = edges_across(light, (edge + beside * outwards)[None], outwards[None], 4.0 * ONE)
    assert found.seen[0]
    assert abs((found.pixels[0] - edge) @ outwards) < 0.1


@settings(max_examples=30)
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.2, 1.3), st.floats(-1.5, 1.5))
def test_a_corner_is_found_to_four_tenths_of_a_pixel(u, v, angle, beside):
    corner = np.array([60.0 + u, 50.0 + v])
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    light = drawn(np.array([corner, corner + 60 * along, corner + 60 * along + 60 * across, corner + 60 * across]))
    found = corners_near(light, (corner + np.array([beside, 0.3]))[None], 4.0 * ONE)
    assert found.seen[0]
    assert np.hypot(*(found.pixels[0] - corner)) < 0.4  # what a lens has rounded lies inside of the true corner


def test_what_is_not_as_expected_is_not_found():
    light = drawn(stripe(np.array([60.0, 50.0]), 0.0, 6.0))
    place, up = np.array([[60.0, 50.0]]), np.array([[0.0, 1.0]])
    assert not strokes_across(light, place, up, 30.0 * ONE, 4.0 * ONE, uneven=1.0).seen[0]  # too narrow
    assert not strokes_across(light, place + np.array([0, 12]), up, 6.0 * ONE, 4.0 * ONE, uneven=1.0).seen[
        0
    ]  # too far away
    assert not edges_across(np.full_like(light, ASPHALT), place, up, 4.0 * ONE).seen[0]
    assert not corners_near(light, place + np.array([0, 3]), 4.0 * ONE).seen[0]  # an edge is no corner
    two = np.maximum(light, drawn(stripe(np.array([60.0, 58.0]), 0.0, 6.0)))
    assert not strokes_across(two, place + np.array([0, 4]), up, 6.0 * ONE, 6.0 * ONE, uneven=1.0).seen[
        0
    ]  # which of them?


def test_a_stroke_whose_sides_differ_is_not_measured():
    stroke = drawn(stripe(np.array([60.0, 50.0]), 0.0, 4.0))
    kerb = np.maximum(stroke, drawn(stripe(np.array([60.0, 64.0]), 0.0, 20.0)))
    place, up = np.array([[60.0, 50.0]]), np.array([[0.0, 1.0]])
    assert strokes_across(stroke, place, up, 4.0 * ONE, 2.0 * ONE, uneven=0.12).seen[0]
    shaded = np.where(np.arange(kerb.shape[0])[:, None] < 50, np.minimum(kerb, ASPHALT / 2), kerb)
    assert not strokes_across(shaded.astype(np.float32), place, up, 4.0 * ONE, 2.0 * ONE, uneven=0.12).seen[0]


def test_what_moves_is_not_in_the_still_picture():
    images = [np.full((4, 6, 3), 50, np.uint8) for _ in range(3)]
    images[1][2, 2] = 255
    frames = [Frame("pole", k, k, image) for k, image in enumerate(images)]
    assert (still_picture(frames) == 50).all()
    assert (brightness(images[1]).max()) == 255.0
    with pytest.raises(InputError, match="no frame"):
        still_picture([])
