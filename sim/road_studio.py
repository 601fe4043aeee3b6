"""Where a road is filmed: see ``sim.studio``."""

from collections.abc import Sequence
from dataclasses import dataclass

from contracts import Camera
from contracts.truth import CameraTruth, Truth
from sim.air import Weather
from sim.body_shapes import Wardrobe
from sim.light_program import LightProgram
from sim.renderer import Rendered, Renderer, RendererName
from sim.road_scene import RoadScene
from sim.road_truth import road_camera_truth


@dataclass(frozen=True, eq=False)
class RoadStudio:
    """A road under a light and a weather. seed: of the users' looks and the mottle of the road."""

    scene: RoadScene
    light: LightProgram
    weather: Weather
    seed: int
    name: RendererName

    def renderer(self, pinholes: Sequence[Camera]) -> Renderer:
        """See ``Studio.renderer``."""
        from sim.road_renderer import RoadRenderer

        return RoadRenderer(self, pinholes)

    def view(self, camera: Camera, state: Truth, seen: Rendered) -> CameraTruth:
        """See ``Studio.view``."""
        return road_camera_truth(camera, state, seen, Wardrobe(self.seed))
