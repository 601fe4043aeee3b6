"""Felzenszwalb's features, held to a slow version that says what they are."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from perception.hog import CELL, CHANNELS, hog


def slow_hog(channel):
    rows, columns = channel.shape
    h, w = rows // CELL, columns // CELL
    histograms = np.zeros((h, w, 18))
    at = lambda v, u: float(channel[np.clip(v, 0, rows - 1), np.clip(u, 0, columns - 1)])  # noqa: E731
    for v in range(rows):
        for u in range(columns):
            du, dv = at(v, u + 1) - at(v, u - 1), at(v + 1, u) - at(v - 1, u)
            towards = [du * np.cos(k * np.pi / 9) + dv * np.sin(k * np.pi / 9) for k in range(18)]
            length, y, x = np.hypot(du, dv), (v + 0.5) / CELL - 0.5, (u + 0.5) / CELL - 0.5
            for row in (int(np.floor(y)), int(np.floor(y)) + 1):
                for column in (int(np.floor(x)), int(np.floor(x)) + 1):
                    if 0 <= row < h and 0 <= column < w:
                        share = (1 - abs(y - row)) * (1 - abs(x - column))
                        histograms[row, column, int(np.argmax(towards))] += share * length
    energy = ((histograms[..., :9] + histograms[..., 9:]) ** 2).sum(axis=2)
    of = lambda row, column: energy[np.clip(row, 0, h - 1), np.clip(column, 0, w - 1)]  # noqa: E731
    features = np.zeros((CHANNELS, h, w))
    for row in range(h):
        for column in range(w):
            cell = histograms[row, column]
            for k, (down, right) in enumerate([(1, 1), (-1, 1), (1, -1), (-1, -1)]):
                corners = [(row, column), (row + down, column), (row, column + right), (row + down, column + right)]
                scale = 1 / np.sqrt(sum(of(*corner) for corner in corners) + 1e-4)
                directed = np.minimum(cell * scale, 0.2)
                features[:18, row, column] += directed / 2
                features[18:27, row, column] += np.minimum((cell[:9] + cell[9:]) * scale, 0.2) / 2
                features[27 + k, row, column] = directed.sum() * 0.2357
    return features


def texture(seed, shape):
    return np.random.default_rng(seed).normal(100, 30, shape).astype(np.float32)


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([8, 12, 16]), st.sampled_from([8, 20]))
def test_features_equal_the_slow_version(seed, rows, columns):
    window = texture(seed, (rows, columns))
    np.testing.assert_allclose(hog(window), slow_hog(window), rtol=0, atol=1e-4)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.5, 3.0), st.floats(-50, 50))
def test_brightness_and_contrast_leave_them_as_they_are(seed, gain, offset):
    window = texture(seed, (16, 24))
    np.testing.assert_allclose(hog((gain * window + offset).astype(np.float32)), hog(window), rtol=0, atol=2e-3)


def test_a_negative_exchanges_opposite_directions_and_nothing_else():
    window = texture(5, (16, 24))
    positive, negative = hog(window), hog(-window)
    np.testing.assert_allclose(negative[:9], positive[9:18], rtol=0, atol=1e-6)
    np.testing.assert_allclose(negative[18:], positive[18:], rtol=0, atol=1e-6)


def test_a_shift_by_whole_cells_moves_the_features_by_cells():
    window = texture(6, (32, 48))
    moved = hog(np.roll(window, (CELL, 2 * CELL), axis=(0, 1)))
    np.testing.assert_allclose(
        moved[:, 3:-2, 4:-2], np.roll(hog(window), (1, 2), axis=(1, 2))[:, 3:-2, 4:-2], atol=1e-6
    )


def test_a_vertical_edge_shows_in_its_direction_and_a_flat_window_in_none():
    window = np.zeros((16, 16), np.float32)
    assert not hog(window).any()
    window[:, 8:] = 100.0
    features = hog(window)
    assert features[0].max() > 0.3
    assert not features[1:18].any()
