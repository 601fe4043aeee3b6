"""Every road of the library can be calibrated from picks by hand, and the cameras are where they should be."""

import numpy as np
import pytest
import shapely

from bench.road_calibration import PICKS, calibrated_from_map, picks_of, thinned
from georef.calibrated import PARAMETERS, CalibratedCamera
from georef.locate import locate_pixels
from scenarios.loader import list_scenarios, load_scenario
from scenarios.schema import RoadScenario
from scenarios.worlds import build_world, maps_of
from sim.hand_picks import hand_picks
from sim.projection import project
from sim.road_surface import crosswalk_bars

ROADS = [name for name in list_scenarios() if isinstance(load_scenario(name), RoadScenario)]


def exactly(camera):
    return CalibratedCamera(camera, np.zeros((len(PARAMETERS), len(PARAMETERS))))


@pytest.mark.parametrize("name", ROADS)
def test_cameras_come_back_from_picks(name):
    scenario = load_scenario(name)
    world = build_world(scenario, film=False)
    for found, true in zip(calibrated_from_map(scenario, world, (), PICKS), world.cameras, strict=True):
        ahead = true.pose.world_from_camera[:, 2]
        place = true.pose.position_m + 25.0 * ahead / np.hypot(ahead[0], ahead[1])
        pixels, _ = project(true, place[None])
        located = locate_pixels(found, pixels, heights_m=place[2])
        assert np.linalg.norm(located.positions_m[0] - place[:2]) < 0.5


def test_a_hand_picks_points_apart_and_pixels_on_lines_where_there_are_no_points():
    scenario = load_scenario("crossroads-day")
    world = build_world(scenario, film=False)
    points, lines = picks_of(scenario, world.cameras[0])
    assert len(points) == 25
    assert {name.split("/")[0] for name in lines.names} >= {"edge", "stop", "crosswalk"}
    assert lines.pixels[:, 1].max() > 480.0  # the lower third, where this camera sees no point


def test_a_crosswalk_s_side_is_picked_where_a_bar_ends():
    scenario = load_scenario("crossroads-day")
    world = build_world(scenario, film=False)
    true_map, owners_map = maps_of(scenario)
    rng = np.random.default_rng(0)
    _, lines = hand_picks(world.cameras[0], true_map, owners_map, rng, noise_px=0.0)
    bars = [bar for area in true_map.painted_areas for bar in crosswalk_bars(area)]
    on_sides = lines.pixels[[name.startswith("crosswalk") for name in lines.names]]
    located = locate_pixels(exactly(world.cameras[0]), on_sides)
    assert len(on_sides) >= 10
    for place in located.positions_m:
        assert min(bar.distance(shapely.Point(place)) for bar in bars) < 1e-6


def test_a_thinned_scenario_is_the_same_world():
    scenario = load_scenario("crossroads-day")
    thin = thinned(scenario)
    assert len(thin.frame_times_ns) == 5
    assert thin.seed == scenario.seed
    pairs = zip(build_world(thin, film=False).cameras, build_world(scenario, film=False).cameras, strict=True)
    assert all(np.array_equal(a.pose.position_m, b.pose.position_m) for a, b in pairs)
