import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d
from slow_edge_fit import slow_fit_edges

from contracts import FloatArray
from perception.edge_profile import BLUR_PX, EdgeFits, fit_edges
from perception.roof import WALL_EVIDENCE

T_PX = np.arange(-6.0, 6.5)
FINE = 40  # samples per pixel of the profile before it is blurred
ROOF, FLOOR = np.array([190.0, 70.0, 25.0]), np.array([118.0, 122.0, 126.0])


def profile(edge_px: float, wall_px: float = 0.0, shade: float = 0.5, blur_px: float = BLUR_PX) -> FloatArray:
    """(T, 3) colours across an edge, by numerical convolution; no code of the model's."""
    fine = (np.arange(-20 * FINE, 20 * FINE) + 0.5) / FINE
    on_roof, on_vehicle = (np.clip((end - fine) * FINE + 0.5, 0, 1)[:, None] for end in (edge_px, edge_px + wall_px))
    levels = FLOOR + on_roof * (ROOF - shade * ROOF) + on_vehicle * (shade * ROOF - FLOOR)
    blurred = gaussian_filter1d(levels, blur_px * FINE, axis=0)
    return np.stack([np.interp(T_PX, fine, channel) for channel in blurred.T], axis=1)


def believed_edges_px(fits: EdgeFits) -> FloatArray:
    """(S,) of the model, with or without a wall, that ``roof`` believes."""
    return np.where(fits.costs[0] - fits.costs[1] > WALL_EVIDENCE, fits.edges_px[1], fits.edges_px[0])


@given(st.floats(-1.5, 1.5))
def test_a_plain_edge_is_found_where_it_is(edge_px):
    fits = fit_edges(profile(edge_px)[None], T_PX)
    assert abs(fits.edges_px[0, 0] - edge_px) < 0.01


@given(st.floats(-1.0, 1.0), st.floats(1.5, 20.0), st.floats(0.25, 0.65))
def test_the_roof_ends_before_a_wall_however_wide(edge_px, wall_px, shade):
    fits = fit_edges(profile(edge_px, wall_px, shade)[None], T_PX)
    assert abs(believed_edges_px(fits)[0] - edge_px) < 0.1


@given(st.floats(-1.0, 1.0), st.floats(0.0, 1.5), st.floats(0.25, 0.65))
def test_a_wall_narrower_than_the_blur_pulls_the_edge_by_a_fraction_of_itself(edge_px, wall_px, shade):
    fits = fit_edges(profile(edge_px, wall_px, shade)[None], T_PX)
    assert abs(fits.edges_px[1, 0] - edge_px) < 0.25


@given(st.floats(-1.0, 1.0), st.floats(1.0, 4.0))
def test_a_wall_is_told_from_its_absence_by_the_fit(edge_px, wall_px):
    walled = fit_edges(profile(edge_px, wall_px)[None], T_PX)
    plain = fit_edges(profile(edge_px)[None], T_PX)
    assert walled.costs[1, 0] < walled.costs[0, 0]
    assert plain.costs[0, 0] < walled.costs[0, 0]


@given(st.floats(-0.5, 0.5), st.floats(0.55, 1.1))
def test_another_blur_than_the_models_hardly_moves_a_plain_edge(edge_px, blur_px):
    fits = fit_edges(profile(edge_px, blur_px=blur_px)[None], T_PX)
    assert abs(fits.edges_px[0, 0] - edge_px) < 0.08


def test_profiles_are_fitted_independently():
    profiles = np.stack([profile(0.4), profile(-0.7, 3.0), profile(0.0, 1.5)])
    together = fit_edges(profiles, T_PX)
    for k in range(3):
        alone = fit_edges(profiles[k : k + 1], T_PX)
        assert np.abs(alone.edges_px[:, 0] - together.edges_px[:, k]).max() < 1e-9


@given(st.integers(0, 2**31), st.sampled_from([0.0, 0.5, 1.5, 3.0, 6.0]), st.booleans())
@settings(max_examples=25, deadline=None)
def test_the_fast_fit_ends_where_the_slow_one_does(seed, wall_px, wall_known):
    rng = np.random.default_rng(seed)
    drawn = [profile(rng.uniform(-1, 1), wall_px * rng.uniform(0.8, 1.2), rng.uniform(0.25, 0.75)) for _ in range(4)]
    profiles = np.array(drawn) + rng.normal(0, 0.4, (4, len(T_PX), 3))
    fast = fit_edges(profiles, T_PX, np.full(4, wall_px) if wall_known else None)
    slow = slow_fit_edges(profiles, T_PX)
    assert np.abs(believed_edges_px(fast) - believed_edges_px(slow)).max() < 0.02
