"""Small roads, cameras and users for the tests of the road's film."""

import numpy as np

from contracts import Camera, Intrinsics, Pose
from contracts.truth import Truth
from scenarios.network_file import load_network
from sim.air import Weather
from sim.light_program import LightProgram
from sim.lights import LightPreset
from sim.network_scene import scene_of_network
from sim.renderer import RendererName
from sim.rig import look_down
from sim.road_studio import RoadStudio
from sim.road_users import KINDS
from sim.user_sizes import Sizes

SEED = 4


def pole_camera(width=480, height=270, *, position_m=(-17.0, -17.0, 8.0), distortion=(0.0,) * 5, azimuth_deg=45.0):
    focal = 850.0 * width / 1280
    numbers = Intrinsics(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2, np.array(distortion))
    return Camera("pole", numbers, Pose(look_down(66.0, azimuth_deg), np.array(position_m)))


def users(*each: tuple[str, float, float, float]) -> Truth:
    """Road users as (kind, x, y, heading in degrees)."""
    kinds = tuple(kind for kind, *_ in each)
    ids = tuple(f"{kind}/{k}" for k, kind in enumerate(kinds))
    sizes = Sizes(SEED)
    return Truth(
        index=0,
        time_ns=0,
        ids=ids,
        labels=tuple(str(KINDS[kind].label) for kind in kinds),
        positions_m=np.array([(x, y, 0.0) for _, x, y, _ in each]).reshape(-1, 3),
        headings_rad=np.radians([heading for *_, heading in each]),
        sizes_m=np.array([sizes.of(kind, id_) for kind, id_ in zip(kinds, ids, strict=True)]).reshape(-1, 3),
        velocities_mps=np.zeros((len(each), 2)),
        kinds=kinds,
    )


def crossroads(camera: Camera, light=LightPreset.SUNNY, weather=Weather.DRY, name=RendererName.LAYERED) -> RoadStudio:
    scene = scene_of_network(load_network("crossroads"), [camera], SEED)
    return RoadStudio(scene, LightProgram(light), weather, SEED, name)


BUSY = users(
    ("saloon", -1.5, -8.0, 90.0),
    ("city_bus", 4.0, 6.0, 180.0),
    ("adult", 3.0, -6.0, 20.0),
    ("bicycle", -6.0, 2.0, 0.0),
    ("lorry", 9.0, -2.0, -60.0),
    ("delivery_van", 2.0, 22.0, 90.0),
)
