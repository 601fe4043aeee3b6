"""The plant's stage: vehicles are boxes, and the white spots of switches show or hide."""

from dataclasses import dataclass

import mujoco
import numpy as np

from contracts import FloatArray, SwitchState
from contracts.truth import Truth
from sim.colours import Colour
from sim.floor import floor_texture
from sim.scene import Scene
from sim.scene_model import build_model
from sim.stage import Stage

_SPOT_SHOWN, _SPOT_HIDDEN = (0.95, 0.95, 0.95, 1.0), (0.16, 0.16, 0.17, 1.0)


@dataclass(frozen=True, eq=False)
class _Vehicle:
    """Row ``row`` of the truth: exactly its box, in one matte colour."""

    state: Truth
    row: int

    def fill(self, geom: mujoco.MjvGeom) -> None:
        state, row = self.state, self.row
        length, width, height = state.sizes_m[row]
        cos, sin = np.cos(state.headings_rad[row]), np.sin(state.headings_rad[row])
        mujoco.mjv_initGeom(
            geom,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=np.array([length, width, height]) / 2,
            pos=state.positions_m[row] + (0.0, 0.0, height / 2),
            mat=np.array([cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0]),
            rgba=np.array([*np.array(Colour(state.labels[row]).srgb) / 255.0, 1.0], np.float32),
        )
        geom.segid = row
        geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0


class PlantStage(Stage):
    """See ``sim.stage.Stage``; the scene of a plant."""

    def __init__(self, scene: Scene, size_px: tuple[int, int]) -> None:
        model = build_model(scene, buffer_px=size_px)
        names = [model.geom(number).name for number in range(model.ngeom)]
        flat = [name for name in names if name in ("floor", "marks") or name.startswith("sheet/")]
        super().__init__(model, size_px, flat=flat)
        self._scene = scene

    def place(self, state: Truth) -> None:
        """Put the vehicles and the switches as ``state`` says."""
        self.put(_Vehicle(state, row) for row in range(len(state.ids)))
        self._show_spots(state.switches or {})

    def still_albedo(self) -> FloatArray:
        """Mean colour of each part, (1 + parts, 3) BGR, 1 for white; row 0 is nothing at all."""
        rgb = np.array([[0.0, 0.0, 0.0], *(geom.rgba[:3] for geom in self._drawn.geoms[: self._static_count])])
        floor = 1 + self._model.geom("floor").id
        rgb[floor] *= floor_texture(self._scene.seed, self._scene.floor).reshape(-1, 3).mean(axis=0) / 255.0
        return rgb[:, ::-1]

    def _show_spots(self, switches: dict[str, SwitchState]) -> None:
        for spot in self._scene.spots:
            geom = self._drawn.geoms[self._model.geom(f"spot/{spot.switch}").id]
            shown = switches.get(spot.switch, SwitchState.UNKNOWN) in spot.visible_in
            geom.rgba[:] = _SPOT_SHOWN if shown else _SPOT_HIDDEN
