"""Colours of box faces under a light, and of pixels that several samples share."""

from collections.abc import Sequence

import cv2
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
    if not boxes:
        return table.astype(np.float32)
    albedo = light.factor * np.array(
        [Colour(label).srgb[::-1] for label in state.labels], np.float64
    )  # BGR, 255: white
    albedo = albedo.repeat(FACES, axis=0)  # (FACES N, 3)
    turns = np.stack([box.world_from_box for box in boxes])  # (N, 3, 3)
    eyes = camera.pose.position_m - np.stack([box.centre_m for box in boxes])
    towards_camera = np.where(np.einsum("nij,ni->nj", turns, eyes) > 0, 1.0, -1.0)
    normals = (turns * towards_camera[:, None]).transpose(0, 2, 1).reshape(-1, 3)  # (FACES N, 3) world
    upward = np.maximum(normals[:, 2:], 0.0)
    table[1:] = np.rint(albedo * (np.array(light.ambient[::-1]) + upward * np.array(light.sky[::-1])))[:, None]
    for bit, beam in enumerate(light.beams):
        facing = np.maximum(normals @ -beam.direction, 0.0)[:, None]
        reaches = (dark_of >> bit & 1 == 0)[:, None]  # (2^B, 1)
        table[1:] += np.rint(albedo * facing * np.array(beam.rgb[::-1]))[:, None] * reaches
    return np.minimum(table, 255.0).astype(np.float32)


def darkened(lit: ImageArray, shares: Sequence[ImageArray]) -> list[ImageArray]:
    """A picture without some of its beams, by the bits of those that are kept away; ``shares``: what each brings."""
    pictures = [lit]
    for share in shares:
        pictures += [np.asarray(cv2.subtract(picture, share), np.uint8) for picture in pictures]
    return pictures


def painted(
    code: NDArray[np.uint16],
    scene: Sequence[ImageArray],
    table: Array32,
    *,
    edge: NDArray[np.int32],
    shares: Array32,
) -> ImageArray:
    """Colours (h, w, 3) of pixels whose samples (S, h, w) show the scene or faces; the mean of the samples.

    code: owner times 2^B plus the bits of the beams that are kept away. scene: the scene's picture for all such bits.
    edge (h, w), shares: the relation of a sample's colour to its pixel's in the scene, see ``sim.backdrop.Surfaces``.
    """
    colours, combinations = table.reshape(-1, 3), table.shape[1]
    image = scene[0].copy()
    first = code[0]
    alike = (code[1:] == first).all(axis=0)
    for bits in range(1, combinations):
        cv2.copyTo(scene[bits], (alike & (first == bits)).view(np.uint8), image)
    faces = colours.astype(np.uint8).take(first, axis=0)
    cv2.copyTo(faces, (alike & (first >= combinations)).view(np.uint8), image)
    mixed = np.flatnonzero(~alike)  # (M,) pixels
    samples = code.reshape(len(code), -1)[:, mixed]  # (S, M)
    total = colours.take(samples, axis=0).sum(axis=0)  # (M, 3)
    relation = shares[edge.reshape(-1)[mixed]]  # (M, S, 3)
    for bits, picture in enumerate(scene):
        shown = np.einsum("sm,msk->mk", (samples == bits).astype(np.float32), relation)
        total += shown * picture.reshape(-1, 3)[mixed]
    image.reshape(-1, 3)[mixed] = np.rint(np.minimum(total / np.float32(len(code)), 255.0))
    return image
