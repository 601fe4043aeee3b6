"""Legs move with the way that somebody goes, and a body stays within its box."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from road_cases import network
from road_film_cases import BUSY, crossroads, pole_camera, users

from sim.bodies import DESIGNS
from sim.body_shapes import Wardrobe
from sim.film import advanced
from sim.gait import phase_rad
from sim.lights import LightPreset
from sim.renderer import RendererName
from sim.road_users import KINDS
from sim.traffic import TrafficMotion
from sim.traffic_spec import TrafficSpec, WalkerSpec

WARDROBE = Wardrobe(1)
WALKER = WalkerSpec("walker", "adult", ((-28.0, -39.0, 0.0), (-28.0, -33.0, 0.0)), start_s=1.0)
ways_m = st.floats(0.0, 500.0)


def gone(state, way_m):
    return replace(state, travelled_m=np.full(len(state.ids), way_m))


def moving(kind):
    return any(part.bone for design in DESIGNS[kind] for part in design.parts)


def test_who_walks_or_pedals_has_limbs_that_move():
    assert {kind for kind in KINDS if moving(kind)} == {"adult", "child", "stroller", "bicycle"}


@given(st.sampled_from(["adult", "child", "stroller", "bicycle"]), st.text(min_size=1, max_size=4), ways_m)
def test_a_body_stays_within_its_box_wherever_it_is_in_its_stride(kind, id_, way_m):
    state = replace(users((kind, 3.0, -2.0, 0.0)), ids=(id_,))
    corners = np.concatenate(WARDROBE.pieces(gone(state, way_m), 0)) - state.positions_m[0]
    assert (np.abs(corners[:, :2]) <= 0.5 * state.sizes_m[0, :2] + 1e-9).all()
    assert (corners[:, 2] >= -1e-9).all()
    assert corners[:, 2].max() == pytest.approx(state.sizes_m[0, 2], abs=1e-9)


@given(st.sampled_from(["adult", "bicycle"]), ways_m)
def test_after_a_stride_a_body_is_as_before(kind, way_m):
    state = gone(users((kind, 3.0, -2.0, 0.0)), way_m)
    stride_m = 2 * np.pi / phase_rad(gone(state, 1.0), 0)
    again = zip(WARDROBE.pieces(state, 0), WARDROBE.pieces(gone(state, way_m + stride_m), 0), strict=True)
    assert max(np.abs(before - after).max() for before, after in again) < 1e-9
    half = zip(WARDROBE.pieces(state, 0), WARDROBE.pieces(gone(state, way_m + 0.5 * stride_m), 0), strict=True)
    assert max(np.abs(before - after).max() for before, after in half) > 0.05


def test_limbs_hang_together():
    for design in DESIGNS["adult"]:
        bones = [part.bone for part in design.parts if part.bone]
        for phase in np.linspace(0.0, 6.0, 7):
            uppers = {bone.upper(phase) for bone in bones}
            ankles = [bone.lower(phase) for bone in bones if bone.lower(phase) in uppers]
            assert len(ankles) == 4  # two knees and two ankles: what ends there is followed by what begins there


def test_the_way_is_that_of_the_walker_and_does_not_grow_while_he_stands():
    motion = TrafficMotion(network("avenue"), None, TrafficSpec(walkers=(WALKER,), density=0.0), 1)
    truths = list(motion.run([k * 20_000_000 for k in range(400)]))
    ways = np.array([truth.travelled_m[0] for truth in truths])
    assert (ways[:10] == ways[0]).all()
    assert np.diff(ways).min() >= 0.0
    assert ways[-1] - ways[0] == pytest.approx(6.0, abs=1e-6)
    assert ways[-1] == ways[-20]
    (alone,) = motion.run([truths[150].time_ns])
    assert alone.travelled_m[0] == truths[150].travelled_m[0]
    later = advanced(truths[150], 0.1)
    assert later.travelled_m[0] - ways[150] == pytest.approx(0.14, abs=0.01)


def test_time_alone_moves_nobody():
    state = gone(BUSY, 1.3)
    later = replace(state, time_ns=10**9)
    for row in range(len(state.ids)):
        assert all(map(np.array_equal, WARDROBE.pieces(state, row), WARDROBE.pieces(later, row)))


@pytest.mark.film
def test_both_films_show_the_same_stride():
    camera = pole_camera()
    films = [crossroads(camera, LightPreset.CLOUDY, name=name).renderer([camera]) for name in RendererName]
    pictures = []
    for way_m in (0.0, 0.4):
        ours, oracle = (film.render(gone(BUSY, way_m), "pole") for film in films)
        assert (np.abs(ours.image.astype(int) - oracle.image).max(axis=2) > 4).mean() < 0.002
        assert (ours.instances != oracle.instances).mean() < 2e-4
        pictures.append(ours)
    for film in films:
        film.close()
    differs = (pictures[0].image != pictures[1].image).any(axis=2)
    assert 5 < differs.sum() < 1500  # the walker and the cyclist, and nothing else
