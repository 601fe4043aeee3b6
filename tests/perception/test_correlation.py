"""Laws of the correlation filter's parts, held to direct sums and an explicit kernel matrix."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from perception import correlation as cor

EVEN = st.sampled_from([4, 6, 8, 10])
SEEDS = st.integers(0, 2**32 - 1)
BANDWIDTH, RIDGE = 0.7, 1e-2


def window(rng, shape):
    return rng.normal(size=shape).astype(np.float32)


def shifts(shape):
    return [(v, u) for v in range(shape[0]) for u in range(shape[1])]


def moved(array, shift):
    return np.roll(array, shift, axis=(-2, -1))


def energy(*windows):
    return float(sum((w.astype(np.float64) ** 2).sum() for w in windows))


def kernel(of, by):
    cross = cor.cross_correlation(cor.spectrum(of), cor.spectrum(by))
    return cor.gaussian_kernel(cross, energy(of, by), BANDWIDTH, of.size)


def direct_kernel(a, b):
    return np.exp(-((a.astype(np.float64) - b) ** 2).sum() / (BANDWIDTH**2 * a.size))


@settings(max_examples=15, deadline=None)
@given(SEEDS, EVEN, EVEN)
def test_answer_equals_ridge_regression_with_the_kernel_matrix_over_all_cyclic_shifts(seed, height, width):
    rng, shape = np.random.default_rng(seed), (height, width)
    learned, seen = window(rng, shape), window(rng, shape)
    target = cor.gaussian_target(shape, 1.0)
    samples = [moved(learned, s) for s in shifts(shape)]
    matrix = np.array([[direct_kernel(a, b) for b in samples] for a in samples])
    goals = np.array([target[v - height // 2, u - width // 2] for v, u in shifts(shape)], np.float64)
    alpha = np.linalg.solve(matrix + RIDGE * np.eye(len(samples)), goals)
    expected = np.zeros(shape)
    for v, u in shifts(shape):
        back = moved(seen, (-v, -u))
        answer = alpha @ [direct_kernel(back, sample) for sample in samples]
        expected[(v + height // 2) % height, (u + width // 2) % width] = answer

    alpha_f = cor.train(kernel(learned, learned), cor.spectrum(target), cor.ridge_spectrum(shape, RIDGE))
    np.testing.assert_allclose(cor.respond(kernel(seen, learned), alpha_f), expected, rtol=0, atol=2e-4)


@settings(max_examples=25, deadline=None)
@given(SEEDS, st.integers(-16, 15), st.integers(-8, 7))
def test_a_shift_by_whole_samples_moves_the_peak_by_exactly_that(seed, u, v):
    rng, shape = np.random.default_rng(seed), (16, 32)
    learned = window(rng, shape)
    alpha_f = cor.train(
        kernel(learned, learned), cor.spectrum(cor.gaussian_target(shape, 1.5)), cor.ridge_spectrum(shape, RIDGE)
    )
    peak = cor.find_peak(cor.respond(kernel(moved(learned, (v, u)), learned), alpha_f))
    np.testing.assert_allclose(peak.shift, (u, v), rtol=0, atol=1e-3)
    assert peak.height == pytest.approx(1.0, abs=0.02)


@settings(max_examples=25, deadline=None)
@given(SEEDS, EVEN, EVEN)
def test_cross_correlation_equals_the_direct_sum_in_both_transforms(seed, height, width):
    rng, shape = np.random.default_rng(seed), (height, width)
    a, b = window(rng, (3, *shape)), window(rng, (3, *shape))
    expected = np.array([(moved(a, (-v, -u)) * b).sum(axis=(1, 2)) for v, u in shifts(shape)])  # (H * W, 3)
    packed = [cor.cross_correlation(cor.spectrum(x), cor.spectrum(y)).ravel() for x, y in zip(a, b, strict=True)]
    np.testing.assert_allclose(np.array(packed).T, expected, rtol=0, atol=1e-4)
    summed = cor.channel_correlation(cor.spectra(a), cor.spectra(b), shape)
    np.testing.assert_allclose(summed.ravel(), expected.sum(axis=1), rtol=0, atol=2e-4)


@settings(max_examples=25, deadline=None)
@given(SEEDS, EVEN, EVEN, st.floats(-3, 3), st.floats(-3, 3))
def test_cross_correlation_is_linear_and_turns_round_when_its_arguments_are_exchanged(seed, height, width, p, q):
    rng, shape = np.random.default_rng(seed), (height, width)
    a, b, c = (window(rng, shape) for _ in range(3))
    mixed = (p * a + q * b).astype(np.float32)
    cross = lambda x, y: cor.cross_correlation(cor.spectrum(x), cor.spectrum(y))  # noqa: E731
    np.testing.assert_allclose(cross(mixed, c), p * cross(a, c) + q * cross(b, c), rtol=0, atol=1e-3)
    turned = moved(cross(b, a)[::-1, ::-1], (1, 1))
    np.testing.assert_allclose(cross(a, b), turned, rtol=0, atol=1e-4)


def test_inverse_undoes_the_spectrum(rng):
    a = window(rng, (16, 30))
    np.testing.assert_allclose(cor.inverse(cor.spectrum(a)), a, rtol=0, atol=1e-5)


@settings(max_examples=50, deadline=None)
@given(st.floats(-10, 10), st.floats(-5, 5), st.floats(1.0, 3.0))
def test_the_fraction_of_a_sample_is_exact_for_a_gaussian(u, v, sigma):
    y, x = np.mgrid[:32, :48].astype(np.float64)
    response = np.exp(-((x - 24 - u) ** 2 + (y - 16 - v) ** 2) / (2 * sigma**2)).astype(np.float32)
    np.testing.assert_allclose(cor.find_peak(response).shift, (u, v), rtol=0, atol=1e-3)


def test_a_peak_on_the_border_sees_its_neighbours_on_the_other_side():
    response = np.zeros((8, 8), np.float32)
    response[0, 0], response[-1, 0], response[1, 0], response[0, 1], response[0, -1] = 1.0, 0.5, 0.5, 0.7, 0.5
    shift = cor.find_peak(response).shift
    assert shift[1] == -4.0
    assert -4.0 < shift[0] < -3.5


def test_side_lobe_ratio_counts_deviations_above_the_mean_of_all_but_the_peak(rng):
    response = rng.normal(0.1, 0.02, (64, 64)).astype(np.float32)
    response[20:31, 30:41] = 0.6
    response[25, 35] = 1.1
    assert cor.find_peak(response).sharpness == pytest.approx(1.0 / 0.02, rel=0.05)


def test_a_flat_response_has_no_peak_to_speak_of():
    peak = cor.find_peak(np.full((16, 16), 0.3, np.float32))
    assert peak.sharpness == pytest.approx(0.0, abs=1e-2)
    assert cor.side_lobe_ratio(np.ones((4, 4), np.float32), (2, 2), 1.0) == 0.0
