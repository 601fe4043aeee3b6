"""The full renderer: everything drawn anew for each picture. Slow and simple; the oracle of faster ones."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray, InputError
from contracts.truth import Truth
from sim.light_program import LightProgram, lights_at
from sim.lights import Light, LightPreset
from sim.plant_stage import PlantStage
from sim.renderer import Rendered, blended
from sim.scene import Scene
from sim.shade import along_beam, ground_in_view, mixed, world_points


class FullRenderer:
    """Four samples per pixel and shadow maps; one OpenGL context for all cameras.

    cameras: the true ones, as pinholes: their distortion is ignored.
    """

    def __init__(self, scene: Scene, cameras: Sequence[Camera], light: LightPreset | LightProgram) -> None:
        self._cameras = {camera.name: camera for camera in cameras}
        self._light = light
        sizes = [(camera.intrinsics.width_px, camera.intrinsics.height_px) for camera in cameras]
        self._stage = PlantStage(scene, (max(w for w, _ in sizes), max(h for _, h in sizes)))

    def render(self, state: Truth, camera: str) -> Rendered:
        """See ``Renderer.render``; raises InputError for a camera that the renderer was not made with."""
        if camera not in self._cameras:
            raise InputError(f"camera {camera} is not in this renderer; it has {', '.join(self._cameras)}")
        view = self._cameras[camera]
        self._stage.place(state)
        self._stage.aim(view)
        instances, depth_m = self._stage.identities()
        lights = lights_at(self._light, state.time_ns)
        return blended([(weight, Rendered(self._under(light, view, depth_m), instances)) for weight, light in lights])

    def close(self) -> None:
        """Free the OpenGL context."""
        self._stage.close()

    def _under(self, light: Light, view: Camera, depth_m: NDArray[np.float32]) -> ImageArray:
        image = self._lit(view, light)
        if light.band is None:
            return image
        shade = light.band.shade(along_beam(world_points(view, depth_m), light.beams[0]))
        return mixed(image, self._lit(view, light.without_beams()), shade)

    def _lit(self, view: Camera, light: Light) -> ImageArray:
        self._stage.illuminate(light, *ground_in_view(view))
        return self._stage.picture()
