"""What a road looks like when it is filmed."""

from dataclasses import dataclass

from sim.air import Weather
from sim.light_program import LightProgram
from sim.renderer import RendererName
from sim.road_scene import RoadScene


@dataclass(frozen=True, eq=False)
class RoadSetting:
    """A road under a light and a weather.

    seed: of the users' looks and the mottle of the road. name: of the renderer that draws it.
    """

    scene: RoadScene
    light: LightProgram
    weather: Weather
    seed: int
    name: RendererName
