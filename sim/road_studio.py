"""Where a road is filmed: see ``sim.studio``."""

from collections.abc import Sequence
from dataclasses import dataclass

from contracts import Camera
from contracts.truth import CameraTruth, Truth
from sim.body_shapes import Wardrobe
from sim.renderer import Rendered, Renderer
from sim.road_setting import RoadSetting
from sim.road_truth import road_camera_truth


@dataclass(frozen=True, eq=False)
class RoadStudio(RoadSetting):
    """A road's setting with what films it."""

    def renderer(self, pinholes: Sequence[Camera]) -> Renderer:
        """See ``Studio.renderer``."""
        from sim.road_renderer import RoadRenderer

        return RoadRenderer(self, pinholes)

    def view(self, camera: Camera, state: Truth, seen: Rendered) -> CameraTruth:
        """See ``Studio.view``."""
        return road_camera_truth(camera, state, seen, Wardrobe(self.seed))
