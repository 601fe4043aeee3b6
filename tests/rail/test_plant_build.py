from dataclasses import replace
from math import radians

import pytest
from plant_specs import METRE, at, built, cross, fork, with_section

from contracts import InputError, SwitchState
from rail.plant import Side
from rail.spec import BaliseSpec, BufferSpec, CrossingSpec, PieceSpec, PlantSpec, SectionSpec, SwitchSpec


def test_a_fork_has_its_parts_where_they_belong():
    plant = built(fork())
    switch = plant.switch("S1")
    assert (switch.toe.x_m, switch.toe.y_m, switch.toe.heading_rad) == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    assert switch.diverging_side is Side.LEFT
    assert switch.spot_m == pytest.approx((0.98, -0.045), abs=1e-12)
    assert switch.spot_state is SwitchState.STRAIGHT
    assert plant.length_m == pytest.approx(3.0 + 0.5 * radians(30.0), abs=1e-12)
    assert plant.buffers["W"].pose.heading_rad == pytest.approx(radians(180.0), abs=1e-12)


def test_the_notch_can_stand_on_either_side():
    spec = fork()
    plant = built(replace(spec, switch={"S1": replace(spec.switch["S1"], spot_side=Side.LEFT)}))
    assert plant.switch("S1").spot_m == pytest.approx((0.98, 0.045), abs=1e-12)


def test_a_crossing_is_found_exactly():
    crossing = built(cross()).crossings["X"]
    assert crossing.offsets_m == pytest.approx((0.4, 0.3), abs=1e-12)
    assert crossing.position_m == pytest.approx((0.0, 0.0), abs=1e-12)


def test_a_gap_below_the_tolerance_is_accepted():
    spec = fork()
    built(with_section(spec, "main", after=None, at=at(1.00009, 0.0, 0.0)))
    built(with_section(spec, "main", after=None, at=at(1.0, 0.0, 0.09)))


SECOND = {"second": SectionSpec(METRE, after="main.end")}


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        (PlantSpec("none", section={}), "at least one section"),
        (with_section(fork(), "main", after=None, at=at(1.00011, 0.0, 0.0)), r"0\.11 mm apart"),
        (with_section(fork(), "main", after=None, at=at(1.0, 0.0, 0.11)), r"kink of 0\.11 deg"),
        (with_section(fork(), "main", after=None), "'at' or a port 'after'"),
        (with_section(fork(), "main", at=at(1.0, 0.0, 0.0)), "'at' or a port 'after'"),
        (with_section(fork(), "main", after="stem"), "'stem' is no port; write SECTION.start"),
        (with_section(fork(), "main", after="stme.end"), "'stme' is unknown; there are stem, main, side"),
        (with_section(fork(), "stem", at=None, after="main.start"), "circle"),
        (with_section(fork(), "main", pieces=()), "no pieces"),
        (with_section(fork(), "main", pieces=(PieceSpec(close=True),)), "section 'main', piece 1: close = true needs"),
        (with_section(fork(), "main", pieces=(PieceSpec(line_m=-1.0),)), "section 'main', piece 1: .* no length"),
        (
            with_section(fork(), "side", pieces=(PieceSpec(turn_deg=30.0, radius_m=0.3), *METRE)),
            r"radius of 0\.300 m, less than min_radius_m = 0\.35",
        ),
        (with_section(fork(), "side", pieces=METRE), "not parted"),
        (
            replace(fork(), buffer={"W": BufferSpec("stem.start"), "E": BufferSpec("main.end")}),
            "side.end leads nowhere",
        ),
        (replace(fork(), buffer={**fork().buffer, "Z": BufferSpec("main.end")}), "main.end is used by buffer 'E' and"),
        (replace(fork(), buffer={"E": BufferSpec("main.ende")}), "is no port"),
        (replace(fork(), switch={}), "is joined to both"),
        (replace(fork(), section={**fork().section, **SECOND}), "main.end is used by the joint with second.start and"),
        (replace(fork(), switch={"S1": SwitchSpec("stem.end", "main.strat", "side.start")}), "'main.strat' is no port"),
        (
            replace(fork(), balise=(BaliseSpec(7, "stem", 0.1), BaliseSpec(7, "side", 0.2))),
            "on section 'stem' and 'side'",
        ),
        (replace(fork(), balise=(BaliseSpec(1 << 16, "stem", 0.1),)), "16 bits"),
        (replace(fork(), balise=(BaliseSpec(-1, "stem", 0.1),)), "16 bits"),
        (replace(fork(), balise=(BaliseSpec(7, "stem", 1.0),)), r"lies not within section 'stem', 0 to 1\.000 m"),
        (replace(fork(), balise=(BaliseSpec(7, "stme", 0.5),)), "'stme' is unknown"),
        (replace(cross(), crossing={}), r"'a' and 'b' cross near .*0\.000.* declare"),
        (replace(fork(), crossing={"X": CrossingSpec(("main", "side"))}), "cross 0 times"),
        (replace(cross(), crossing={"X": CrossingSpec(("a", "c"))}), "'c' is unknown"),
    ],
)
def test_an_inconsistent_plant_is_refused_with_the_way_out(spec, says):
    with pytest.raises(InputError, match=says):
        built(spec)


def test_a_notch_in_the_way_is_refused():
    spec = fork()
    parallel = SectionSpec(METRE, at=at(0.5, -0.08, 0.0))
    buffers = {f"p{end}": BufferSpec(f"parallel.{end}") for end in ("start", "end")}
    with pytest.raises(InputError, match="spot stands 35 mm from section 'parallel'"):
        built(replace(spec, section={**spec.section, "parallel": parallel}, buffer={**spec.buffer, **buffers}))


@pytest.mark.parametrize(
    ("piece", "says"),
    [
        ({}, "exactly one"),
        ({"line_m": 1.0, "close": True}, "exactly one"),
        ({"turn_deg": 30.0}, "radius_m"),
        ({"line_m": 1.0, "radius_m": 1.0}, "radius_m"),
        ({"shift_m": 0.1, "radius_m": 1.0, "ease_m": 0.1}, "ease_m"),
    ],
)
def test_a_piece_is_one_thing(piece, says):
    with pytest.raises(InputError, match=says):
        PieceSpec(**piece)


def test_a_place_needs_finite_numbers():
    with pytest.raises(InputError, match="finite"):
        at(0.0, float("nan"), 0.0)


def test_unknown_names_are_answered_with_the_known_ones():
    plant = built(fork())
    with pytest.raises(InputError, match="section 'nord' is unknown; there are stem, main, side"):
        plant.section("nord")
    with pytest.raises(InputError, match="switch 'S9' is unknown; there are S1"):
        plant.switch("S9")
