"""Road users differ in size within what is sold; SUMO, the truth and the picture know the same one."""

import libsumo
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from road_cases import network, path_of

from sim.bodies import appearance_of
from sim.road_users import KINDS, SHY_M
from sim.sumo_run import SumoRun
from sim.traffic import TrafficMotion
from sim.traffic_spec import DriverSpec, TrafficSpec, WalkerSpec
from sim.user_sizes import RANGES_M, Sizes

kinds, seeds = st.sampled_from(sorted(KINDS)), st.integers(0, 2**31 - 1)
CAR = DriverSpec("car", "saloon", ("south_in", "north_out"), -2.0, lane=2)
WALKER = WalkerSpec("walker", "adult", ((-28.0, -39.0, 0.0), (-28.0, -21.0, 0.0)))


@given(kinds, seeds, st.text(max_size=8))
def test_a_size_lies_in_the_range_of_its_kind_and_is_the_same_again(kind, seed, id_):
    size = np.array(Sizes(seed).of(kind, id_))
    smallest, largest = RANGES_M[kind]
    assert (size >= np.array(smallest) - 1e-9).all()
    assert (size <= np.array(largest) + 1e-9).all()
    assert Sizes(seed).of(kind, id_) == tuple(size)


@pytest.mark.parametrize("kind", KINDS)
def test_usual_sizes_lie_within_and_users_differ(kind):
    smallest, largest = np.array(RANGES_M[kind])
    assert (smallest < KINDS[kind].size_m).all()
    assert (largest > KINDS[kind].size_m).all()
    sizes = np.array([Sizes(1).of(kind, str(number)) for number in range(400)])
    assert (np.std(sizes, axis=0) > 0.18 * (largest - smallest)).all()
    assert np.abs(np.mean(sizes < KINDS[kind].size_m, axis=0) - 0.5).max() < 0.1
    assert np.corrcoef(sizes.T).min() > 0.5  # what is long is wide and high


def test_cars_are_as_long_as_cars_are():
    lengths = [Sizes(1).of(kind, str(n))[0] for kind in ("city_car", "saloon", "suv") for n in range(400)]
    assert (round(min(lengths), 1), round(max(lengths), 1)) == (3.5, 5.0)


def test_sizes_come_from_a_stream_of_their_own():
    before = appearance_of("suv", "x", 1)
    Sizes(1).of("suv", "x")
    assert appearance_of("suv", "x", 1).colours == before.colours


def test_sumo_drives_with_the_sizes_of_the_truth():
    spec = TrafficSpec((CAR,), (WALKER,))
    routes = path_of("crossroads").with_name("crossroads.rou.xml")
    (truth,) = TrafficMotion(network("crossroads"), routes, spec, 3).run([0])
    sizes_m = dict(zip(truth.ids, map(tuple, truth.sizes_m.tolist()), strict=True))
    assert sizes_m.pop("walker") == Sizes(3).of("adult", "walker")
    with SumoRun(network("crossroads"), routes, spec, 3) as sumo:
        for _ in range(601):
            there = sumo.step()
        for id_, size_m in sizes_m.items():
            domain, shy_m = (libsumo.person, 0.0) if KINDS[there[id_].kind].walks else (libsumo.vehicle, 2 * SHY_M)
            known = domain.getLength(id_), domain.getWidth(id_) - shy_m, domain.getHeight(id_)
            assert known == pytest.approx(size_m, abs=1e-9)
    assert len({sizes_m[id_] for id_ in sizes_m}) == len(sizes_m) > 10
