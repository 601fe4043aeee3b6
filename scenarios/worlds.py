"""From a scenario to the world that it describes."""

from contracts.truth import World
from georef.hd_map import HdMap
from scenarios.check import plant_of
from scenarios.network_file import load_network, routes_of
from scenarios.rig_file import load_rig
from scenarios.schema import RailScenario, RoadScenario, Scenario
from sim.filmed_world import Filming
from sim.light_program import LightProgram
from sim.rail_motion import RailMotion
from sim.rail_world import RailWorld
from sim.renderer import RendererName
from sim.road_map import map_of_network
from sim.road_world import RoadWorld
from sim.traffic import TrafficMotion


def build_world(
    scenario: Scenario,
    *,
    seed: int | None = None,
    noise_seed: int | None = None,
    film: bool = True,
    workers: int = 1,
    renderer: str = RendererName.LAYERED,
) -> World:
    """The world of ``scenario``, ready to run.

    seed: instead of the scenario's own. noise_seed: of the sensors alone; nothing else changes with it.
    film: False gives the truth without frames, and needs no graphics.
    workers: processes that share the cameras; the frames are the same for any number.
    renderer: ``layered``, or ``full``, its slow oracle.
    """
    assert isinstance(scenario, RailScenario | RoadScenario)
    seed = scenario.seed if seed is None else seed
    filming = Filming(
        load_rig(scenario.rig), seed, noise_seed, film=film, workers=workers, renderer=renderer, sensor=scenario.sensor
    )
    light = LightProgram(scenario.light, scenario.light_change)
    if isinstance(scenario, RoadScenario):
        network = load_network(scenario.network)
        traffic = TrafficMotion(network, routes_of(network), scenario.traffic, seed)
        return RoadWorld(network, traffic, scenario.frame_times_ns, filming, light=light, weather=scenario.weather)
    plant = plant_of(scenario.plant)
    motion = RailMotion(plant, scenario.motion, seed)
    return RailWorld(plant, motion, scenario.frame_times_ns, filming, light=light, surroundings=scenario.surroundings)


def maps_of(scenario: RoadScenario) -> tuple[HdMap, HdMap]:
    """The map of the scenario's road as it is, and as its surveyor drew it, which is what owners of cameras have."""
    network = load_network(scenario.network)
    drawn = map_of_network(network, survey_sigma_m=scenario.map_sigma_m, seed=scenario.seed)
    return map_of_network(network), drawn


def geo_of(scenario: Scenario) -> str | None:
    """PROJ string of the world's metres where it lies somewhere on the globe; None for a plant in a room."""
    return str(load_network(scenario.network).geo.crs.srs) if isinstance(scenario, RoadScenario) else None
