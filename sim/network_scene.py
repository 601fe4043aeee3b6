"""The scene of a road network, as it truly is: its map without a surveyor's errors, painted and built up."""

from collections.abc import Sequence

from contracts import Camera
from sim.road_map import map_of_network
from sim.road_network import RoadNetwork
from sim.road_scene import RoadScene
from sim.road_surface import pavement_area, road_area, surface_parts
from sim.roadside import luminaires, roadside_parts, signal_heads
from sim.terrain import Terrain


def scene_of_network(network: RoadNetwork, cameras: Sequence[Camera], seed: int) -> RoadScene:
    """Everything that stands still; the roadside is drawn from ``seed`` and leaves cameras their sight."""
    road_map = map_of_network(network)
    terrain = Terrain([lane.shape_m for lane in network.lanes.values()])
    carriageway, pavement = road_area(network), pavement_area(network)
    parts = (
        *surface_parts(carriageway, pavement, road_map, terrain),
        *roadside_parts(carriageway, pavement, road_map, terrain, cameras=cameras, seed=seed),
    )
    heads = tuple(signal_heads(carriageway, road_map, network))
    return RoadScene(parts, luminaires(carriageway, road_map), seed, heads)
