"""Where a world is filmed: all that a renderer is made of, in numbers, so that another process can make it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from contracts import Camera
from contracts.truth import CameraTruth, Truth
from sim.camera_truth import camera_truth
from sim.light_program import LightProgram
from sim.lights import LightPreset
from sim.renderer import Rendered, Renderer, RendererName
from sim.scene import Scene


class Studio(Protocol):
    """One world, ready to be filmed."""

    def renderer(self, pinholes: Sequence[Camera]) -> Renderer:
        """Draws for these cameras, which have no lens; graphics are loaded here and no sooner."""
        ...

    def view(self, camera: Camera, state: Truth, seen: Rendered) -> CameraTruth:
        """What ``camera`` sees of the truth; ``seen`` is what the renderer drew, as the camera's lens bends it."""
        ...


@dataclass(frozen=True, eq=False)
class PlantStudio:
    """The model railway."""

    scene: Scene
    light: LightPreset | LightProgram
    name: RendererName

    def renderer(self, pinholes: Sequence[Camera]) -> Renderer:
        """See ``Studio.renderer``."""
        if self.name is RendererName.FULL:
            from sim.full_renderer import FullRenderer

            return FullRenderer(self.scene, pinholes, self.light)
        from sim.layered_renderer import LayeredRenderer

        return LayeredRenderer(self.scene, pinholes, self.light)

    def view(self, camera: Camera, state: Truth, seen: Rendered) -> CameraTruth:
        """See ``Studio.view``."""
        return camera_truth(camera, state, seen)
