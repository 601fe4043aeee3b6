import cv2
import numpy as np

from perception.hue_saturation import SHAPE, back_projection, histogram, hue_saturation_value, widened


def hsv_noise(seed: int = 0) -> np.ndarray:
    return hue_saturation_value(np.random.default_rng(seed).integers(0, 256, (40, 60, 3), np.uint8))


def test_every_pixel_falls_into_exactly_one_bin():
    hsv = hsv_noise()
    counts = np.zeros(SHAPE)
    np.add.at(counts, (hsv[..., 0] // 2, hsv[..., 1] // 8), 1)
    assert (histogram(hsv) == counts).all()


def test_back_projection_is_the_ratio_of_each_pixels_bin():
    hsv = hsv_noise()
    ratio = np.random.default_rng(1).random(SHAPE)
    expected = ratio[hsv[..., 0] // 2, hsv[..., 1] // 8] * 255
    assert np.abs(back_projection(hsv, ratio) - expected).max() <= 0.51


def test_widening_goes_round_the_circle_of_hue():
    counts = np.zeros(SHAPE)
    counts[0, 10] = 7
    wide = widened(counts)
    assert wide[[0, 1, -1], 9:12].min() == 7
    assert wide.sum() == 9 * 7


def test_shading_moves_no_colour_far_in_hue_and_saturation():
    paint = np.full((1, 1, 3), (190, 70, 25), np.uint8)
    shaded = (paint * 0.6).round().astype(np.uint8)
    difference = cv2.absdiff(hue_saturation_value(paint), hue_saturation_value(shaded))[0, 0, :2]
    assert difference.max() <= 2
