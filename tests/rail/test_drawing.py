import xml.etree.ElementTree as ET

import pytest

from rail.curves import Pose2
from rail.drawing import VehicleMark, plant_svg
from scenarios.plant_file import load_plant, plant_names

SVG = "{http://www.w3.org/2000/svg}"


def of_class(root: ET.Element, css: str) -> list[ET.Element]:
    return [element for element in root.iter() if element.get("class") == css]


@pytest.mark.parametrize("name", plant_names())
def test_a_drawing_shows_everything_once(name):
    plant = load_plant(name)
    root = ET.fromstring(plant_svg(plant))
    names = [text.text for text in root.iter(f"{SVG}text")]
    assert sorted(names) == sorted([*plant.sections, *plant.switches, "1 m"])
    for css, things in (
        ("rail", plant.sections),
        ("spot", plant.switches),
        ("balise", plant.balises),
        ("buffer", plant.buffers),
        ("crossing", plant.crossings),
    ):
        assert len(of_class(root, css)) == len(things), css


def test_a_drawing_is_to_scale_in_millimetres_with_north_up():
    plant = load_plant("oval")
    root = ET.fromstring(plant_svg(plant))
    x, y, width, height = (float(value) for value in root.attrib["viewBox"].split())
    assert (x, y, x + width, y + height) == pytest.approx((-2400.0, -800.0, 2400.0, 800.0), abs=1e-6)
    north = of_class(root, "rail")[list(plant.sections).index("north")]
    first = north.attrib["d"].split(" L ")[0]
    assert first == "M -1350.0,-480.0"


def test_vehicles_are_drawn_where_they_stand_and_names_are_escaped():
    mark = VehicleMark("<blue>", Pose2(0.5, 0.25, 0.0), 0.12, 0.06, "#0000ff")
    root = ET.fromstring(plant_svg(load_plant("oval"), vehicles=[mark]))
    (vehicle,) = of_class(root, "vehicle")
    assert vehicle.get("transform") == "translate(500.0,-250.0) rotate(-0.000)"
    assert (vehicle.get("width"), vehicle.get("height")) == ("120.0", "60.0")
    assert "<blue>" in [text.text for text in root.iter(f"{SVG}text")]
