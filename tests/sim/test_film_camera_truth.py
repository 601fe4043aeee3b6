"""What a camera's truth says: boxes, visible shares, centres."""

import numpy as np
import pytest
from film_cases import camera, empty_scene, state
from hypothesis import given
from hypothesis import strategies as st

from sim.camera_truth import camera_truth, outline_points, silhouette_pixels
from sim.full_renderer import FullRenderer
from sim.lights import LightPreset
from sim.projection import project, trusted_radius
from sim.renderer import Rendered

UNSEEN = Rendered(np.zeros((480, 640, 3), np.uint8), np.zeros((480, 640), np.uint8))


@given(st.floats(-0.4, 0.4), st.floats(-0.3, 0.3), st.floats(-180.0, 180.0))
def test_the_full_box_holds_every_point_of_the_object_and_touches_it(x, y, heading_deg):
    view = camera(distortion=(-0.1, 0.04, 0.001, 0.0, 0.0))
    here = state(("red", x, y, heading_deg))
    box = camera_truth(view, here, UNSEEN).full_boxes_px[0]
    pixels, _ = project(view, outline_points(here)[0])
    assert (pixels >= box[:2] - 1e-9).all()
    assert (pixels <= box[2:] + 1e-9).all()
    assert np.abs(pixels.min(axis=0) - box[:2]).max() < 1e-9


SIXTEENTHS = st.integers(-7, 7).map(lambda k: k / 16)  # exact in single precision


@given(st.integers(5, 60), st.integers(5, 60), SIXTEENTHS, SIXTEENTHS)
def test_the_silhouette_of_a_rectangle_counts_its_pixel_centres(width, height, u, v):
    corners = np.array([[u, v], [u + width, v], [u + width, v + height], [u, v + height]])
    columns = np.floor(u + width) - np.ceil(u) + 1
    rows = np.floor(v + height) - np.ceil(v) + 1
    assert silhouette_pixels(corners) == columns * rows


def test_an_object_behind_the_camera_has_no_boxes_and_is_not_visible():
    truth = camera_truth(camera(position_m=(0.0, 0.0, 0.03)), state(("red", 0.0, 0.0, 0.0)), UNSEEN)
    assert np.isnan(truth.full_boxes_px).all()
    assert np.isnan(truth.roofs_px).all()
    assert truth.visible_fractions[0] == 0.0


def test_far_outside_of_the_field_a_folding_lens_gives_no_point():
    view = camera(distortion=(-0.3, 0.0, 0.0, 0.0, 0.0))
    assert trusted_radius(view.intrinsics) <= 1.0 / np.sqrt(0.9)
    pixels, valid = project(view, np.array([[0.0, 0.0, 0.0], [30.0, 0.0, 0.0]]))
    assert valid.tolist() == [True, False]
    assert np.isnan(pixels[1]).all()


@pytest.mark.film
def test_visible_shares_tell_open_hidden_and_cut_objects_apart():
    view = camera(tilt_deg=0.0, azimuth_deg=90.0)
    renderer = FullRenderer(empty_scene(), [view], LightPreset.CLOUDY)
    edge_m = 319.5 / 640 * 1.4 + 0.03  # where the ground leaves the image on the right
    here = state(("red", 0.0, 0.0, 0.0), ("blue", 0.0, 0.03, 0.0), ("green", edge_m, 0.3, 0.0), ("cyan", 3.0, 0.0, 0.0))
    seen = renderer.render(here, "eye")
    renderer.close()
    truth = camera_truth(view, here, seen)
    red, blue, green, cyan = truth.visible_fractions
    assert red + blue > 0.95  # two boxes that overlap share what is to be seen
    assert 0.3 < min(red, blue) < 0.8
    assert 0.3 < green < 0.6  # cut by the edge of the image
    assert cyan == 0.0
    assert np.isnan(truth.visible_boxes_px[3]).all()
    assert truth.visible_boxes_px[2][2] == 639.5
    assert truth.full_boxes_px[2][2] > 639.5
    assert truth.instances is not None
