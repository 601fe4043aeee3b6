import pytest

from contracts import InputError
from scenarios.plant_file import PLANTS, load_plant, plant_names


@pytest.mark.parametrize("name", plant_names())
def test_a_plant_is_loaded_by_name_or_by_path(name):
    by_name, by_path = load_plant(name), load_plant(PLANTS / f"{name}.toml")
    assert by_name.name == by_path.name == name
    assert by_name == by_path


def test_an_unknown_plant_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match="plant 'ovall' is unknown; there are atlas100, line30, oval"):
        load_plant("ovall")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"loop_a.start"', '"loop_b.start"', r"broken\.toml: switch 'S1': west.end and loop_b.start are 28.* mm apart"),
        ("radius_m = 0.48", "radius_m = 0.1", r"broken\.toml: section 'east' bends with a radius of 0\.\d+ m"),
        ("line_m = 1.7", "lime_m = 1.7", r"broken\.toml, line \d+: key section.north.pieces\[0\].lime_m: unknown key"),
        ("code = 0x1002", "code = 0x1001", r"broken\.toml: balise 0x1001 lies both on section 'north' and 'north'"),
    ],
)
def test_a_broken_plant_file_is_named(tmp_path, old, new, says):
    text = (PLANTS / "oval.toml").read_text()
    (tmp_path / "broken.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=says):
        load_plant(tmp_path / "broken.toml")
