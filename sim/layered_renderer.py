"""The layered renderer: the empty scene filmed once per light, and per frame only what moves, where it moves.

The camera stands still, so the empty scene, what each beam adds to it and its depth are drawn by OpenGL once and kept.
Vehicles are boxes of one colour each: rays through the very sample places of the graphics hardware say where a box lies
before all else, which face shows, and what it keeps from the light. No OpenGL is called per frame.

What is drawn: vehicles before and behind each other and whatever stands still; their shadows on each other, on the
ground and on all else that stands still; the shadows of what stands still: on each other as OpenGL draws them, on
vehicles as far as they are prisms (``sim.still_solids``). What is not: shadows of rails, sleepers and switch machines
on vehicles, all lower than 9 mm. Vehicles are upright boxes of one colour, as ``Truth`` says them.

Kept: per camera the depth; per camera and light, its strength and shadow band aside, the pictures. Done anew per frame:
vehicles and their shadows inside their windows; for a light of another strength one scaling of the picture; for a
shadow band one mix of two pictures. A light of new direction or colour is filmed anew; the last few are kept.
"""

from collections.abc import Sequence

from contracts import Camera, InputError
from contracts.truth import Truth
from sim.layered_view import LayeredView
from sim.light_program import LightProgram, lights_at
from sim.lights import LightPreset
from sim.plant_stage import PlantStage
from sim.renderer import Rendered, blended
from sim.scene import Scene


class LayeredRenderer:
    """See ``sim.renderer.Renderer``; the pictures of ``FullRenderer`` but for the edges of shadows.

    cameras: the true ones, as pinholes: their distortion is ignored.
    """

    def __init__(self, scene: Scene, cameras: Sequence[Camera], light: LightPreset | LightProgram) -> None:
        self._light = light
        sizes = [(camera.intrinsics.width_px, camera.intrinsics.height_px) for camera in cameras]
        self._stage = PlantStage(scene, (max(w for w, _ in sizes), max(h for _, h in sizes)))
        self._views = {camera.name: LayeredView(camera, scene, self._stage) for camera in cameras}

    def render(self, state: Truth, camera: str) -> Rendered:
        """See ``Renderer.render``; raises InputError for a camera that the renderer was not made with."""
        if camera not in self._views:
            raise InputError(f"camera {camera} is not in this renderer; it has {', '.join(self._views)}")
        lights = lights_at(self._light, state.time_ns)
        return blended([(weight, self._views[camera].render(state, light)) for weight, light in lights])

    def close(self) -> None:
        """Free the OpenGL context."""
        self._stage.close()
