from dataclasses import replace

import numpy as np
import pytest

from contracts import FloatArray
from perception.anchor import complete_roof
from perception.colour_models import BOTH, REGIMES, ROUGH, SINGLE, ColourModel
from perception.hue_saturation import SHAPE
from perception.roof import Roof
from perception.view import LocalView

OUTWARD = LocalView(np.diag([500.0, -500.0]), np.array([-1.0, -0.5]))
INWARD = replace(OUTWARD, lean_px=-OUTWARD.lean_px)
MODEL = ColourModel(
    "blue",
    np.ones(SHAPE),
    (0.14, 0.07),
    0.06,
    0.7,
    {BOTH: (0.01, 0.02), SINGLE: (0.25, 0.16), ROUGH: (9.0, 4.0)},
)


def roof(u: tuple[float, float], v: tuple[float, float], *hidden: int) -> Roof:
    """An upright roof between two u and two v; sides: 0 at the lower v, 1 at the higher u, 2, 3."""
    quad = np.array([(u[0], v[0]), (u[1], v[0]), (u[1], v[1]), (u[0], v[1])])
    return Roof(quad, ~np.isin(np.arange(4), hidden), np.zeros(4))


def std_px(cov: FloatArray) -> list[float]:
    return np.sqrt(np.diag(cov)).tolist()


def test_four_measured_sides_give_the_middle():
    anchor = complete_roof(roof((10, 80), (5, 40)), MODEL, OUTWARD)
    assert anchor.regimes == (BOTH, BOTH)
    assert anchor.point_px.tolist() == [45, 22.5]
    assert std_px(anchor.cov_px2) == pytest.approx([0.1, np.sqrt(0.02)])
    assert anchor.visible == 1


@pytest.mark.parametrize(("hidden", "u", "centre_u"), [(1, (10, 60), 45), (3, (30, 80), 45)])
def test_a_hidden_end_follows_from_the_other_and_the_learned_size(hidden, u, centre_u):
    anchor = complete_roof(roof(u, (5, 40), hidden), MODEL, OUTWARD)
    assert anchor.regimes == (SINGLE, BOTH)
    assert anchor.point_px.tolist() == pytest.approx([centre_u, 22.5])
    assert std_px(anchor.cov_px2)[0] == pytest.approx(0.5)
    assert anchor.visible == pytest.approx(50 / 70)


def test_the_measured_axis_tells_the_scale_for_the_other():
    anchor = complete_roof(roof((10, 60), (5, 5 + 35 * 1.02), 1), MODEL, OUTWARD)
    assert anchor.point_px[0] == pytest.approx(10 + 70 * 1.02 / 2)


def test_half_a_roof_is_not_taken_for_one_that_lies_across():
    half = roof((10, 44), (5, 40), 1)  # 34 px of its 70 are in the image: its long side is the shorter one there
    for named in (half, half.turned()):
        anchor = complete_roof(named, MODEL, OUTWARD)
        assert anchor.point_px.tolist() == pytest.approx([45, 22.5])
        assert std_px(anchor.cov_px2) == pytest.approx([0.5, np.sqrt(0.02)])


@pytest.mark.parametrize("scale", [0.92, 1.08])
def test_a_camera_that_hangs_lower_or_higher_sees_a_whole_roof(scale):
    anchor = complete_roof(roof((10, 10 + 70 * scale), (5, 5 + 35 * scale)), MODEL, OUTWARD)
    assert anchor.regimes == (BOTH, BOTH)
    assert anchor.visible == pytest.approx(1)


def test_a_roof_too_long_ends_in_a_wall_on_the_inner_side():
    anchor = complete_roof(roof((10, 95), (5, 40)), MODEL, OUTWARD)
    assert anchor.regimes == (SINGLE, BOTH)
    assert anchor.point_px[0] == pytest.approx(95 - 35)
    mirrored = complete_roof(roof((10, 95), (5, 40)), MODEL, INWARD)
    assert mirrored.point_px[0] == pytest.approx(10 + 35)


def test_a_roof_too_short_is_covered_nobody_knows_where_and_says_so():
    anchor = complete_roof(roof((10, 60), (5, 40)), MODEL, OUTWARD)
    assert anchor.point_px[0] == pytest.approx(35)
    assert std_px(anchor.cov_px2)[0] > 10
    assert anchor.visible < 0.75


def test_no_measured_end_leaves_the_rough_place():
    anchor = complete_roof(roof((10, 80), (5, 40), 1, 3), MODEL, OUTWARD)
    assert anchor.regimes == (ROUGH, BOTH)
    assert std_px(anchor.cov_px2)[0] == pytest.approx(3)


def test_the_covariance_turns_with_the_roof():
    upright = roof((-35, 35), (-17.5, 17.5))
    turn = np.array([(0.0, -1.0), (1.0, 0.0)])
    turned = complete_roof(replace(upright, quad_px=upright.quad_px @ turn.T), MODEL, OUTWARD)
    assert std_px(turned.cov_px2) == pytest.approx([np.sqrt(0.02), 0.1])
    assert set(MODEL.anchor_moments_px2) == set(REGIMES)
