"""The road's renderers: layered, and the slow one that draws everything anew."""

from collections.abc import Sequence

from contracts import Camera, InputError
from contracts.truth import Truth
from sim.air import diffused
from sim.body_shapes import Wardrobe
from sim.light_program import lights_at
from sim.renderer import Rendered, RendererName, blended
from sim.road_setting import RoadSetting
from sim.road_stage import RoadStage, VeilStage
from sim.road_view import RoadView


class RoadRenderer:
    """A ``sim.renderer.Renderer``; ``full`` draws every frame as a whole, in one pass with shadow maps.

    cameras: the true ones, as pinholes: their distortion is ignored.
    """

    def __init__(self, setting: RoadSetting, cameras: Sequence[Camera]) -> None:
        sizes = [(camera.intrinsics.width_px, camera.intrinsics.height_px) for camera in cameras]
        size = (max(w for w, _ in sizes), max(h for _, h in sizes))
        self._light, self._weather, self._name = setting.light, setting.weather, setting.name
        wardrobe = Wardrobe(setting.seed)
        self._stages = RoadStage(setting.scene, size, wardrobe), VeilStage(setting.scene, size, wardrobe)
        self._views = {camera.name: RoadView(camera, setting, *self._stages) for camera in cameras}

    def render(self, state: Truth, camera: str) -> Rendered:
        """See ``Renderer.render``; raises InputError for a camera that the renderer was not made with."""
        if camera not in self._views:
            raise InputError(f"camera {camera} is not in this renderer; it has {', '.join(self._views)}")
        view = self._views[camera]
        draw = view.render_anew if self._name is RendererName.FULL else view.render
        lights = lights_at(self._light, state.time_ns)
        return blended([(weight, draw(state, diffused(light, self._weather))) for weight, light in lights])

    def close(self) -> None:
        """Free the OpenGL contexts."""
        for stage in self._stages:
            stage.close()
