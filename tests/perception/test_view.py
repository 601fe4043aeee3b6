import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import Camera, Intrinsics, Pose
from georef.location import on_plane
from georef.projection import project
from perception.view import RoofView, straight_down

ROOF_M = 0.06
LENS = np.array([-0.045, 0.008, 0.0002, -0.0003, 0.0])
TILTED = np.diag([1.0, -1.0, -1.0]) @ np.array(
    [[1, 0, 0], [0, np.cos(0.05), -np.sin(0.05)], [0, np.sin(0.05), np.cos(0.05)]]
)
WIDE = Camera(
    "wide", Intrinsics(1920, 1200, 1037.0, 1040.0, 950.0, 610.0, LENS), Pose(TILTED, np.array([3.0, 1.0, 2.8]))
)
places = st.tuples(st.floats(0, 1919), st.floats(0, 1199)).map(np.array)


def test_a_camera_that_looks_straight_down_sees_one_scale_and_walls_that_lean_to_the_middle():
    view = RoofView.of(straight_down(1600.0, 2.8, (1280, 720)), ROOF_M).at(np.array([100.0, 650.0]))
    assert view.px_per_m == pytest.approx(1600 / 2.74, rel=1e-9)
    assert view.px_per_m_along(np.array([(0.6, 0.8)]))[0] == pytest.approx(1600 / 2.74, rel=1e-9)
    assert view.lean_px == pytest.approx((np.array([639.5, 359.5]) - (100, 650)) * 0.06 / 2.8, abs=1e-6)


@given(places, st.floats(-3.2, 3.2))
@settings(max_examples=40, deadline=None)
def test_a_length_on_the_roof_is_as_long_in_the_image_as_the_camera_projects_it(place_px, heading_rad):
    view = RoofView.of(WIDE, ROOF_M).at(place_px)
    middle_m, _ = on_plane(WIDE, place_px, ROOF_M)
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad), 0.0]) * 0.03
    (back_px, front_px), _ = project(WIDE, np.array([middle_m - ahead, middle_m + ahead]))
    length_px = float(np.linalg.norm(front_px - back_px))
    direction = (front_px - back_px) / length_px
    assert abs(view.px_per_m_along(direction[None])[0] * 0.06 - length_px) < 0.03  # px, of about 22


@given(places)
@settings(max_examples=40, deadline=None)
def test_the_lean_leads_from_the_roof_to_the_ground_below_it(place_px):
    point_m, _ = on_plane(WIDE, place_px, ROOF_M)
    foot_px, _ = project(WIDE, point_m * (1, 1, 0))
    assert np.abs(RoofView.of(WIDE, ROOF_M).at(place_px).lean_px - (foot_px - place_px)).max() < 0.1


def test_outside_the_image_it_looks_as_at_its_border():
    view = RoofView.of(WIDE, ROOF_M)
    assert (view.at(np.array([-50.0, 300.0])).px_from_m == view.at(np.array([0.0, 300.0])).px_from_m).all()
    assert np.isfinite(view.at(np.array([1e5, 1e5])).lean_px).all()
