import re
from pathlib import Path

import pytest

from contracts import InputError
from scenarios.loader import LIBRARY, build_world, list_scenarios, load_scenario
from scenarios.schema import Bound
from scenarios.variations import variants
from sim.colours import Colour

TEXT = (LIBRARY / "head-on-passing-loop.toml").read_text(encoding="utf-8")


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_scenario_is_found_by_its_name_and_by_its_path(tmp_path):
    by_name = load_scenario("head-on-passing-loop")
    by_path = load_scenario(written(tmp_path, TEXT))
    assert by_name.name == "head-on-passing-loop"
    assert by_path.name == "mine"
    assert by_name.motion == by_path.motion
    assert [vehicle.colour for vehicle in by_name.vehicle] == [Colour.BLUE, Colour.RED]
    assert by_name.expect.contact == (("blue", "red"),)


def test_the_list_holds_the_files_of_the_library():
    assert "oval-two-vehicles" in list_scenarios()
    assert list(list_scenarios()) == sorted(path.stem for path in LIBRARY.glob("*.toml"))


def test_an_unknown_name_is_answered_with_the_nearest_ones():
    with pytest.raises(InputError, match=r"'oval-two-vehicle'.*nearest: oval-two-vehicles"):
        load_scenario("oval-two-vehicle")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=re.escape(str(tmp_path / "none.toml"))):
        load_scenario(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('title = "', "title = ", ["not TOML"]),
        ("seed = 7", "sed = 7", ["line 6", "sed", "seed"]),
        ("seed = 7", "seed = -7", ["line 6", "key seed", ">= 0"]),
        ("seed = 7", 'seed = "7"', ["line 6", "seed", "int"]),
        ("duration_s = 6.0", "duration_s = 0.0", ["line 7", "key duration_s", "> 0"]),
        ("fps = 25", "fps = nan", ["line 8", "fps", "nan"]),
        ("fps = 25", "fps = 0", ["line 8", "key fps", "> 0"]),
        ('world = "rail"', 'world = "moon"', ["line 2", "world", "rail", "road"]),
        ('plant = "oval"', 'plant = "ovel"', ["line 3", "plant", "'ovel'", "oval"]),
        ('rig = "two_overhead"', 'rig = "three"', ["line 4", "rig", "'three'", "two_overhead"]),
        ('light = "dusk"', 'light = "dark"', ["line 5", "light", "dusk", "sunny"]),
        ('colour = "blue"', 'colour = "pink"', ["line 12", "vehicle[0].colour", "magenta"]),
        ('colour = "blue"', 'colour = "red"', ["2 vehicles", "colour red"]),
        ('section = "north"', 'section = "nord"', ["line 13", "vehicle[0].start.section", "'nord'", "north_gap"]),
        ("offset_m = 0.40", "offset_m = 4.0", ["line 13", "vehicle[0].start", "4.0 m", "1.700 m long"]),
        ('heading = "east"', 'heading = "up"', ["line 13", "heading", "forward"]),
        ("speed_mps = 0.35", "speed_mps = inf", ["line 14", "speed_mps", "inf"]),
        ("speed_mps = 0.35", "speed = 0.35", ["line 14", "speed", "speed_mps"]),
        ('switch = "S2"', 'switch = "S7"', ["line 28", "event[0].switch", "'S7'", "S1, S2"]),
        ('set = "diverging"', 'set = "left"', ["line 29", "set", "diverging"]),
        ("at_s = 1.0", "at_s = 7.0", ["line 27", "event[0].at_s", "7.0 s", "6.0 s"]),
        ('contact = [["blue", "red"]]', 'contact = [["blue", "green"]]', ["line 32", "'green'", "blue, red"]),
        ('contact = [["blue", "red"]]', 'contact = [["blue", "blue"]]', ["line 32", "itself"]),
        ("[expect]", "[expect.scores]\nx = { }\n[expect]", ["expect.scores", "min, max or both"]),
        ('title = "', 'name = "other"\ntitle = "', ["name", "'other'", "'mine'"]),
        (
            "[expect]",
            '[vary]\n"vehicle.green.speed_mps" = { min = 0, max = 1 }\n[expect]',
            ["vary", "'green'", "blue, red"],
        ),
        ("[expect]", '[vary]\nlight = { any = ["dark"] }\n[expect]', ["line 32", "vary.light", "dark"]),
        ("[expect]", "[floor]\ncontrast = -1.0\n[expect]", ["line 31", "key floor", "contrast = -1.0"]),
        ("[expect]", "[floor]\nsrgb = [1, 2]\n[expect]", ["line 32", "floor.srgb", "length 3"]),
        ("[expect]", "[sensor]\nwhite_balance_drift = 2.0\n[expect]", ["line 31", "sensor", "[0, 1)"]),
        ("[expect]", '[[light_change]]\nat_s = 1.0\nto = "dark"\n[expect]', ["line 33", "light_change[0].to", "dusk"]),
        (
            "[expect]",
            '[[light_change]]\nat_s = 3.0\nto = "sunny"\n[[light_change]]\nat_s = 2.0\nto = "dusk"\n[expect]',
            ["line 34", "light_change[1]", "3.0 s"],
        ),
        ("[expect]", "[[highlight]]\nazimuth_deg = 1.0\nelevation_deg = -1.0\n[expect]", ["highlight[0]", "-1.0"]),
        (
            "[expect]",
            "[[object]]\nat_m = [0.0, 0.48]\nsize_m = [0.1, 0.1, 0.1]\nsrgb = [1, 2, 3]\n[expect]",
            ["line 31", "object[0]", "in the way"],
        ),
        ("[expect]", "[[bridge]]\nat_m = [0.0, 0.48]\nheading_deg = 0.0\n[expect]", ["bridge[0]", "in the way"]),
        ("seed = 7", 'seed = 7\nsplit = "validate"', ["line 7", "split", "train, test"]),
        ("[expect]", "[vary]\nfps = { min = 10 }\n[expect]", ["line 32", "vary.fps", "min and max"]),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_file_line_and_key(tmp_path, old, new, words):
    path = written(tmp_path, TEXT.replace(old, new, 1))
    with pytest.raises(InputError) as refusal:
        load_scenario(path)
    message = str(refusal.value)
    assert str(path) in message
    for word in words:
        assert word in message


def test_a_bound_holds_within_its_limits_only():
    assert Bound(min=1.0, max=2.0).holds(1.0)
    assert not Bound(min=1.0).holds(0.999)
    assert not Bound(max=1.0).holds(1.001)
    assert not Bound(max=1.0).holds(float("nan"))
    with pytest.raises(InputError, match="exceeds"):
        Bound(min=2.0, max=1.0)


def test_a_world_without_film_has_truth_and_no_frames():
    world = build_world(load_scenario("oval-one-vehicle"), film=False)
    first = next(iter(world.steps()))
    assert len(world) == 100
    assert first.frames == ()
    assert first.truth.ids == ("blue",)


def test_another_seed_hangs_the_cameras_elsewhere_and_leaves_the_traffic_alone():
    scenario = load_scenario("oval-one-vehicle")
    own, other = (build_world(scenario, seed=seed, film=False) for seed in (None, 99))
    assert (own.cameras[0].pose.position_m != other.cameras[0].pose.position_m).any()
    for a, b in zip(own.steps(), other.steps(), strict=True):
        assert (a.truth.positions_m == b.truth.positions_m).all()


ROAD = """title = "A walker"
world = "road"
network = "avenue"
rig = "avenue_poles"
light = "sunny"
seed = 1
duration_s = 2.0
fps = 25
density = 0.0

[[vehicle]]
id = "car"
kind = "saloon"
route = ["eastward"]

[[event]]
at_s = 1.0
vehicle = "car"
do = "brake"

[expect]
contact = []
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('network = "avenue"', 'network = "road"', ["line 3", "network", "avenue, avenue_grade"]),
        ('network = "avenue"', 'plant = "oval"', ["line 3", "plant", "unknown key"]),
        ('rig = "avenue_poles"', 'rig = "poles"', ["line 4", "rig", "avenue_poles"]),
        ("density = 0.0", "density = 9.0", ["density", "[0, 3]"]),
        ('kind = "saloon"', 'kind = "tank"', ["vehicle", "tank", "saloon"]),
        ('["eastward"]', '["north"]', ["line 14", "vehicle[0].route", "north", "eastward"]),
        ('["eastward"]', '["eastward"]\nignores = ["rain"]', ["line 15", "ignores", "signals"]),
        ('vehicle = "car"', 'vehicle = "bus"', ["line 18", "event[0].vehicle", "bus"]),
        ("at_s = 1.0", "at_s = 3.0", ["line 17", "comes after the end"]),
        ('do = "brake"', 'do = "stop"', ["line 19", "brake, go"]),
        ("contact = []", 'contact = [["car", "car2"]]', ["line 22", "car2"]),
        ("contact = []", 'derail = ["car"]', ["line 22", "derails"]),
    ],
)
def test_what_is_wrong_in_a_road_scenario_is_told_with_file_line_and_key(tmp_path, old, new, words):
    path = written(tmp_path, ROAD.replace(old, new, 1))
    with pytest.raises(InputError) as refusal:
        load_scenario(path)
    message = str(refusal.value)
    for word in [str(path), *words]:
        assert word in message


def test_a_road_is_a_world_that_can_be_had_without_film(tmp_path):
    scenario = load_scenario(written(tmp_path, ROAD))
    steps = list(build_world(scenario, film=False).steps())
    assert len(steps) == 50
    assert steps[-1].truth.labels == ("car",)
    assert all(step.frames == () for step in steps)


def test_a_key_of_a_road_scenario_may_vary(tmp_path):
    text = ROAD.replace("[expect]", '[vary]\n"vehicle.car.depart_s" = { min = -3, max = -1 }\n[expect]')
    scenario = load_scenario(written(tmp_path, text))
    (one,) = variants(scenario, 1)
    assert -3 <= one.vehicle[0].depart_s <= -1
