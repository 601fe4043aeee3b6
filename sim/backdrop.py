"""The empty scene before one camera, filmed once: what the layered renderer lays vehicles and shadows on."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray, Intrinsics, SwitchState
from contracts.truth import Truth
from sim.box_rays import SAMPLES_PX, Array32
from sim.lights import Beam, Light
from sim.plant_stage import PlantStage
from sim.projection import project
from sim.renderer import Window
from sim.scene import SPOT_HEIGHT_M, SPOT_RADIUS_M, Scene, Spot
from sim.shade import ground_in_view

_LIGHTS_KEPT = 3
_NOTHING = np.empty((0, 3))


@dataclass(frozen=True, eq=False)
class Backdrop:
    """One light at full strength on the empty scene.

    lit: (H, W, 3) uint8 BGR, all light. unlit: without the beams.
    shares: for each beam what it adds to ``unlit``, (H, W, 3) uint8; nothing in the shadow of what stands still.
    """

    lit: ImageArray
    unlit: ImageArray
    shares: tuple[ImageArray, ...]

    def patched(self, other: "Backdrop", windows: list[Window]) -> "Backdrop":
        """A copy with ``other``'s pixels inside the windows."""
        copy = Backdrop(self.lit.copy(), self.unlit.copy(), tuple(share.copy() for share in self.shares))
        for window in windows:
            copy.lit[window], copy.unlit[window] = other.lit[window], other.unlit[window]
            for mine, theirs in zip(copy.shares, other.shares, strict=True):
                mine[window] = theirs[window]
        return copy


class Backdrops:
    """The backdrops of one camera, filmed when first asked for; those of the last few lights are kept."""

    def __init__(self, camera: Camera, scene: Scene, stage: PlantStage) -> None:
        self._camera, self._scene, self._stage = camera, scene, stage
        self._films: dict[Light, tuple[Backdrop, Backdrop]] = {}
        self._latest: dict[Light, tuple[frozenset[str], Backdrop]] = {}
        windows = ((spot.switch, spot_window(camera, spot)) for spot in scene.spots)
        self._spot_windows = {switch: window for switch, window in windows if window is not None}

    def of(self, state: Truth, light: Light) -> Backdrop:
        """The empty scene under the light at full strength, its switch spots as ``state`` has them."""
        plain = replace(light, band=None, factor=1.0)
        visible = spots_shown(self._scene, state) & self._spot_windows.keys()
        if plain not in self._latest or self._latest[plain][0] != visible:
            hidden, shown = self._filmed(plain)
            windows = [self._spot_windows[switch] for switch in visible]
            self._latest[plain] = visible, hidden.patched(shown, windows) if windows else hidden
        return self._latest[plain][1]

    def _filmed(self, light: Light) -> tuple[Backdrop, Backdrop]:
        """All spots hidden, all shown."""
        if light not in self._films:
            if len(self._films) == _LIGHTS_KEPT:
                oldest = next(iter(self._films))
                del self._films[oldest]
                self._latest.pop(oldest, None)
            hidden = film_backdrop(self._stage, self._camera, light, {})
            states = {spot.switch: next(iter(spot.visible_in)) for spot in self._scene.spots}
            shown = film_backdrop(self._stage, self._camera, light, states) if self._spot_windows else hidden
            self._films[light] = hidden, shown
        return self._films[light]


def film_backdrop(stage: PlantStage, camera: Camera, light: Light, switches: dict[str, SwitchState]) -> Backdrop:
    """Film the empty scene under ``light``, the switches as given."""
    stage.place(_empty(switches))
    stage.aim(camera)

    def picture(beams: tuple[Beam, ...]) -> ImageArray:
        stage.illuminate(replace(light, beams=beams), *ground_in_view(camera))
        return stage.picture()

    unlit = picture(())
    lit = picture(light.beams) if light.beams else unlit
    alone = [lit if len(light.beams) == 1 else picture((beam,)) for beam in light.beams]
    return Backdrop(lit, unlit, tuple(image - np.minimum(unlit, image) for image in alone))


@dataclass(frozen=True, eq=False)
class Surfaces:
    """What the samples of a picture of the empty scene show.

    depth_m: (S, H, W) at each of ``SAMPLES_PX``.
    edge: (H, W) row of ``shares`` for pixels whose samples show different parts of the scene, 0 for all others.
    shares: (1 + E, S - 1, 3) colour of each sample but the first over the pixel's colour; row 0 is 1.
    """

    depth_m: Array32
    edge: NDArray[np.int32]
    shares: Array32


def film_surfaces(stage: PlantStage, camera: Camera) -> Surfaces:
    """Look at each sample place by itself, which needs a picture each.

    A pixel's colour is the mean of its samples'; the parts' own colours say in which relation they stand, whatever the
    light, but for faces that are turned from it differently.
    """
    stage.place(_empty({}))
    parts, depths = [], []
    for du, dv in SAMPLES_PX:
        numbers = camera.intrinsics
        shifted = Intrinsics(
            numbers.width_px,
            numbers.height_px,
            numbers.fx_px,
            numbers.fy_px,
            numbers.cx_px - du,
            numbers.cy_px - dv,
            numbers.distortion,
        )
        stage.aim(Camera(camera.name, shifted, camera.pose))
        part, depth_m = stage.still_parts()
        parts.append(part)
        depths.append(depth_m)
    differ = np.logical_or.reduce([part != parts[1] for part in parts[2:]])
    edge = np.zeros(differ.shape, np.int32)
    edge[differ] = 1 + np.arange(np.count_nonzero(differ))
    albedo = stage.still_albedo()[np.stack([part[differ] for part in parts[1:]], axis=1)]  # (E, S - 1, 3)
    shares = albedo / np.maximum(albedo.mean(axis=1, keepdims=True), 1e-3)
    return Surfaces(
        np.stack(depths), edge, np.concatenate([np.ones((1, *shares.shape[1:])), shares]).astype(np.float32)
    )


def spot_window(camera: Camera, spot: Spot) -> Window | None:
    """The part of the image that a switch spot can change; None where it is out of the picture."""
    angle = np.arange(8) * (np.pi / 4)
    rim = np.column_stack([np.cos(angle), np.sin(angle)]) * SPOT_RADIUS_M * 1.1 + spot.position_m
    pixels, valid = project(camera, np.column_stack([rim, np.full(8, SPOT_HEIGHT_M)]))
    if not valid.all():
        return None
    size = np.array([camera.intrinsics.width_px, camera.intrinsics.height_px])
    low = np.clip(np.floor(pixels.min(axis=0)).astype(int) - 1, 0, size)
    high = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + 2, 0, size)
    return (slice(low[1], high[1]), slice(low[0], high[0])) if (low < high).all() else None


def spots_shown(scene: Scene, state: Truth) -> frozenset[str]:
    """The switches whose white spot shows."""
    switches = state.switches or {}
    return frozenset(
        spot.switch for spot in scene.spots if switches.get(spot.switch, SwitchState.UNKNOWN) in spot.visible_in
    )


def _empty(switches: dict[str, SwitchState]) -> Truth:
    """A state without vehicles."""
    none = np.empty(0)
    return Truth(0, 0, (), (), _NOTHING, none, _NOTHING, np.empty((0, 2)), switches=switches)
