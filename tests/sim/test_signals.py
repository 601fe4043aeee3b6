"""Traffic signals: their programs are SUMO's, and pictures show what they show."""

from dataclasses import replace

import libsumo
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from road_cases import path_of
from road_film_cases import BUSY, crossroads, pole_camera

from contracts import InputError
from sim.lights import LightPreset
from sim.projection import project
from sim.renderer import RendererName
from sim.road_network import read_network
from sim.signals import Aspect, SignalHead, SignalProgram
from sim.sumo_run import STEP_S, SumoRun
from sim.traffic_spec import WARM_UP_S, TrafficSpec

CAMERA = pole_camera(960, 540)
SECOND_NS = 10**9
# of the crossroads' cycle of 90 s, which is 30 s old when a run begins: what east and north show
MOMENTS_S = {0: ("red", "green"), 10: ("red", "amber"), 13: ("red", "red"), 20: ("green", "red"), 55: ("amber", "red")}

programs = st.builds(
    SignalProgram,
    st.lists(st.tuples(st.integers(1, 40 * SECOND_NS), st.text("GgyursoO", min_size=3, max_size=3)), min_size=1).map(
        tuple
    ),
    st.integers(-200 * SECOND_NS, 200 * SECOND_NS),
)


@pytest.mark.parametrize("phases", [(), ((0, "GGG"),), ((5, "GGG"), (-5, "rrr"))])
def test_a_program_without_time_is_refused(phases):
    with pytest.raises(InputError, match="last for some time"):
        SignalProgram(phases)


@pytest.mark.parametrize("offset_s", [0, 7, -20])
def test_programs_show_what_sumo_shows(tmp_path, offset_s):
    net = tmp_path / "shifted.net.xml"
    text = path_of("crossroads").read_text("utf-8")
    net.write_text(text.replace('programID="0" offset="0"', f'programID="0" offset="{offset_s}"'), "utf-8")
    network = read_network(net)
    program = network.signals["centre"]
    with SumoRun(network, None, TrafficSpec(density=0.0), 1) as sumo:
        for step in range(2000):
            sumo.step()
            in_its_middle_ns = round((step + 0.5) * STEP_S * 1e9)
            assert libsumo.trafficlight.getRedYellowGreenState("centre") == program.letters(in_its_middle_ns)


@given(programs, st.integers(0, 10**12))
def test_programs_go_round(program, time_ns):
    cycle_ns = sum(lasts for lasts, _ in program.phases)
    assert program.letters(time_ns + cycle_ns) == program.letters(time_ns)
    assert program.letters(program.offset_ns) == program.phases[0][1]
    assert program.letters(program.offset_ns - 1) == program.phases[-1][1]


@given(programs, st.integers(0, 10**12))
def test_a_head_is_green_if_anybody_may_go(program, time_ns):
    shown, letters = program.shown((0, 1, 2), time_ns), program.letters(time_ns)
    assert (shown == (Aspect.GREEN,)) == bool(set(letters) & set("Gg"))
    assert bool(shown) == bool(set(letters) - set("oO"))
    assert program.shown((), time_ns) == ()


def test_a_head_without_a_fixed_program_is_dark():
    assert SignalHead(np.zeros((3, 3)), np.array([1.0, 0.0, 0.0]), (0,), None).shown(0) == ()


def test_approaches_show_their_own():
    for at_s, (east, north) in MOMENTS_S.items():
        shown = crossroads(CAMERA).scene.shown(at_s * SECOND_NS)
        assert shown == tuple((Aspect(aspect),) for aspect in (east, north, north, east))  # east, north, south, west
    assert WARM_UP_S == 30.0


@pytest.mark.film
@pytest.mark.parametrize("name", RendererName)
@pytest.mark.parametrize("light", [LightPreset.CLOUDY, LightPreset.NIGHT])
def test_lights_are_lit_as_their_signal_says(light, name):
    studio = crossroads(CAMERA, light, name=name)
    renderer = studio.renderer([CAMERA])
    for at_s in MOMENTS_S:
        image = renderer.render(replace(BUSY, time_ns=at_s * SECOND_NS), "pole").image
        for head, shown in zip(studio.scene.signals, studio.scene.shown(at_s * SECOND_NS), strict=True):
            assert seen_lit(image, head) in (None, shown)
    renderer.close()


def seen_lit(image, head):
    """Which lights of a head are lit in a picture; None if it is not in there."""
    away_m = (CAMERA.pose.position_m - head.lights_m) @ head.facing
    faces_m = head.lights_m + 0.19 * np.sign(away_m)[:, None] * head.facing
    pixels, valid = project(CAMERA, faces_m)
    if not valid.all() or (pixels < 2).any() or (pixels > (957, 537)).any():
        return None
    colours = [image[round(v), round(u)].tolist() for u, v in pixels]
    lit = [(aspect, colour) for aspect, colour in zip(Aspect, colours, strict=True) if max(colour) > 120]
    for aspect, (blue, green, red) in lit:
        assert (red > green) == (aspect is not Aspect.GREEN)
        assert blue < max(red, green)
    return tuple(aspect for aspect, _ in lit)


@pytest.mark.film
def test_the_layered_film_follows_signals_as_a_drawing_of_everything_does():
    films = [crossroads(CAMERA, LightPreset.CLOUDY, name=name).renderer([CAMERA]) for name in RendererName]
    for at_s in MOMENTS_S:
        ours, oracle = (film.render(replace(BUSY, time_ns=at_s * SECOND_NS), "pole") for film in films)
        assert (np.abs(ours.image.astype(int) - oracle.image).max(axis=2) > 4).mean() < 0.002
        assert (ours.instances != oracle.instances).mean() < 2e-4
    for film in films:
        film.close()
