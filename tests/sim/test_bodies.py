"""Bodies of road users: convex, closed, and exactly as large as the truth says."""

from dataclasses import replace

import numpy as np
import pytest
from road_film_cases import users
from scipy.spatial import ConvexHull

from sim.bodies import BUILDERS, DESIGNS, appearance_of
from sim.body_pieces import Material
from sim.body_shapes import Wardrobe
from sim.road_users import KINDS

ALL = [design for designs in DESIGNS.values() for design in designs]
SYMMETRIC = ("city_car", "saloon", "suv", "minivan", "delivery_van", "light_truck", "lorry")  # a bus has doors
WHEELED = (*SYMMETRIC, "city_bus", "bicycle", "motorcycle", "robot")
by_name = pytest.mark.parametrize("design", ALL, ids=lambda design: design.name)


def pieces(design):
    return [piece for part in design.parts for piece in part.pieces]


def signed_volume(mesh):
    """By the divergence theorem; positive if the faces look outwards."""
    a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
    return (a * np.cross(b, c)).sum() / 6


def areas(mesh):
    """Area vectors (F, 3): they sum to zero over a closed surface."""
    a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def part_of(design, material):
    return next(part for part in design.parts if part.material is material)


def in_order(points):
    return np.unique(points.round(9) + 0.0, axis=0)


def test_every_kind_has_designs_of_its_own_and_cars_have_three():
    assert set(DESIGNS) == set(KINDS)
    assert all(len(designs) >= 2 for designs in DESIGNS.values())
    assert all(len(DESIGNS[kind]) >= 3 for kind in ("city_car", "saloon", "suv"))
    assert len({design.name for design in ALL}) == len(ALL)


@by_name
def test_a_body_touches_all_faces_of_the_unit_box_and_has_one_still_part_per_material(design):
    corners = np.concatenate([piece.vertices_m for piece in pieces(design)])
    assert np.allclose(corners.min(axis=0), (-0.5, -0.5, 0.0), atol=1e-9, rtol=0)
    assert np.allclose(corners.max(axis=0), (0.5, 0.5, 1.0), atol=1e-9, rtol=0)
    still = [part.material for part in design.parts if part.bone is None]
    assert len(set(still)) == len(still)
    assert len(design.parts) <= 24  # for so many the stage has room


@by_name
def test_every_piece_is_convex_closed_and_looks_outwards(design):
    for piece in pieces(design):
        hull = ConvexHull(piece.vertices_m)
        assert signed_volume(piece) == pytest.approx(hull.volume, rel=1e-9, abs=1e-12)
        assert np.allclose(areas(piece).sum(axis=0), 0.0, atol=1e-12, rtol=0)  # nothing is missing


@by_name
def test_bodies_stay_cheap_to_draw(design):
    assert len(pieces(design)) <= 30
    assert sum(len(piece.faces) for piece in pieces(design)) <= 460


@pytest.mark.parametrize("kind", WHEELED)
def test_wheels_stand_on_the_ground_and_are_round_at_the_kinds_own_size(kind):
    for design in DESIGNS[kind]:
        for wheel in part_of(design, Material.TYRE).pieces:
            across = np.ptp(wheel.vertices_m, axis=0) * KINDS[kind].size_m
            assert across[0] == pytest.approx(across[2], rel=0.03)
            assert wheel.vertices_m[:, 2].min() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_designs_have_the_size_of_their_kind_before_they_are_made_to_fit(kind):
    for name, build in BUILDERS[kind].items():
        corners = np.concatenate([piece.mesh.vertices_m for piece in build(KINDS[kind].size_m)])
        assert np.ptp(corners, axis=0) == pytest.approx(KINDS[kind].size_m, rel=0.03), name
        assert corners[:, 2].min() == pytest.approx(0.0, abs=0.01), name


@pytest.mark.parametrize("kind", SYMMETRIC)
def test_left_mirrors_right_but_for_the_cargo(kind):
    for design in DESIGNS[kind]:
        for part in design.parts:
            if part.material is not Material.CARGO:
                corners = part.mesh.vertices_m
                assert np.allclose(in_order(corners), in_order(corners * (1, -1, 1)), atol=1e-9, rtol=0)


def test_pieces_stand_where_the_user_is():
    size, heading, position = np.array([4.9, 1.9, 1.5]), 0.7, np.array([3.0, -2.0, 0.4])
    state = replace(users(("saloon", 3.0, -2.0, 0.0)), sizes_m=size[None], headings_rad=np.array([heading]))
    state = replace(state, positions_m=position[None])
    corners = np.concatenate(Wardrobe(4).pieces(state, 0)) - position
    cos, sin = np.cos(heading), np.sin(heading)
    in_body = corners @ np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    assert np.allclose(in_body.min(axis=0), size * (-0.5, -0.5, 0.0), atol=1e-9, rtol=0)
    assert np.allclose(in_body.max(axis=0), size * (0.5, 0.5, 1.0), atol=1e-9, rtol=0)
    assert len(Wardrobe(4).pieces(state, 0)) == len(pieces(appearance_of("saloon", "saloon/0", 4).design))


@pytest.mark.parametrize("kind", KINDS)
def test_looks_last_and_differ(kind):
    looks = [appearance_of(kind, f"user/{k}", seed=5) for k in range(200)]
    again = [appearance_of(kind, f"user/{k}", seed=5) for k in range(200)]
    assert [(look.design.name, look.colours) for look in looks] == [(one.design.name, one.colours) for one in again]
    assert len({look.design.name for look in looks}) == len(DESIGNS[kind])
    assert len({(look.design.name, tuple(look.colours.values())) for look in looks}) >= 195
    assert looks[0].colours != appearance_of(kind, "user/0", seed=6).colours
    for look in looks:
        assert set(look.colours) == set(look.design.materials)
        assert all(0.0 <= level <= 1.0 for rgb in look.colours.values() for level in rgb)
