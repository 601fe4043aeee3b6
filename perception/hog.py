"""Histograms of oriented gradients: the 31 channels of Felzenszwalb, Girshick, McAllester and Ramanan (TPAMI 2010).

Of each cell: 18 directions, which tell dark on light from light on dark; the same 9 orientations without that; and 4
that say how much of everything there is, by the neighbourhood that normalized it. Their section 6, without the
projection; border cells are kept, the border's blocks and gradients repeat what is inside.
"""

from functools import cache

import numpy as np

from perception.correlation import Float32Array

CELL = 4  # samples along a cell's side
DIRECTIONS = 18
CHANNELS = DIRECTIONS + DIRECTIONS // 2 + 4

_CEILING = 0.2  # of a normalized histogram entry: one strong edge does not drown the rest
_NOTHING = 1e-4  # gradient energy, as in the authors' code: keeps flat blocks finite
_TEXTURE_GAIN = 0.2357  # 1 / sqrt(18), as in the authors' code


def hog(channel: Float32Array) -> Float32Array:
    """(31, H / 4, W / 4) features of a one-channel window (H, W), both sides multiples of 4."""
    histograms = _pooled(_directed(channel))  # (18, h, w)
    half = DIRECTIONS // 2
    orientations = histograms[:half] + histograms[half:]  # (9, h, w)
    scales = _block_scales(np.einsum("chw,chw->hw", orientations, orientations))  # (4, h, w)
    features = np.empty((CHANNELS, *histograms.shape[1:]), np.float32)
    directed = np.minimum(histograms[:, None] * scales, _CEILING)  # (18, 4, h, w)
    features[:DIRECTIONS] = directed.sum(axis=1)
    features[DIRECTIONS:-4] = np.minimum(orientations[:, None] * scales, _CEILING).sum(axis=1)
    features[:-4] *= 0.5
    features[-4:] = directed.sum(axis=0) * _TEXTURE_GAIN
    return features


def _directed(channel: Float32Array) -> Float32Array:
    """(18, H, W) the gradient's length in the map of the direction nearest to it, 0 in the others."""
    around = np.pad(channel, 1, mode="edge")
    du = around[1:-1, 2:] - around[1:-1, :-2]
    dv = around[2:, 1:-1] - around[:-2, 1:-1]
    direction = np.rint(np.arctan2(dv, du) * (DIRECTIONS / (2 * np.pi))).astype(np.int8) % DIRECTIONS  # (H, W)
    chosen = direction == np.arange(DIRECTIONS, dtype=np.int8)[:, None, None]
    return np.asarray(chosen * np.sqrt(du * du + dv * dv), np.float32)


def _pooled(maps: Float32Array) -> Float32Array:
    """(18, h, w) cells of maps (18, H, W); each sample is shared by the four cells whose centres surround it."""
    rows, columns = maps.shape[1:]
    return np.asarray(_sharing(rows) @ (maps @ _sharing(columns).T), np.float32)


@cache
def _sharing(samples: int) -> Float32Array:
    """(cells, samples) share of each sample that each cell along one side gets: linear between the cells' centres."""
    centres = (np.arange(samples // CELL) + 0.5) * CELL - 0.5
    shares = np.maximum(1.0 - np.abs(np.arange(samples) - centres[:, None]) / CELL, 0.0)
    return np.asarray(shares, np.float32)


def _block_scales(energy: Float32Array) -> Float32Array:
    """(4, h, w) one over the gradient energy's root in each of the four blocks of 2 x 2 cells that share a cell."""
    around = np.pad(energy, 1, mode="edge")
    pairs = around[:-1] + around[1:]
    blocks = 1.0 / np.sqrt(pairs[:, :-1] + pairs[:, 1:] + _NOTHING)  # (h + 1, w + 1)
    return np.stack([blocks[1:, 1:], blocks[:-1, 1:], blocks[1:, :-1], blocks[:-1, :-1]])
