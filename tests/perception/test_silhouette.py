import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import FloatArray, ImageArray
from perception.silhouette import ShapeGates, Silhouette, silhouette_in

OPEN = ShapeGates((1.0, 1e9), (1e-9, 1.0), 0.0)
ORIGIN = np.array([300, 200])


def block(angle_rad: float = 0.0, size: tuple[float, float] = (60.0, 30.0), shape=(120, 140)) -> ImageArray:
    """(H, W) 1 in a rotated rectangle in the middle."""
    v, u = np.indices(shape) - (np.array(shape)[:, None, None] - 1) / 2
    along, across = u * np.cos(angle_rad) + v * np.sin(angle_rad), v * np.cos(angle_rad) - u * np.sin(angle_rad)
    return ((np.abs(along) <= size[0] / 2) & (np.abs(across) <= size[1] / 2)).astype(np.uint8)


def outline(raw: ImageArray, gates: ShapeGates = OPEN) -> Silhouette | None:
    return silhouette_in(raw, ORIGIN, gates)


@given(st.floats(-1.6, 1.6))
@settings(max_examples=20, deadline=None)
def test_a_whole_rectangle_is_rectangular_however_it_lies(angle_rad):
    found = outline(block(angle_rad))
    assert found is not None
    assert found.rectangularity > 0.94
    assert abs(found.side_ratio - 0.5) < 0.03
    middle: FloatArray = ORIGIN + np.array([139, 119]) / 2
    assert np.abs(found.quad_px.mean(axis=0) - middle).max() < 0.75


def test_nothing_is_filled_in_what_is_measured():
    raw, whole = block(), outline(block())
    raw[50:70, 60:80] = 0
    found = outline(raw)
    assert found is not None
    assert whole is not None
    assert found.fill == whole.fill
    width, height = whole.rectangle[1]
    assert (whole.rectangularity - found.rectangularity) * width * height == pytest.approx(400)


def test_specks_beside_the_vehicle_do_not_count():
    raw, whole = block(), outline(block())
    raw[5, 5] = raw[100:110, 5:15] = 1
    found = outline(raw)
    assert found is not None
    assert whole is not None
    assert (found.raw == whole.raw).all()


@pytest.mark.parametrize(
    "gates",
    [
        ShapeGates((1.0, 1000.0), (0.1, 1.0), 0.5),
        ShapeGates((3000.0, 9000.0), (0.1, 1.0), 0.5),
        ShapeGates((1.0, 9000.0), (0.8, 1.0), 0.5),
        ShapeGates((1.0, 9000.0), (0.1, 0.3), 0.5),
    ],
)
def test_what_is_too_large_too_small_too_long_or_too_square_is_refused(gates):
    assert outline(block(), gates) is None


def test_what_hardly_fills_its_rectangle_is_refused():
    cross = np.maximum(block(0.0, (80.0, 10.0)), block(np.pi / 2, (80.0, 10.0)))
    assert outline(cross, ShapeGates((1.0, 9000.0), (0.1, 1.0), 0.5)) is None
    assert outline(cross) is not None


def test_an_empty_mask_has_no_outline():
    assert outline(np.zeros((40, 50), np.uint8)) is None
