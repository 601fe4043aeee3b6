"""A road scene as a MuJoCo model, the whole of it or only what can hide something, and the bodies that move on it."""

import mujoco

from sim.bodies import DESIGNS
from sim.model_parts import add_mesh, add_still, set_quality
from sim.road_scene import RoadScene

_VEIL = "veil"  # a texture of zeros: what wears it hides what is behind, and is not seen


def build_road_model(scene: RoadScene, *, buffer_px: tuple[int, int], veiled: bool = False) -> mujoco.MjModel:
    """Compile the scene for off-screen pictures of at most ``buffer_px`` (width, height).

    veiled: only what hides something, and that leaves neither colour nor opacity, but what is behind stays hidden.
    Geoms have the names of the scene's parts, meshes of bodies those of ``body_mesh``.
    """
    spec = mujoco.MjSpec()
    set_quality(spec, buffer_px)
    if veiled:
        texture = spec.add_texture(name=_VEIL, type=mujoco.mjtTexture.mjTEXTURE_2D, width=1, height=1, nchannel=4)
        texture.data = bytes(4)
        material = spec.add_material(name=_VEIL)
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = _VEIL
    for still in scene.parts:
        if still.hides or not veiled:
            add_mesh(spec, still.name, still.mesh, textured=veiled)
            add_still(spec, still.name, still.rgb, material=_VEIL if veiled else "")
    for design in (design for designs in DESIGNS.values() for design in designs):
        for number, part in enumerate(design.parts):
            add_mesh(spec, body_mesh(design.name, number), part.mesh)
    return spec.compile()


def body_mesh(design: str, number: int) -> str:
    """Name of the mesh that shows this part of a design."""
    return f"body/{design}/{number}"
