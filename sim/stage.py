"""The stage: one OpenGL context with the scene in it, vehicles placed on it, a camera and lights turned to it.

Every renderer draws through this, so frustum, half pixel, lights and identities are right in one place.
"""

import atexit
import weakref

import mujoco
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray, SwitchState
from contracts.truth import Truth
from sim.colours import Colour
from sim.floor import floor_texture
from sim.lights import Light
from sim.scene import Scene
from sim.scene_model import build_model

NEAR_M, FAR_M = 0.05, 50.0

_STATIC_SEGID = 255  # MuJoCo paints segid + 1 = 256 = (0, 1, 0): red, the byte that counts vehicles, stays 0
_BEAM_START_M = 12.0  # directional lights have a place too: their shadow map is drawn from there
_SPOT_SHOWN, _SPOT_HIDDEN = (0.95, 0.95, 0.95, 1.0), (0.16, 0.16, 0.17, 1.0)

_DARK = np.zeros(3)
_Flag = mujoco.mjtRndFlag


_OPEN: "weakref.WeakSet[Stage]" = weakref.WeakSet()


def _close_all() -> None:
    """Free what nobody closed, before the interpreter ends."""
    for stage in list(_OPEN):
        stage.close()


class Stage:
    """Draws RGB pictures, identities and depths of a scene at a state.

    size_px: largest picture (width, height) that will be asked for.
    """

    def __init__(self, scene: Scene, size_px: tuple[int, int]) -> None:
        self._scene = scene
        self._gl = mujoco.GLContext(*size_px)
        self._gl.make_current()
        self._model = build_model(scene, buffer_px=size_px)
        self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._drawn = _static_geometry(self._model)
        self._static_count = self._drawn.ngeom
        self._viewport = mujoco.MjrRect(0, 0, 1, 1)
        _OPEN.add(self)
        atexit.unregister(_close_all)
        atexit.register(_close_all)  # what is registered last runs first: before MuJoCo, with its first context, ends

    def close(self) -> None:
        """Free the context and its memory; once is enough."""
        if self in _OPEN:
            _OPEN.remove(self)
            self._gl.make_current()
            self._context.free()
            self._gl.free()

    def place(self, state: Truth) -> None:
        """Put the vehicles and the switches as ``state`` says."""
        drawn = self._drawn
        self._gl.make_current()
        drawn.ngeom = self._static_count
        for row in range(len(state.ids)):
            geom = drawn.geoms[drawn.ngeom]
            _init_vehicle(geom, state, row)
            drawn.ngeom += 1
        self._show_spots(state.switches or {})

    def aim(self, camera: Camera) -> None:
        """Look through the pinhole of ``camera``."""
        size = camera.intrinsics
        self._viewport = mujoco.MjrRect(0, 0, size.width_px, size.height_px)
        for eye in self._drawn.camera:  # both eyes, or the picture would be their mean
            _set_frustum(eye, camera)

    def illuminate(self, light: Light, centre_m: FloatArray, radius_m: float) -> None:
        """Light the scene; shadows are right within ``radius_m`` of ``centre_m`` (3,)."""
        drawn = self._drawn
        drawn.nlight = 1 + len(light.beams)
        factor = light.factor
        sky, ambient = factor * np.array(light.sky), factor * np.array(light.ambient)
        _set_light(drawn.lights[0], np.array([0.0, 0.0, -1.0]), centre_m, diffuse=sky, ambient=ambient)
        for slot, beam in enumerate(light.beams, start=1):
            _set_light(drawn.lights[slot], beam.direction, centre_m, diffuse=factor * np.array(beam.rgb), casts=True)
        self._context.shadowClip = radius_m

    def picture(self) -> ImageArray:
        """What the camera sees, (H, W, 3) BGR."""
        drawn, size = self._drawn, self._viewport
        drawn.flags[_Flag.mjRND_SHADOW] = drawn.nlight > 1
        self._gl.make_current()
        mujoco.mjr_render(size, drawn, self._context)
        rgb = np.empty((size.height, size.width, 3), np.uint8)
        mujoco.mjr_readPixels(rgb, None, size, self._context)
        return np.ascontiguousarray(rgb[::-1, :, ::-1])

    def identities(self) -> tuple[ImageArray, NDArray[np.float32]]:
        """Which vehicle each pixel shows, (H, W) as in ``Rendered.instances``; its depth along the axis, m."""
        colours, depth_m = self._segmented()
        return np.ascontiguousarray(colours[..., 0]), depth_m

    def still_parts(self) -> tuple[NDArray[np.uint16], NDArray[np.float32]]:
        """Which part of the scene each pixel shows, (H, W) rows of ``still_albedo``; its depth along the axis, m."""
        still = self._drawn.geoms[: self._static_count]
        for row, geom in enumerate(still):
            geom.segid = row
        colours, depth_m = self._segmented()
        for geom in still:
            geom.segid = _STATIC_SEGID
        return colours[..., 0] + np.uint16(256) * colours[..., 1], depth_m  # MuJoCo paints segid + 1

    def still_albedo(self) -> FloatArray:
        """Mean colour of each part, (1 + parts, 3) BGR, 1 for white; row 0 is nothing at all."""
        rgb = np.array([[0.0, 0.0, 0.0], *(geom.rgba[:3] for geom in self._drawn.geoms[: self._static_count])])
        floor = 1 + self._model.geom("floor").id
        rgb[floor] *= floor_texture(self._scene.seed, self._scene.floor).reshape(-1, 3).mean(axis=0) / 255.0
        return rgb[:, ::-1]

    def _segmented(self) -> tuple[ImageArray, NDArray[np.float32]]:
        """Numbers of what is drawn as colours (H, W, 3), the low byte first; depth along the axis, m."""
        drawn, size = self._drawn, self._viewport
        drawn.flags[_Flag.mjRND_SEGMENT] = drawn.flags[_Flag.mjRND_IDCOLOR] = True
        drawn.flags[_Flag.mjRND_SHADOW] = False
        self._gl.make_current()
        mujoco.mjr_render(size, drawn, self._context)
        drawn.flags[_Flag.mjRND_SEGMENT] = drawn.flags[_Flag.mjRND_IDCOLOR] = False
        rgb = np.empty((size.height, size.width, 3), np.uint8)
        depth = np.empty((size.height, size.width), np.float32)
        mujoco.mjr_readPixels(rgb, depth, size, self._context)
        metres = NEAR_M / (1.0 - depth[::-1] * (1.0 - NEAR_M / FAR_M))
        return rgb[::-1], metres.astype(np.float32)

    def _show_spots(self, switches: dict[str, SwitchState]) -> None:
        for spot in self._scene.spots:
            geom = self._drawn.geoms[self._model.geom(f"spot/{spot.switch}").id]
            shown = switches.get(spot.switch, SwitchState.UNKNOWN) in spot.visible_in
            geom.rgba[:] = _SPOT_SHOWN if shown else _SPOT_HIDDEN


def _static_geometry(model: mujoco.MjModel) -> mujoco.MjvScene:
    """The scene's own geometry, in the order of the model's geoms, matte, with nothing but what we draw."""
    drawn = mujoco.MjvScene(model, maxgeom=model.ngeom + 255)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, mujoco.MjvCamera(), mujoco.mjtCatBit.mjCAT_ALL, drawn)
    names = [model.geom(k).name for k in range(model.ngeom)]
    flat = [k for k, name in enumerate(names) if name in ("floor", "marks") or name.startswith("sheet/")]
    for geom in drawn.geoms[: drawn.ngeom]:
        geom.segid = _STATIC_SEGID
        geom.castshadow = geom.objid not in flat  # or what lies on the ground would speckle itself in wide views
        geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0
    for flag in (_Flag.mjRND_REFLECTION, _Flag.mjRND_SKYBOX, _Flag.mjRND_HAZE, _Flag.mjRND_FOG):
        drawn.flags[flag] = False
    return drawn


def _init_vehicle(geom: mujoco.MjvGeom, state: Truth, row: int) -> None:
    """A box that is exactly the box of the truth, in one matte colour."""
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


def _set_frustum(eye: mujoco.MjvGLCamera, camera: Camera) -> None:
    """The frustum of exactly this image: the first pixel's *centre* is (0, 0), so the edges lie at -0.5 and W - 0.5."""
    numbers = camera.intrinsics
    left = (-0.5 - numbers.cx_px) / numbers.fx_px
    right = (numbers.width_px - 0.5 - numbers.cx_px) / numbers.fx_px
    eye.frustum_center = NEAR_M * (left + right) / 2
    eye.frustum_width = NEAR_M * (right - left) / 2  # half of the width
    eye.frustum_top = NEAR_M * (0.5 + numbers.cy_px) / numbers.fy_px
    eye.frustum_bottom = NEAR_M * (numbers.cy_px + 0.5 - numbers.height_px) / numbers.fy_px
    eye.frustum_near, eye.frustum_far = NEAR_M, FAR_M
    eye.pos[:] = camera.pose.position_m
    eye.forward[:] = camera.pose.world_from_camera[:, 2]
    eye.up[:] = -camera.pose.world_from_camera[:, 1]


def _set_light(
    slot: mujoco.MjvLight,
    direction: FloatArray,
    centre_m: FloatArray,
    *,
    diffuse: FloatArray,
    ambient: FloatArray = _DARK,
    casts: bool = False,
) -> None:
    """Parallel light. A casting light must not be ambient: MuJoCo takes that away in the shadow too."""
    slot.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    slot.dir[:] = direction
    slot.pos[:] = centre_m - _BEAM_START_M * direction
    slot.diffuse[:] = diffuse
    slot.ambient[:] = ambient
    slot.specular[:] = 0.0
    slot.attenuation[:] = (1.0, 0.0, 0.0)
    slot.castshadow = casts
    slot.headlight = 0
    slot.texid = -1
    slot.intensity = 0.0
