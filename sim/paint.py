"""Colours of box faces under a light, and of pixels that several samples share."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray
from contracts.truth import Truth
from sim.box_rays import Array32, Box
from sim.colours import Colour
from sim.lights import Light

FACES = 3  # of a box, at most, a camera sees; one per axis


def paint_table(state: Truth, boxes: Sequence[Box], light: Light, camera: Camera) -> Array32:
    """Colours (1 + FACES N, 2^B, 3) BGR by owner and by the bits of the beams that are kept away; zero for owner 0.

    Each light's part is rounded by itself, as the graphics hardware adds them up.
    """
    dark_of = np.arange(1 << len(light.beams))  # (2^B,)
    table = np.zeros((1 + FACES * len(boxes), len(dark_of), 3))
    for row, box in enumerate(boxes):
        albedo = np.array(Colour(state.labels[row]).srgb[::-1]) * light.factor  # BGR, 255 for white
        towards_camera = np.where(box.world_from_box.T @ (camera.pose.position_m - box.centre_m) > 0, 1.0, -1.0)
        normals = (box.world_from_box * towards_camera).T  # (FACES, 3) world
        parts = slice(1 + FACES * row, 1 + FACES * (row + 1))
        upward = np.maximum(normals[:, 2:], 0.0)
        base = np.rint(albedo * (np.array(light.ambient[::-1]) + upward * np.array(light.sky[::-1])))  # (FACES, 3)
        table[parts] = base[:, None]
        for bit, beam in enumerate(light.beams):
            facing = np.maximum(normals @ -beam.direction, 0.0)[:, None]
            reaches = (dark_of >> bit & 1 == 0)[:, None]  # (2^B, 1)
            table[parts] += np.rint(albedo * facing * np.array(beam.rgb[::-1]))[:, None] * reaches
    return np.minimum(table, 255.0).astype(np.float32)


def mean_of_samples(
    owner: NDArray[np.uint16],
    shade: NDArray[np.uint8],
    *,
    scene: ImageArray,
    shares: Sequence[ImageArray],
    table: Array32,
    factor: float,
) -> Array32:
    """Colours (h, w, 3) of pixels whose samples (S, h, w) show the scene (owner 0) or faces of the paint table.

    scene: (h, w, 3) under all the light that there is; shares: what of it each beam brings, by bit of ``shade``.
    """
    code = owner * np.uint16(table.shape[1]) + shade
    touched = np.nonzero(code.any(axis=0))  # (T,) pixels; all others show nothing but the scene
    image = scene * np.float32(factor)
    samples = code[:, touched[0], touched[1]]  # (S, T)
    free, bits = samples < table.shape[1], samples % np.uint16(table.shape[1])
    colour = table.reshape(-1, 3).take(samples, axis=0).sum(axis=0)  # (T, 3)
    colour += free.sum(axis=0, dtype=np.float32)[:, None] * image[touched]
    for bit, share in enumerate(shares):
        dark = (free & (bits >> bit & 1 == 1)).sum(axis=0, dtype=np.float32)
        colour -= dark[:, None] * share[touched] * np.float32(factor)
    image[touched] = colour / np.float32(len(owner))
    return image
