import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from perception.patches import Crop, WindowShape, cosine_window, to_image


def noise(rng, shape=(90, 120)):
    return rng.integers(0, 256, (*shape, 3), np.uint8)


def ramp(shape=(200, 240)):
    """Brightness that says where a pixel is: u / 2 in blue, v in green."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    return np.dstack([u // 2 * 2 / 2, v, 0 * u]).astype(np.uint8)


def cut(image, centre, angle, shape):
    return Crop.around(image, np.array(centre), shape.reach_px, shape.step_px).window(np.array(centre), angle, shape)


def test_an_upright_window_of_every_pixel_is_a_slice(rng):
    image = noise(rng)
    window = cut(image, (50.5, 40.5), 0.0, WindowShape((20, 30), 1.0))
    np.testing.assert_array_equal(window, image[31:51, 36:66])


def test_a_quarter_turn_looks_down_the_image(rng):
    image = noise(rng)
    window = cut(image, (50.5, 40.5), np.pi / 2, WindowShape((20, 30), 1.0))
    np.testing.assert_array_equal(window, np.rot90(image[26:56, 41:61], 1))


@settings(max_examples=40, deadline=None)
@given(st.floats(-np.pi, np.pi), st.floats(90, 140), st.floats(80, 120), st.sampled_from([1.0, 1.7, 2.3, 4.2]))
def test_samples_lie_where_the_shape_says(angle, u, v, step):
    shape = WindowShape((8, 12), step)
    window = cut(ramp(), (u, v), angle, shape).astype(np.float64)
    for row, column in ((0, 0), (7, 11), (3, 8)):
        place = to_image((column - 5.5, row - 3.5), angle, step) + np.array([u, v])
        assert 2 * window[row, column, 0] == pytest.approx(place[0], abs=2.1)  # blue counts pairs of columns
        assert window[row, column, 1] == pytest.approx(place[1], abs=1.1)


def test_beyond_the_image_its_border_goes_on(rng):
    image = noise(rng)
    window = cut(image, (-0.5, 40.5), 0.0, WindowShape((4, 8), 1.0))
    np.testing.assert_array_equal(window[:, :4], np.repeat(image[39:43, :1], 4, axis=1))
    for centre in ((-900.0, 50.0), (50.0, 4000.0)):
        assert cut(image, centre, 0.3, WindowShape((4, 8), 3.0)).shape == (4, 8, 3)


def test_coarse_sampling_averages(rng):
    window = cut(noise(rng, (400, 400)), (200.0, 200.0), 0.2, WindowShape((32, 32), 8.0))
    assert window.std() < 20  # of noise with a deviation of 74


def test_a_crop_knows_what_it_covers(rng):
    crop = Crop.around(noise(rng), np.array([50.0, 40.0]), 20.0, 1.0)
    assert crop.covers(np.array([53.0, 44.0]), 15.0)
    assert not crop.covers(np.array([53.0, 44.0]), 15.1)


@settings(max_examples=40, deadline=None)
@given(st.floats(5, 300), st.floats(5, 300), st.integers(256, 16384), st.sampled_from([2, 8]))
def test_window_shapes_keep_the_padding_and_transform_fast(along, across, budget, multiple):
    shape = WindowShape.around((along, across), padding=2.0, budget=budget, multiple_of=multiple)
    for samples, side in zip(shape.samples, (across, along), strict=True):
        assert samples % multiple == 0
        rest = samples // multiple
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        assert rest == 1
        assert samples * shape.step_px >= 2.0 * side - multiple * shape.step_px


def test_distance_is_one_on_the_outline():
    distance = WindowShape((20, 40), 2.0).distance((38.0, 18.0))
    assert distance[0, 20] == pytest.approx(19 / 9)
    assert distance[10, 10] == pytest.approx(1.0)


def test_cosine_window_is_symmetric_and_fades():
    fade = cosine_window((16, 32))
    np.testing.assert_allclose(fade, fade[::-1, ::-1], atol=1e-7)
    assert fade[0].max() < 0.04
    assert fade.max() > 0.98
