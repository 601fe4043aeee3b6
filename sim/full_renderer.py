"""The full renderer: everything drawn anew for each picture. Slow and simple; the oracle of faster ones."""

from collections.abc import Sequence

from contracts import Camera, ImageArray, InputError
from contracts.truth import Truth
from sim.lights import Light, LightPreset, light_at
from sim.renderer import Rendered
from sim.scene import Scene
from sim.shade import along_beam, ground_in_view, mixed, world_points
from sim.stage import Stage


class FullRenderer:
    """Four samples per pixel and shadow maps; one OpenGL context for all cameras.

    cameras: the true ones, as pinholes: their distortion is ignored.
    """

    def __init__(self, scene: Scene, cameras: Sequence[Camera], preset: LightPreset) -> None:
        self._cameras = {camera.name: camera for camera in cameras}
        self._preset = preset
        sizes = [(camera.intrinsics.width_px, camera.intrinsics.height_px) for camera in cameras]
        self._stage = Stage(scene, (max(w for w, _ in sizes), max(h for _, h in sizes)))

    def render(self, state: Truth, camera: str) -> Rendered:
        """See ``Renderer.render``; raises InputError for a camera that the renderer was not made with."""
        if camera not in self._cameras:
            raise InputError(f"camera {camera} is not in this renderer; it has {', '.join(self._cameras)}")
        view = self._cameras[camera]
        light = light_at(self._preset, state.time_ns)
        self._stage.place(state)
        self._stage.aim(view)
        instances, depth_m = self._stage.identities()
        image = self._lit(view, light)
        if light.band is not None:
            shade = light.band.shade(along_beam(world_points(view, depth_m), light.beams[0]))
            image = mixed(image, self._lit(view, light.without_beams()), shade)
        return Rendered(image, instances)

    def close(self) -> None:
        """Free the OpenGL context."""
        self._stage.close()

    def _lit(self, view: Camera, light: Light) -> ImageArray:
        self._stage.illuminate(light, *ground_in_view(view))
        return self._stage.picture()
