import json

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from map_cases import SIZE, STRONG_LENS, image, pole, poles

from contracts import InputError
from georef.blind_spots import blind_spots, image_from_image, layer, pixels_in_other, view
from georef.geo_reference import GeoReference
from georef.homography import transform
from georef.projection import rays

CORNERS = np.array([(u, v) for u in (-0.5, SIZE[0] - 0.5) for v in (-0.5, SIZE[1] - 0.5)])


@settings(max_examples=15)
@given(poles(), st.integers(0, 1000))
def test_a_place_lies_in_the_view_when_opencv_images_it_inside_the_picture(camera, seed):
    assume(rays(camera, CORNERS)[1].all())  # where the lens images nothing, a border of the picture says nothing
    seen = view(camera, 50.0)
    rng = np.random.default_rng(seed)
    angle, distance = rng.uniform(-np.pi, np.pi, 300), rng.uniform(1.0, 60.0, 300)
    places = camera.pose.position_m[:2] + distance[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    in_space = np.column_stack([places, np.zeros(300)])
    in_camera = (in_space - camera.pose.position_m) @ camera.pose.world_from_camera
    pixels = image(camera, in_space)
    ahead = (in_camera[:, 2] > 0) & (np.hypot(*in_camera[:, :2].T) < 1.0 * in_camera[:, 2])
    inside = ahead & (pixels > -0.5).all(axis=1) & (pixels < np.array(SIZE) - 0.5).all(axis=1) & (distance < 50.0)
    points = shapely.points(places)
    clear = shapely.distance(seen.boundary, points) > 0.05  # the outline is a polygon
    assert (shapely.contains(seen, points) == inside)[clear].all()


def test_blind_spots_and_views_share_the_area():
    cameras = [pole(heading_deg=0.0), pole(heading_deg=120.0, distortion=STRONG_LENS)]
    area = shapely.box(-40, -40, 60, 60)
    blind = blind_spots(cameras, area, 60.0)
    seen = shapely.union_all([view(camera, 60.0) for camera in cameras]).intersection(area)
    assert abs(blind.area + seen.area - area.area) < 1e-6
    assert blind.contains(shapely.Point(0.0, 0.0))  # under the poles
    assert not blind.contains(shapely.Point(25.0, 0.0))
    written = json.loads(json.dumps(layer({"blind": blind}, GeoReference(37.398, 127.112))))
    longitude, latitude = shapely.geometry.shape(written["features"][0]["geometry"]).bounds[:2]
    assert abs(longitude - 127.112) < 0.001
    assert abs(latitude - 37.398) < 0.001


def test_a_camera_that_looks_up_sees_no_ground():
    assert view(pole(down_deg=-40.0), 60.0).is_empty


def test_pixels_pass_from_camera_to_camera_over_the_ground():
    first, second = pole(heading_deg=0.0), pole(heading_deg=25.0, foot_m=(5.0, -20.0))
    places = np.array([[25.0, 1.0, 0.0], [35.0, -3.0, 0.0], [40.0, 4.0, 0.0]])
    assert np.abs(transform(image_from_image(first, second), image(first, places)) - image(second, places)).max() < 1e-6
    bent = pole(heading_deg=0.0, distortion=STRONG_LENS)
    passed, valid = pixels_in_other(bent, second, image(bent, places))
    assert valid.all()
    assert np.abs(passed - image(second, places)).max() < 1e-6
    assert not pixels_in_other(bent, second, np.array([[960.0, 0.0]]))[1].any()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: view(pole(), 0.0), "must be positive"),
        (lambda: view(pole(), np.inf), "must be positive and finite"),
        (lambda: blind_spots([pole()], shapely.Polygon(), 60.0), "no valid polygon"),
    ],
)
def test_wrong_areas_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
