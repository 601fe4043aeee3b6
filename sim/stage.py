"""The stage: one OpenGL context with a model in it, whatever moves placed on it, a camera and lights turned to it.

Every renderer draws through this, so frustum, half pixel, lights and identities are right in one place.
"""

import atexit
import weakref
from collections.abc import Collection, Iterable, Sequence
from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray
from OpenGL import GL

from contracts import Camera, FloatArray, ImageArray
from sim.lights import Light
from sim.renderer import Window

STILL_NUMBER = 255
"""Of whatever stands still: MuJoCo paints it plus 1, 256, as (0, 1, 0); red, the byte that counts movers, stays 0."""

_LOW_BYTE, _HIGH_BYTE = 2, 1  # red and green of BGRA
_DARK = np.zeros(3)
_Flag = mujoco.mjtRndFlag


_OPEN: "weakref.WeakSet[Stage]" = weakref.WeakSet()


def _close_all() -> None:
    """Free what nobody closed, before the interpreter ends."""
    for stage in list(_OPEN):
        stage.close()


class Mover(Protocol):
    """A geom that moves."""

    def fill(self, geom: mujoco.MjvGeom) -> None:
        """Say all that is to be drawn; nothing of what the geom said before stays."""
        ...


class Stage:
    """Draws RGB pictures, identities and depths of a model at rest and of what moves on it.

    model: its geoms stand still. size_px: largest picture (width, height) that will be asked for.
    flat: names of geoms that lie on the ground: they cast no shadow.
    beam_start_m: beams have a place, too, so far before what they light: their shadow maps are drawn from there.
    near_m, far_m: what is nearer or farther along the camera's axis is cut away.
    movers: at most so many geoms are put on top of the model's own.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        size_px: tuple[int, int],
        *,
        flat: Collection[str] = (),
        near_m: float = 0.05,
        far_m: float = 50.0,
        beam_start_m: float = 12.0,
        movers: int = 255,
    ) -> None:
        self._model, self._near_m, self._far_m, self._beam_start_m = model, near_m, far_m, beam_start_m
        self._gl = mujoco.GLContext(*size_px)
        self._gl.make_current()
        self._context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._drawn = _static_geometry(self._model, flat, movers)
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

    def put(self, movers: Iterable[Mover]) -> None:
        """Show these on top of the model, instead of those before."""
        drawn = self._drawn
        self._gl.make_current()
        drawn.ngeom = self._static_count
        for mover in movers:
            mover.fill(drawn.geoms[drawn.ngeom])
            drawn.ngeom += 1

    def aim(self, camera: Camera) -> None:
        """Look through the pinhole of ``camera``."""
        size = camera.intrinsics
        self._viewport = mujoco.MjrRect(0, 0, size.width_px, size.height_px)
        for eye in self._drawn.camera:  # both eyes, or the picture would be their mean
            _set_frustum(eye, camera, self._near_m, self._far_m)

    def illuminate(self, light: Light, centre_m: FloatArray, radius_m: float) -> None:
        """Light the scene; shadows are right within ``radius_m`` of ``centre_m`` (3,)."""
        drawn = self._drawn
        drawn.nlight = 1 + len(light.beams)
        factor = light.factor
        sky, ambient = factor * np.array(light.sky), factor * np.array(light.ambient)
        down = np.array([0.0, 0.0, -1.0])
        _set_light(drawn.lights[0], down, centre_m - self._beam_start_m * down, diffuse=sky, ambient=ambient)
        for slot, beam in enumerate(light.beams, start=1):
            start_m = centre_m - self._beam_start_m * beam.direction
            _set_light(drawn.lights[slot], beam.direction, start_m, diffuse=factor * np.array(beam.rgb), casts=True)
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

    def layer(self) -> ImageArray:
        """The same with its opacity, (H, W, 4) BGRA: colours are multiplied by it, nothing at all is (0, 0, 0, 0)."""
        return self.layers([self._whole])[0]

    def layers(self, windows: Sequence[Window]) -> list[ImageArray]:
        """Parts of ``layer``, drawn once; what is not read costs little."""
        self._drawn.flags[_Flag.mjRND_SHADOW] = self._drawn.nlight > 1
        self._gl.make_current()
        mujoco.mjr_render(self._viewport, self._drawn, self._context)
        return [self._colours(window) for window in windows]

    def identities(self) -> tuple[ImageArray, NDArray[np.float32]]:
        """Which mover each pixel shows, (H, W) as in ``Rendered.instances``; its depth along the axis, m."""
        self._draw_numbers()
        return self._colours(self._whole)[..., _LOW_BYTE].copy(), self._depth_m(self._whole)

    def identities_in(self, windows: Sequence[Window], *, depth: bool) -> list[tuple[ImageArray, NDArray[np.float32]]]:
        """Parts of ``identities``, drawn once. depth: whether it is needed; it takes longest, and is 0 if not."""
        self._draw_numbers()
        numbers = [self._colours(window)[..., _LOW_BYTE].copy() for window in windows]
        if not depth:
            return [(part, np.zeros(part.shape, np.float32)) for part in numbers]
        return [(part, self._depth_m(window)) for part, window in zip(numbers, windows, strict=True)]

    def still_parts(self) -> tuple[NDArray[np.uint16], NDArray[np.float32]]:
        """Which part of the model each pixel shows, (H, W) 1 + the geom's number or 0; its depth along the axis, m."""
        still = self._drawn.geoms[: self._static_count]
        for row, geom in enumerate(still):
            geom.segid = row
        self._draw_numbers()
        colours = self._colours(self._whole)
        for geom in still:
            geom.segid = STILL_NUMBER
        parts = colours[..., _LOW_BYTE] + np.uint16(256) * colours[..., _HIGH_BYTE]  # MuJoCo paints segid + 1
        return parts, self._depth_m(self._whole)

    @property
    def _whole(self) -> Window:
        return slice(0, self._viewport.height), slice(0, self._viewport.width)

    def _area(self, window: Window) -> tuple[int, int, int, int]:
        """Left, bottom, width and height in OpenGL's pixels, whose rows go up."""
        rows, columns = window
        return (
            columns.start,
            self._viewport.height - rows.stop,
            columns.stop - columns.start,
            rows.stop - rows.start,
        )

    def _draw_numbers(self) -> None:
        """Draw everything in the colour of its number, the low byte first."""
        drawn = self._drawn
        drawn.flags[_Flag.mjRND_SEGMENT] = drawn.flags[_Flag.mjRND_IDCOLOR] = True
        drawn.flags[_Flag.mjRND_SHADOW] = False
        self._gl.make_current()
        mujoco.mjr_render(self._viewport, drawn, self._context)
        drawn.flags[_Flag.mjRND_SEGMENT] = drawn.flags[_Flag.mjRND_IDCOLOR] = False

    def _colours(self, window: Window) -> ImageArray:
        """What was drawn last, (h, w, 4) BGRA, the mean of each pixel's samples; no more is moved than asked for."""
        left, bottom, width, height = self._area(window)
        corners = (left, bottom, left + width, bottom + height)
        GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._context.offFBO)
        GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, self._context.offFBO_r)
        GL.glBlitFramebuffer(*corners, *corners, GL.GL_COLOR_BUFFER_BIT, GL.GL_NEAREST)
        GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._context.offFBO_r)
        GL.glPixelStorei(GL.GL_PACK_ALIGNMENT, 1)
        bgra = np.empty((height, width, 4), np.uint8)
        GL.glReadPixels(left, bottom, width, height, GL.GL_BGRA, GL.GL_UNSIGNED_BYTE, bgra)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        return np.ascontiguousarray(bgra[::-1])

    def _depth_m(self, window: Window) -> NDArray[np.float32]:
        """Depth along the axis of what was drawn last, (h, w)."""
        left, bottom, width, height = self._area(window)
        depth = np.empty((height, width), np.float32)
        mujoco.mjr_readPixels(None, depth, mujoco.MjrRect(left, bottom, width, height), self._context)
        metres = self._near_m / (1.0 - depth[::-1] * (1.0 - self._near_m / self._far_m))
        return metres.astype(np.float32)


def _static_geometry(model: mujoco.MjModel, flat: Collection[str], movers: int) -> mujoco.MjvScene:
    """The model's own geometry, in the order of its geoms, matte, with nothing but what we draw."""
    drawn = mujoco.MjvScene(model, maxgeom=model.ngeom + movers)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, mujoco.MjvCamera(), mujoco.mjtCatBit.mjCAT_ALL, drawn)
    lying = {model.geom(name).id for name in flat}
    for geom in drawn.geoms[: drawn.ngeom]:
        geom.segid = STILL_NUMBER
        geom.castshadow = geom.objid not in lying  # or what lies on the ground would speckle itself in wide views
        geom.specular = geom.shininess = geom.reflectance = geom.emission = 0.0
    for flag in (_Flag.mjRND_REFLECTION, _Flag.mjRND_SKYBOX, _Flag.mjRND_HAZE, _Flag.mjRND_FOG):
        drawn.flags[flag] = False
    return drawn


def _set_frustum(eye: mujoco.MjvGLCamera, camera: Camera, near_m: float, far_m: float) -> None:
    """The frustum of exactly this image: the first pixel's *centre* is (0, 0), so the edges lie at -0.5 and W - 0.5."""
    numbers = camera.intrinsics
    left = (-0.5 - numbers.cx_px) / numbers.fx_px
    right = (numbers.width_px - 0.5 - numbers.cx_px) / numbers.fx_px
    eye.frustum_center = near_m * (left + right) / 2
    eye.frustum_width = near_m * (right - left) / 2  # half of the width
    eye.frustum_top = near_m * (0.5 + numbers.cy_px) / numbers.fy_px
    eye.frustum_bottom = near_m * (numbers.cy_px + 0.5 - numbers.height_px) / numbers.fy_px
    eye.frustum_near, eye.frustum_far = near_m, far_m
    eye.pos[:] = camera.pose.position_m
    eye.forward[:] = camera.pose.world_from_camera[:, 2]
    eye.up[:] = -camera.pose.world_from_camera[:, 1]


def _set_light(
    slot: mujoco.MjvLight,
    direction: FloatArray,
    start_m: FloatArray,
    *,
    diffuse: FloatArray,
    ambient: FloatArray = _DARK,
    casts: bool = False,
) -> None:
    """Parallel light. A casting light must not be ambient: MuJoCo takes that away in the shadow too."""
    slot.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    slot.dir[:] = direction
    slot.pos[:] = start_m
    slot.diffuse[:] = diffuse
    slot.ambient[:] = ambient
    slot.specular[:] = 0.0
    slot.attenuation[:] = (1.0, 0.0, 0.0)
    slot.castshadow = casts
    slot.headlight = 0
    slot.texid = -1
    slot.intensity = 0.0
