"""Bodies of road users: convex, closed, and exactly as large as the truth says."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from sim.bodies import DESIGNS, appearance_of
from sim.body_pieces import Material
from sim.road_users import KINDS

ALL = [design for designs in DESIGNS.values() for design in designs]
VEHICLES = ("city_car", "saloon", "suv", "minivan", "delivery_van", "light_truck", "lorry", "city_bus")
by_name = pytest.mark.parametrize("design", ALL, ids=lambda design: design.name)


def pieces(design):
    return [piece for part in design.parts for piece in part.pieces]


def signed_volume(mesh):
    """By the divergence theorem; positive if the faces look outwards."""
    a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
    return (a * np.cross(b, c)).sum() / 6


def test_every_kind_has_designs_of_its_own_and_cars_have_three():
    assert set(DESIGNS) == set(KINDS)
    assert all(len(designs) >= 2 for designs in DESIGNS.values())
    assert all(len(DESIGNS[kind]) >= 3 for kind in ("city_car", "saloon", "suv"))
    assert len({design.name for design in ALL}) == len(ALL)


@by_name
def test_a_body_touches_all_faces_of_the_unit_box_and_has_one_part_per_material(design):
    corners = np.concatenate([piece.vertices_m for piece in pieces(design)])
    assert np.allclose(corners.min(axis=0), (-0.5, -0.5, 0.0), atol=1e-9, rtol=0)
    assert np.allclose(corners.max(axis=0), (0.5, 0.5, 1.0), atol=1e-9, rtol=0)
    assert len({part.material for part in design.parts}) == len(design.parts)


@by_name
def test_every_piece_is_convex_closed_and_looks_outwards(design):
    for piece in pieces(design):
        hull = ConvexHull(piece.vertices_m)
        assert signed_volume(piece) == pytest.approx(hull.volume, rel=1e-9, abs=1e-12)


@by_name
def test_bodies_stay_cheap_to_draw(design):
    assert sum(len(piece.faces) for piece in pieces(design)) <= 480


@pytest.mark.parametrize("kind", VEHICLES)
def test_wheels_are_round_at_the_kinds_own_size(kind):
    for design in DESIGNS[kind]:
        tyres = next(part for part in design.parts if part.material is Material.TYRE)
        for wheel in tyres.pieces:
            across = np.ptp(wheel.vertices_m, axis=0) * KINDS[kind].size_m
            assert across[0] == pytest.approx(across[2], rel=0.08)  # a decagon is not as wide as it is high
            assert wheel.vertices_m[:, 2].min() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_looks_last_and_differ(kind):
    looks = [appearance_of(kind, f"user/{k}", seed=5) for k in range(60)]
    again = [appearance_of(kind, f"user/{k}", seed=5) for k in range(60)]
    assert [(look.design.name, look.colours) for look in looks] == [(one.design.name, one.colours) for one in again]
    assert len({look.design.name for look in looks}) == len(DESIGNS[kind])
    assert len({(look.design.name, tuple(look.colours.values())) for look in looks}) >= 55
    assert looks[0].colours != appearance_of(kind, "user/0", seed=6).colours
    for look in looks:
        assert set(look.colours) == {part.material for part in look.design.parts}
        assert all(0.0 <= level <= 1.0 for rgb in look.colours.values() for level in rgb)
