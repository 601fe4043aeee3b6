"""The wet road as a mirror: what a camera sees in it, and how much of that.

A mirror image is the view of a camera reflected at the road's plane. Water shows Fresnel's share of it (Schlick 1994),
and the grain of the asphalt smears it up and down.
"""

from dataclasses import replace

import cv2
import numpy as np

from contracts import Camera, FloatArray, Pose
from sim.air import Array32, Weather
from sim.mottle import spots
from sim.renderer import Window
from sim.road_scene import KIND_CODES, PartKind
from sim.sight import Sight

_F0 = 0.02  # reflectance of water straight from above
_SHARES = {PartKind.ROAD: 1.0, PartKind.PAINT: 0.75, PartKind.PAVEMENT: 0.45, PartKind.GROUND: 0.03}
_WETNESS = {Weather.WET: (0.62, 0.30), Weather.RAIN: (0.80, 0.20)}  # mean share under water, and its spread
_PUDDLES_M = (0.9, 4.0)
_SMEARS = ((0.45, 0.0016, 0.005), (0.55, 0.0032, 0.036))  # weight, standard deviations u and v in focal lengths
_SMEAR_ENDS = 3.0
_COARSE = 2  # a mirror image is blurred: half of the pixels do
_LOOKED_AT_M = 80.0

DARKER = {PartKind.ROAD: 0.58, PartKind.PAINT: 0.85, PartKind.PAVEMENT: 0.72, PartKind.GROUND: 0.85}
"""Factors on the albedo of what is wet: water keeps light in the pores."""


def is_wet(weather: Weather) -> bool:
    """Whether there is water on the road."""
    return weather in _WETNESS


class Mirror:
    """The wet ground that one camera sees.

    camera: the reflected one, of half the size, whose picture ``smeared`` turns into what the ground shows.
    weights: (H, W, 3) share of the mirror image in what each pixel shows.
    """

    def __init__(self, sight: Sight, weather: Weather, seed: int) -> None:
        self._shape = sight.kinds.shape
        normal, offset_m = _plane(sight)
        self.camera = reflected(coarse(sight.camera), normal, offset_m)
        weights = _wetness(sight, weather, seed) * _fresnel(sight, normal)
        self.weights = np.repeat(weights[..., None], 3, axis=2)
        self._focal_px = self.camera.intrinsics.fx_px

    def grown(self, window: Window) -> Window:
        """All of the reflected camera's picture into which the ground smears this part of it."""
        size = self.camera.intrinsics
        across, along = (round(_SMEAR_ENDS * max(smear[k] for smear in _SMEARS) * self._focal_px) + 2 for k in (1, 2))
        rows, columns = window
        return (
            slice(max(0, rows.start - along), min(size.height_px, rows.stop + along)),
            slice(max(0, columns.start - across), min(size.width_px, columns.stop + across)),
        )

    def smeared(self, picture: Array32) -> Array32:
        """What the ground shows of a picture (h, w, 3) of the reflected camera, or of rows and columns of it."""
        total = np.zeros_like(picture)
        for weight, across, along in _SMEARS:
            sigma = across * self._focal_px, along * self._focal_px
            size = tuple(2 * round(_SMEAR_ENDS * s) + 1 for s in sigma)
            total += weight * cv2.GaussianBlur(
                picture, size, sigma[0], sigmaY=sigma[1], borderType=cv2.BORDER_REPLICATE
            )
        return total

    def in_place(self, smeared: Array32, window: Window | None = None) -> Array32:
        """A smeared picture, or only ``window`` of it, as the camera sees it."""
        large = cv2.resize(smeared[:, ::-1], None, fx=_COARSE, fy=_COARSE, interpolation=cv2.INTER_LINEAR)
        rows, columns = self.window_in_place(_all_of(smeared) if window is None else window)
        return np.asarray(large[: rows.stop - rows.start, : columns.stop - columns.start])

    def window_in_place(self, window: Window) -> Window:
        """Where the camera shows this part of the reflected camera's picture."""
        rows, columns = window
        width = self.camera.intrinsics.width_px
        left, right = _COARSE * (width - columns.stop), _COARSE * (width - columns.start)
        top, bottom = _COARSE * rows.start, _COARSE * rows.stop
        height, full = self._shape
        return slice(min(top, height), min(bottom, height)), slice(min(left, full), min(right, full))

    def laid(self, ground: Array32, picture: Array32, window: Window) -> Array32:
        """The ground (h, w, 3) in a window with the mirror image (h, w, 3) on it."""
        more = picture - ground
        more *= self.weights[window]
        more += ground
        return more


def _all_of(picture: Array32) -> Window:
    return slice(0, picture.shape[0]), slice(0, picture.shape[1])


def coarse(camera: Camera) -> Camera:
    """The same pinhole with half the pixels each way; an odd last row or column is completed."""
    size = camera.intrinsics
    part = replace(
        size,
        width_px=-(-size.width_px // _COARSE),
        height_px=-(-size.height_px // _COARSE),
        fx_px=size.fx_px / _COARSE,
        fy_px=size.fy_px / _COARSE,
        cx_px=(size.cx_px + 0.5) / _COARSE - 0.5,
        cy_px=(size.cy_px + 0.5) / _COARSE - 0.5,
    )
    return replace(camera, intrinsics=part)


def reflected(camera: Camera, normal: FloatArray, offset_m: float) -> Camera:
    """The pinhole that sees, left and right exchanged, what ``camera`` sees in the mirror ``normal . p = offset_m``."""
    turn = camera.pose.world_from_camera
    position = camera.pose.position_m
    across = np.eye(3) - 2.0 * np.outer(normal, normal)
    pose = Pose(across @ turn @ np.diag([-1.0, 1.0, 1.0]), position + 2.0 * (offset_m - normal @ position) * normal)
    size = camera.intrinsics
    return replace(camera, pose=pose, intrinsics=replace(size, cx_px=size.width_px - 1 - size.cx_px))


def schlick(cosine: Array32) -> Array32:
    """Share of the light that water reflects under an angle of incidence with this cosine (Schlick 1994)."""
    return np.asarray(_F0 + (1.0 - _F0) * (1.0 - np.clip(cosine, 0.0, 1.0)) ** 5, np.float32)


def _plane(sight: Sight) -> tuple[FloatArray, float]:
    """Unit normal and offset of the plane through the road nearby, by least squares."""
    road = np.isin(sight.kinds, [KIND_CODES[PartKind.ROAD], KIND_CODES[PartKind.PAINT]])
    points = sight.points_m[road & (sight.range_m < _LOOKED_AT_M)].astype(np.float64)
    if len(points) < 3:
        return np.array([0.0, 0.0, 1.0]), 0.0
    middle = points.mean(axis=0)
    slopes = np.linalg.lstsq(points[:, :2] - middle[:2], points[:, 2] - middle[2], rcond=None)[0]
    normal = np.array([-slopes[0], -slopes[1], 1.0])
    normal /= np.linalg.norm(normal)
    return normal, float(normal @ middle)


def _fresnel(sight: Sight, normal: FloatArray) -> Array32:
    return schlick(-(sight.rays @ normal.astype(np.float32)) / sight.stretch)


def _wetness(sight: Sight, weather: Weather, seed: int) -> Array32:
    """Share of each pixel that is under water, (H, W): in puddles more, where it runs off less."""
    shares = np.zeros(1 + len(KIND_CODES), np.float32)
    for kind, share in _SHARES.items():
        shares[KIND_CODES[kind]] = share
    mean, spread = _WETNESS[weather]
    depth = sum(spots(sight.points_m, sight.pixel_m, spot_m, seed, f"puddles/{spot_m}") for spot_m in _PUDDLES_M)
    return np.asarray(shares[sight.kinds] * np.clip(mean + np.float32(0.7 * spread) * depth, 0.0, 1.0), np.float32)
