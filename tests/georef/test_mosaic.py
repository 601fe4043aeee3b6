"""The mosaic is where it says: points of the plane, drawn into the images, lie at their place in the picture."""

import cv2
import numpy as np
import pytest
from georef_cases import overhead
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import Camera, FloatArray, ImageArray, InputError
from georef.mosaic import MOST_PIXELS, PlaneGrid, border_px, feather, mosaic, seen_from

WEST = overhead("west", (-0.6, 0.02, 2.8), (0.02, -0.01, 0.03))
EAST = overhead("east", (0.5, -0.03, 2.75), (-0.015, 0.02, -0.04), distortion=(-0.09, 0.03, -0.0004, 0.0006, 0.0))
CAMERAS = (WEST, EAST)
SPOT_PX = 3.0
PX_PER_M = 300.0


def opencv_pixels(camera: Camera, points_m: FloatArray) -> FloatArray:
    """OpenCV's projection, apart from the code under test; (N, 2)."""
    rotation = camera.pose.world_from_camera.T
    vector, _ = cv2.Rodrigues(rotation)
    moved = -rotation @ camera.pose.position_m
    lens = camera.intrinsics
    pixels, _ = cv2.projectPoints(points_m.reshape(-1, 1, 3), vector, moved, lens.matrix, lens.distortion)
    return pixels.reshape(-1, 2)


def image_of(camera: Camera, points_m: FloatArray, level: int = 255) -> ImageArray:
    """Black, with a soft spot at the image of every point."""
    v, u = np.indices((camera.intrinsics.height_px, camera.intrinsics.width_px), np.float64)
    image = np.zeros(u.shape)
    for x, y in opencv_pixels(camera, points_m):
        image = np.maximum(image, level * np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * SPOT_PX**2)))
    return np.repeat(np.round(image).astype(np.uint8)[..., None], 3, axis=2)


def spot_in(image: ImageArray, near_px: FloatArray, reach: int = 9) -> FloatArray:
    """Centre of brightness round ``near_px``, (2,)."""
    column, row = np.round(near_px).astype(int)
    part = image[row - reach : row + reach + 1, column - reach : column + reach + 1, 0].astype(np.float64)
    v, u = np.indices(part.shape) - reach
    return np.array([column + (u * part).sum() / part.sum(), row + (v * part).sum() / part.sum()])


@given(
    st.floats(-1.2, -0.2), st.floats(-0.4, 0.4), st.sampled_from([0.0, 0.06]), st.sampled_from([150.0, 300.0, 612.5])
)
@settings(max_examples=8, deadline=None)
def test_a_point_of_the_plane_lies_at_its_place_in_the_picture(east_m, north_m, height_m, px_per_m):
    point_m = np.array([[east_m, north_m, height_m]])
    grid = PlaneGrid.around([WEST], px_per_m=px_per_m, height_m=height_m)
    picture = mosaic({"west": image_of(WEST, point_m)}, [WEST], grid)
    place = grid.pixels(point_m[0, :2])
    assert np.abs(spot_in(picture.image, place) - place).max() < 0.5


def test_marks_of_the_floor_coincide_where_two_cameras_see_them():
    marks_m = np.array([[x, y, 0.0] for x in (-0.2, -0.05, 0.1) for y in (-0.3, 0.0, 0.3)])
    grid = PlaneGrid.around(CAMERAS, px_per_m=PX_PER_M)
    images = {camera.name: image_of(camera, marks_m) for camera in CAMERAS}
    alone = {name: mosaic({name: image}, CAMERAS, grid) for name, image in images.items()}
    both = mosaic(images, CAMERAS, grid)
    for place in grid.pixels(marks_m[:, :2]):
        column, row = np.round(place).astype(int)
        assert both.seen[row, column] == 2
        west, east = (spot_in(picture.image, place) for picture in alone.values())
        assert np.abs(west - east).max() < 0.1
        assert np.abs(spot_in(both.image, place) - place).max() < 0.1


def test_a_point_on_another_height_is_displaced_as_its_ray_says():
    roof_m = np.array([[-1.1, 0.3, 0.06]])
    grid = PlaneGrid.around([WEST], px_per_m=PX_PER_M)
    centre = WEST.pose.position_m
    meets_m = centre + (roof_m[0] - centre) * centre[2] / (centre[2] - roof_m[0, 2])
    place = grid.pixels(meets_m[:2])
    picture = mosaic({"west": image_of(WEST, roof_m)}, [WEST], grid)
    assert np.abs(spot_in(picture.image, place) - place).max() < 0.5


def test_equal_views_blend_to_themselves_and_no_seam_shows():
    grid = PlaneGrid.around(CAMERAS, px_per_m=PX_PER_M)
    grey = {camera.name: np.full((720, 1280, 3), 117, np.uint8) for camera in CAMERAS}
    picture = mosaic(grey, CAMERAS, grid)
    assert (picture.image[picture.seen > 0] == 117).all()
    assert (picture.image[picture.seen == 0] == 0).all()
    assert set(np.unique(picture.seen)) == {0, 1, 2}
    unlike = {"west": grey["west"], "east": grey["east"] + np.uint8(40)}
    middle = mosaic(unlike, CAMERAS, grid).image[grid.height_px // 2, picture.seen[grid.height_px // 2] > 0, 0]
    assert (middle[0], middle[-1]) == (117, 157)
    assert np.abs(np.diff(middle.astype(int))).max() <= 2  # of 40


def test_the_grid_holds_exactly_what_the_cameras_see():
    grid = PlaneGrid.around(CAMERAS, px_per_m=PX_PER_M)
    _, inside = seen_from(WEST, grid)
    _, also = seen_from(EAST, grid)
    seen = inside | also
    assert seen[:2].any()
    assert seen[-2:].any()
    assert seen[:, :2].any()
    assert seen[:, -2:].any()


@given(st.floats(-9, 9), st.floats(-9, 9))
def test_places_and_pixels_are_each_others_inverse(east_m, north_m):
    grid = PlaneGrid(-2.0, 1.5, 250.0, 800, 600)
    there = grid.points_m(grid.pixels(np.array([east_m, north_m])))
    assert np.abs(there - (east_m, north_m)).max() < 1e-9
    assert grid.pixels(np.array([-2.0, 1.5])).tolist() == [0.0, 0.0]
    assert grid.pixels(np.array([-1.0, 1.5])).tolist() == [250.0, 0.0]
    assert grid.pixels(np.array([-2.0, 0.5])).tolist() == [0.0, 250.0]


def test_a_view_weighs_least_at_its_border():
    border, middle = feather(WEST, border_px(WEST)), feather(WEST, np.array([[640.0, 360.0]]))
    assert border.max() < 0.01
    assert border.min() > 0
    assert middle.tolist() == [1.0]


def test_wrong_input_is_refused_by_name():
    image = np.zeros((720, 1280, 3), np.uint8)
    grid = PlaneGrid(-1.0, 1.0, 10.0, 20, 20)
    with pytest.raises(InputError, match='no camera "north" among west, east'):
        mosaic({"north": image}, CAMERAS, grid)
    with pytest.raises(InputError, match="takes 1280 x 720 px"):
        mosaic({"west": image[:100]}, CAMERAS, grid)
    with pytest.raises(InputError, match="at least one camera"):
        PlaneGrid.around([], px_per_m=100.0)
    with pytest.raises(InputError, match="horizon"):
        PlaneGrid.around([overhead(tilt_rad=(1.5, 0.0, 0.0))], px_per_m=100.0)
    with pytest.raises(InputError, match="scale positive"):
        PlaneGrid(0.0, 0.0, 0.0, 10, 10)
    with pytest.raises(InputError, match="empty or too large"):
        PlaneGrid(0.0, 0.0, 1.0, MOST_PIXELS + 1, 1)
