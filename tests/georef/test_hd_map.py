import json
from dataclasses import fields

import numpy as np
import pytest
from hd_map_cases import PANGYO, centrelines, full_map
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import InputError
from georef.geo_reference import GeoReference
from georef.hd_map import (
    HdMap,
    LaneCentreline,
    Line,
    Link,
    Node,
    PaintedArea,
    RoadClass,
    Signal,
)
from georef.hd_map_file import map_from_geojson, map_to_geojson, read_map, write_map

ROUND_TRIP_M = 1e-4


def assert_same(a: HdMap, b: HdMap) -> None:
    assert a.geo == b.geo
    for one, other in zip(a.features(), b.features(), strict=True):
        assert type(one) is type(other)
        for field in fields(one):
            x, y = getattr(one, field.name), getattr(other, field.name)
            if isinstance(x, np.ndarray):
                np.testing.assert_allclose(x, y, rtol=0, atol=ROUND_TRIP_M)
            else:
                assert x == y


@settings(max_examples=30, deadline=None)
@given(
    st.floats(-80, 80),
    st.floats(-179, 179),
    st.lists(st.tuples(st.floats(-2e3, 2e3), st.floats(-2e3, 2e3), st.floats(-50, 500)), min_size=1, max_size=8),
)
def test_a_map_comes_back_from_its_file_within_a_tenth_of_a_millimetre(latitude, longitude, points):
    geo = GeoReference(latitude, longitude)
    nodes = tuple(Node(str(k), point) for k, point in enumerate(points))
    assert_same(HdMap(geo, nodes=nodes), map_from_geojson(map_to_geojson(HdMap(geo, nodes=nodes))))


def test_every_table_comes_back(tmp_path):
    write_map(tmp_path / "map.geojson", full_map())
    assert_same(full_map(), read_map(tmp_path / "map.geojson"))
    tables = {row["properties"]["table"] for row in json.loads(map_to_geojson(full_map()))["features"]}
    assert tables == {field.name for field in fields(HdMap)} - {"geo"}


def test_coordinates_are_longitude_and_latitude_in_degrees():
    node = json.loads(map_to_geojson(HdMap(PANGYO, nodes=(Node("n", (0, 0, 7)),))))["features"][0]
    np.testing.assert_allclose(node["geometry"]["coordinates"], (127.112, 37.398, 7), rtol=0, atol=1e-12)


def test_heights_may_be_left_out_of_a_file():
    document = json.loads(map_to_geojson(full_map()))
    document["features"][0]["geometry"]["coordinates"] = [[127.112, 37.398], [127.113, 37.398]]
    assert (map_from_geojson(json.dumps(document)).lane_markings[0].points_m[:, 2] == 0).all()


@settings(max_examples=30, deadline=None)
@given(centrelines())
def test_a_line_is_as_long_as_its_sides(lane):
    assert abs(lane.length_m - np.hypot(*np.diff(lane.points_m[:, :2], axis=0).T).sum()) < 1e-12


def broken(change):
    document = json.loads(map_to_geojson(full_map()))
    change(document)
    return json.dumps(document)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda d: d.pop("origin"), "origin"),
        (lambda d: d["origin"].update(latitude_deg=95.0), "latitude"),
        (lambda d: d.update(type="Feature"), "FeatureCollection"),
        (lambda d: d.update(features={}), "list of features"),
        (lambda d: d["features"].insert(0, 3), "feature 0"),
        (lambda d: d["features"][0]["properties"].update(table="lines"), "lane_markings"),
        (lambda d: d["features"][0]["properties"].update(colours="red"), "unknown property 'colours'"),
        (lambda d: d["features"][0]["properties"].update(colour="red"), "red"),
        (lambda d: d["features"][0]["properties"].pop("kind"), "kind"),
        (lambda d: d["features"][0]["geometry"].update(type="Point"), "LineString"),
        (lambda d: d["features"][0].update(geometry=None), "LineString"),
        (lambda d: d["features"][0]["geometry"].update(coordinates=[["a", "b"]]), "no numbers"),
        (lambda d: d["features"][0]["geometry"].update(coordinates=[1, 2]), "longitudes"),
        (lambda d: d["features"][0]["geometry"].update(coordinates=[[127, 37], [9, 48]]), "km from the origin"),
        (lambda d: d["features"][0]["geometry"].update(coordinates=[[37, 127], [37, 127]]), "latitude"),
        (lambda d: d["features"][0].pop("id"), "id"),
        (lambda d: d["features"].append(d["features"][0]), "id 'm'"),
        (lambda d: d["features"][-1]["properties"].update(to_node="c"), "node 'c'"),
    ],
)
def test_a_broken_file_is_refused_with_the_fault_named(tmp_path, change, says):
    (tmp_path / "map.geojson").write_text(broken(change), encoding="utf-8")
    with pytest.raises(InputError, match=says) as caught:
        read_map(tmp_path / "map.geojson")
    assert "map.geojson" in str(caught.value)


@pytest.mark.parametrize("text", ["", "[1]", "{"])
def test_what_is_no_map_at_all_is_refused(text):
    with pytest.raises(InputError):
        map_from_geojson(text)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.geojson"):
        read_map(tmp_path / "none.geojson")


def test_polygons_have_one_closed_ring():
    for ring in ([], [[]], [[[127, 37], [127, 38], [128, 38]]]):
        text = broken(lambda d, ring=ring: d["features"][8]["geometry"].update(coordinates=ring))
        with pytest.raises(InputError, match="ring"):
            map_from_geojson(text)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Line("x", [(0, 0, 0)]),
        lambda: Line("x", [(1, 1, 0), (1, 1, 0)]),
        lambda: Line("x", [(0, 0), (1, 1)]),
        lambda: Line("x", [(0, 0, 0), (np.nan, 1, 0)]),
        lambda: PaintedArea("x", [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)], "crosswalk"),
        lambda: Node("x", (0, 0)),
        lambda: HdMap(PANGYO, nodes=(Node("x", (0, 0, 0)), Node("x", (1, 0, 0)))),
        lambda: HdMap(PANGYO, links=(Link("x", "a", "b"),)),
        lambda: HdMap(PANGYO, signals=(Signal("x", (0, 0, 0), ("lane",)),)),
    ],
)
def test_impossible_features_are_refused(make):
    with pytest.raises(InputError):
        make()


def test_arrays_of_a_map_cannot_be_edited():
    lane = LaneCentreline("x", [(0, 0, 0), (1, 0, 0)], RoadClass.CITY, 3.0)
    with pytest.raises(ValueError, match="read-only"):
        lane.points_m[0, 0] = 5
