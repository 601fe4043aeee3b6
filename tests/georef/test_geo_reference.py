import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod

from contracts import InputError
from georef.geo_reference import GeoReference

PANGYO = GeoReference(37.398, 127.112)
origins = st.builds(GeoReference, st.floats(-80.0, 80.0), st.floats(-179.0, 179.0))
offsets = st.tuples(st.floats(-2000.0, 2000.0), st.floats(-2000.0, 2000.0))


@given(origins, offsets)
def test_there_and_back_is_the_same_place(reference, position):
    again = reference.to_local(reference.to_wgs84(position))
    assert np.abs(again - position).max() < 1e-4


@given(origins, offsets)
def test_local_distance_and_bearing_are_the_geodesic_s(reference, position):
    latitude, longitude = reference.to_wgs84(position)
    azimuth_deg, _, distance_m = Geod(ellps="WGS84").inv(
        reference.longitude_deg, reference.latitude_deg, longitude, latitude
    )
    geodesic = distance_m * np.array([np.sin(np.deg2rad(azimuth_deg)), np.cos(np.deg2rad(azimuth_deg))])
    assert np.abs(geodesic - position).max() < 1e-4


def test_the_origin_is_the_origin():
    assert np.abs(PANGYO.to_local([37.398, 127.112])).max() < 1e-6
    assert np.abs(PANGYO.to_wgs84([0.0, 0.0]) - [37.398, 127.112]).max() < 1e-12


def test_the_first_printed_row_of_the_traffic_paper_s_table_is_eight_centimetres_long():
    found, reference = PANGYO.to_local(
        [[37.39810236995146, 127.11284371695545], [37.39810236995146, 127.11284458460997]]
    )
    assert abs(np.hypot(*(found - reference)) - 0.077) < 0.001


def test_places_keep_their_shape_and_unknown_stays_unknown():
    positions = np.zeros((3, 4, 2))
    positions[1, 2, 0] = np.nan
    places = PANGYO.to_wgs84(positions)
    assert places.shape == (3, 4, 2)
    assert np.isnan(places[1, 2]).all()
    assert np.isnan(places).sum() == 2
    assert np.isnan(PANGYO.to_local(places)).sum() == 2
    assert PANGYO.to_local(np.empty((0, 2))).shape == (0, 2)


@pytest.mark.parametrize("origin", [(91.0, 0.0), (0.0, 181.0), (float("nan"), 0.0)])
def test_an_origin_that_is_no_place_is_refused(origin):
    with pytest.raises(InputError, match="is no latitude"):
        GeoReference(*origin)


@pytest.mark.parametrize(
    ("convert", "values", "message"),
    [
        (PANGYO.to_local, [127.112, 37.398], "outside -90 .. 90"),
        (PANGYO.to_local, [47.0, 127.1], "choose an origin nearby"),
        (PANGYO.to_wgs84, [1e6, 0.0], "1000 km from the origin"),
        (PANGYO.to_wgs84, [1.0, 0.0, 2.0], r"expected \(..., 2\)"),
        (PANGYO.to_local, 3.0, r"expected \(..., 2\)"),
    ],
)
def test_wrong_places_are_refused(convert, values, message):
    with pytest.raises(InputError, match=message):
        convert(values)
