import libsumo
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from road_cases import NAMES, network, path_of

from contracts import InputError
from georef.hd_map import AreaKind, HdMap, LaneUse, MarkingKind, StopKind
from georef.hd_map_file import map_from_geojson, map_to_geojson
from georef.lanes import LaneIndex
from sim.offset_lines import offset_line
from sim.road_map import map_of_network
from sim.road_network import read_network


def points_of(hd_map: HdMap) -> dict[str, np.ndarray]:
    names = ("points_m", "ring_m", "position_m")
    return {f.id: getattr(f, name) for f in hd_map.features() for name in names if hasattr(f, name)}


@pytest.mark.parametrize("name", NAMES)
def test_lanes_lie_where_sumo_says(name):
    index = LaneIndex.of(map_of_network(network(name)))
    geo = network(name).geo
    libsumo.start(["sumo", "-n", str(path_of(name)), "--no-step-log", "true", "--xml-validation.net", "never"])
    try:
        for lane in index.centrelines:
            edge, row = lane.id.rsplit("_", 1)
            x, y = libsumo.simulation.convert2D(edge, 0.4 * libsumo.lane.getLength(lane.id), int(row))
            place = index.places_on([index.centrelines.index(lane)], [(x, y)])
            assert place.distances_m[0] < 1e-3
            longitude, latitude = libsumo.simulation.convertGeo(x, y)
            np.testing.assert_allclose(geo.to_local([latitude, longitude]), (x, y), rtol=0, atol=1e-4)
    finally:
        libsumo.close()


@pytest.mark.parametrize("name", NAMES)
def test_the_map_of_a_network_comes_back_from_its_file(name):
    hd_map = map_of_network(network(name))
    back = points_of(map_from_geojson(map_to_geojson(hd_map)))
    for id_, points in points_of(hd_map).items():
        np.testing.assert_allclose(back[id_], points, rtol=0, atol=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_lane_lines_lie_half_a_lane_beside_the_middle(name):
    hd_map = map_of_network(network(name))
    lanes = {lane.id: lane for lane in hd_map.centrelines}
    for line in hd_map.lane_markings:
        if line.kind is MarkingKind.LANES:
            lane = lanes[line.id.removeprefix("lanes/")]
            middles = (line.points_m[1:, :2] + line.points_m[:-1, :2]) / 2
            places = LaneIndex([lane]).locate(middles)
            np.testing.assert_allclose(places.across_m, lane.width_m / 2, rtol=0, atol=0.02)


def test_the_crossroads_have_signals_crosswalks_and_bicycle_lanes():
    hd_map = map_of_network(network("crossroads"))
    assert len(hd_map.signals) == 4
    assert [line.kind for line in hd_map.stop_lines] == [StopKind.SIGNAL] * 4
    assert [area.kind for area in hd_map.painted_areas] == [AreaKind.CROSSWALK] * 4
    assert {lane.use for lane in hd_map.centrelines} == set(LaneUse)
    # 2 lanes of 3.25 m and a bicycle lane of 1.5 m reach from the road's middle to the kerb
    for line in hd_map.stop_lines:
        np.testing.assert_allclose(line.length_m, 8.0, rtol=0, atol=0.01)


def test_the_avenue_rises_by_two_per_cent():
    for lane in map_of_network(network("avenue_grade")).centrelines:
        if not lane.inner:
            rise = abs(lane.points_m[-1, 2] - lane.points_m[0, 2])
            np.testing.assert_allclose(rise / lane.length_m, 0.02, rtol=0, atol=0.001)


@settings(max_examples=10, deadline=None)
@given(st.floats(0.001, 0.5), st.integers(0, 2**31))
def test_the_survey_shifts_each_feature_as_a_whole(sigma_m, seed):
    true = points_of(map_of_network(network("merge")))
    hd_map = map_of_network(network("merge"), survey_sigma_m=sigma_m, seed=seed)
    shifts = [np.atleast_2d(points - true[id_]) for id_, points in points_of(hd_map).items()]
    for shift in shifts:
        np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), rtol=0, atol=1e-9)
        assert (shift[:, 2] == 0).all()
    assert 0.6 < np.std([shift[0, :2] for shift in shifts]) / sigma_m < 1.5
    again = points_of(map_of_network(network("merge"), survey_sigma_m=sigma_m, seed=seed))
    assert all((again[id_] == points).all() for id_, points in points_of(hd_map).items())


def test_an_offset_line_is_parallel():
    line = np.array([(0.0, 0, 1), (10, 0, 2), (10, 10, 3)])
    np.testing.assert_allclose(offset_line(line, 1.0), [(0, 1, 1), (9, 1, 2), (9, 10, 3)], rtol=0, atol=1e-12)


@pytest.mark.parametrize("sigma", [-1.0, np.nan])
def test_an_impossible_survey_is_refused(sigma):
    with pytest.raises(InputError, match="survey_sigma_m"):
        map_of_network(network("merge"), survey_sigma_m=sigma)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda text: "", "no XML"),
        (lambda text: "<nodes/>", "no SUMO network"),
        (lambda text: "<net/>", "location"),
        (lambda text: text.replace('netOffset="0.0000,0.0000"', 'netOffset="5.0,0.0"'), "netOffset"),
        (lambda text: text.replace("+proj=tmerc", "+proj=utm"), "projParameter"),
        (lambda text: text.replace(' dir="', ' direction="'), "dir"),
        (lambda text: text.replace("shape=", "form="), "shape"),
        (lambda text: text.replace("-180.0000,", "a,"), "float"),
    ],
)
def test_a_broken_network_is_refused(tmp_path, change, says):
    path = tmp_path / "broken.net.xml"
    path.write_text(change(path_of("merge").read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=says) as caught:
        read_network(path)
    assert "broken.net.xml" in str(caught.value)


def test_a_missing_network_is_refused(tmp_path):
    with pytest.raises(InputError, match="cannot read"):
        read_network(tmp_path / "none.net.xml")
