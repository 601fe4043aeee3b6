"""What every MuJoCo model of a scene is put together from."""

import mujoco

from sim.lights import Rgb
from sim.meshes import Mesh


def set_quality(spec: mujoco.MjSpec, buffer_px: tuple[int, int]) -> None:
    """Off-screen pictures of at most ``buffer_px`` (width, height): four samples per pixel, no light of its own."""
    spec.visual.global_.offwidth, spec.visual.global_.offheight = buffer_px
    quality = spec.visual.quality
    quality.offsamples, quality.shadowsize = 4, 2048
    quality.numslices = quality.numstacks = 8
    quality.numquads = 1
    spec.visual.headlight.active = 0
    spec.stat.extent, spec.stat.center = 1.0, (0.0, 0.0, 0.0)


def add_mesh(spec: mujoco.MjSpec, name: str, mesh: Mesh, *, textured: bool = False) -> None:
    """A mesh that geoms may show. textured: all of it shows the one texel (0, 0) of its material's texture."""
    spec.add_mesh(
        name=name,
        uservert=mesh.vertices_m.ravel().tolist(),
        userface=mesh.faces.ravel().tolist(),
        usertexcoord=[0.0] * (2 * len(mesh.vertices_m)) if textured else [],
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )


def add_still(spec: mujoco.MjSpec, name: str, colour: Rgb, *, material: str = "") -> None:
    """A geom that stands still and shows the mesh of its name, in one matte colour or in a material."""
    spec.worldbody.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=name,
        rgba=[*colour, 1.0],
        material=material,
        contype=0,
        conaffinity=0,
    )
