"""The road's stage: bodies of road users, each made of parts, scaled to the user's true box."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray, ImageArray
from contracts.truth import Truth
from sim.body_shapes import Wardrobe, affine, pose_of
from sim.lights import ALBEDO, Rgb
from sim.road_model import body_mesh, build_road_model
from sim.road_scene import KIND_CODES, RoadScene, StillPart
from sim.stage import STILL_NUMBER, Stage

NEAR_M, FAR_M = 0.5, 600.0
_BEAM_START_M = 90.0
_MAX_USERS, _PARTS_PER_USER = 254, 24
_BLACK: Rgb = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class BodyPart:
    """A mesh of the model under an affine map.

    world_from_mesh: (3, 3), need not be a rotation: it scales, too. position_m: (3,) of the mesh's own origin.
    """

    mesh: int
    world_from_mesh: FloatArray
    position_m: FloatArray
    rgb: Rgb
    number: int

    def fill(self, geom: mujoco.MjvGeom) -> None:
        """See ``sim.stage.Mover``."""
        mujoco.mjv_initGeom(
            geom,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            size=np.ones(3),
            pos=self.position_m,
            mat=self.world_from_mesh.ravel(),
            rgba=np.array([*self.rgb, 1.0], np.float32),
        )
        geom.dataid = 2 * self.mesh  # odd numbers are the convex hulls
        geom.segid = self.number
        geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0


@dataclass(frozen=True, eq=False)
class VeilPart:
    """Something that stands still and hides what is behind it, as the model has it."""

    mesh: int
    world_from_mesh: FloatArray
    position_m: FloatArray
    material: int

    def fill(self, geom: mujoco.MjvGeom) -> None:
        """See ``sim.stage.Mover``."""
        BodyPart(self.mesh, self.world_from_mesh, self.position_m, _BLACK, STILL_NUMBER).fill(geom)
        geom.matid, geom.texcoord = self.material, 1


class RoadStage(Stage):
    """See ``sim.stage.Stage``; a road scene, the whole of it or only its veil (``sim.road_model``)."""

    def __init__(self, scene: RoadScene, size_px: tuple[int, int], wardrobe: Wardrobe, *, veiled: bool = False) -> None:
        model = build_road_model(scene, buffer_px=size_px, veiled=veiled)
        parts = [part for part in scene.parts if part.hides or not veiled]
        flat = [part.name for part in parts if not part.kind.upright]
        super().__init__(
            model,
            size_px,
            flat=flat,
            near_m=NEAR_M,
            far_m=FAR_M,
            beam_start_m=_BEAM_START_M,
            movers=_MAX_USERS * _PARTS_PER_USER,
        )
        self._wardrobe = wardrobe
        self._codes = np.array([0, *(KIND_CODES[part.kind] for part in parts)], np.uint8)
        self._shining = np.array([part.shining for part in parts])
        self._meshes: dict[str, _Mesh] = {}

    def place(self, state: Truth) -> None:
        """Put the road users as ``state`` says."""
        self.put(self._bodies(state))

    def still_kinds(self) -> tuple[ImageArray, NDArray[np.float32]]:
        """What of the scene each pixel shows, (H, W) codes of ``KIND_CODES``, 0 for the sky; its depth, m."""
        parts, depth_m = self.still_parts()
        return self._codes[parts], depth_m

    def still_shining(self) -> ImageArray:
        """What parts of the scene send out by themselves while lamps are on, (H, W, 3) BGR levels."""
        return self._painted(self._shining)

    def users_share(self) -> NDArray[np.float32]:
        """Share of each pixel that road users cover, (H, W)."""
        colours = np.zeros((self._drawn.ngeom, 3))
        colours[self._static_count :] = 1.0
        return self._painted(colours)[..., 0].astype(np.float32) / np.float32(255.0)

    def _painted(self, rgb: FloatArray) -> ImageArray:
        """What is to be seen if the first things had these colours (N, 3) and no shades; they keep their own."""
        drawn = self._drawn.geoms[: len(rgb)]
        own = [geom.rgba.copy() for geom in drawn]
        for geom, colour in zip(drawn, rgb, strict=True):
            geom.rgba[:3] = colour
        self.illuminate(ALBEDO, np.zeros(3), FAR_M)
        shown = self.picture()
        for geom, rgba in zip(drawn, own, strict=True):
            geom.rgba[:] = rgba
        return shown

    def _bodies(self, state: Truth) -> Iterator[BodyPart]:
        for row in range(len(state.ids)):
            look = self._wardrobe.appearance(state.kinds[row], state.ids[row])
            world_from_unit = affine(state, row)
            for number, part in enumerate(look.design.parts):
                mesh = self._mesh(body_mesh(look.design.name, number))
                turn, shift = pose_of(part, state, row)
                yield BodyPart(
                    mesh.number,
                    world_from_unit @ turn @ mesh.unit_from_mesh,
                    world_from_unit @ (turn @ mesh.origin + shift) + state.positions_m[row],
                    look.colours[part.material],
                    row,
                )

    def _mesh(self, name: str) -> "_Mesh":
        if name not in self._meshes:
            number, turn = self._model.mesh(name).id, np.empty(9)
            mujoco.mju_quat2Mat(turn, self._model.mesh_quat[number])
            self._meshes[name] = _Mesh(number, turn.reshape(3, 3), self._model.mesh_pos[number].copy())
        return self._meshes[name]


class VeilStage(RoadStage):
    """The veil of a road scene, of which only those parts are drawn that make a difference."""

    def __init__(self, scene: RoadScene, size_px: tuple[int, int], wardrobe: Wardrobe) -> None:
        super().__init__(scene, size_px, wardrobe, veiled=True)
        still = self._drawn.geoms[: self._static_count]
        self._veil = [
            VeilPart(geom.dataid // 2, geom.mat.reshape(3, 3).copy(), geom.pos.copy(), geom.matid) for geom in still
        ]
        self._static_count = 0  # whatever is drawn is put there

    def place_behind(self, parts: Sequence[int], state: Truth) -> None:
        """Put the road users, and of the veil these parts, as they are counted in ``hiding_parts``."""
        self.put(itertools.chain((self._veil[number] for number in parts), self._bodies(state)))


def hiding_parts(scene: RoadScene) -> list[StillPart]:
    """What the veil consists of."""
    return [part for part in scene.parts if part.hides]


@dataclass(frozen=True, eq=False)
class _Mesh:
    """A mesh of the model, which the compiler moved into its own axes: unit_from_mesh (3, 3), origin (3,) undo it."""

    number: int
    unit_from_mesh: FloatArray
    origin: FloatArray
