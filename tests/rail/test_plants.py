import numpy as np
import pytest
from tours import tour

from rail.graph import Location
from scenarios.plant_file import load_plant, plant_names


def test_the_three_plants_are_found():
    assert set(plant_names()) >= {"oval", "line30", "atlas100"}


@pytest.mark.parametrize("name", plant_names())
def test_a_vehicle_visits_every_section(name):
    plant = load_plant(name)
    first = next(iter(plant.sections.values()))
    way = tour(plant, Location(first.id, first.length_m / 2, 1))
    assert {location.section for location in way} == set(plant.sections)


@pytest.mark.parametrize("name", plant_names())
def test_vehicles_on_neighbouring_tracks_have_room_beside_each_other(name):
    """Where two sections run side by side (parallel within 3 degrees), their centre lines are 11 cm apart."""
    plant = load_plant(name)
    switches_m = np.array([(s.toe.x_m, s.toe.y_m) for s in plant.switches.values()])
    poses = {id_: s.curve.poses_at(np.linspace(0.0, s.length_m, 100)) for id_, s in plant.sections.items()}
    for a, b in ((a, b) for a in poses for b in poses if a < b):
        apart_m = np.linalg.norm(poses[a][:, None, :2] - poses[b][None, :, :2], axis=2)
        parallel = np.abs(np.sin(poses[a][:, None, 2] - poses[b][None, :, 2])) < np.sin(np.radians(3.0))
        clear_of_switches = np.linalg.norm(poses[a][:, None, :2] - switches_m, axis=2).min(axis=1) > 0.7
        rows = clear_of_switches[:, None] & parallel & (apart_m > 0.02)  # nearer ones are one track going on
        assert not (rows & (apart_m < 0.11)).any(), (a, b)


def test_the_oval_fits_under_two_cameras():
    plant = load_plant("oval")
    x0, y0, x1, y1 = plant.bounds_m
    assert len(plant.switches) == 6
    assert max(-x0, x1) <= 1.9
    assert max(-y0, y1) <= 0.48 + 1e-9
    assert {"north", "loop_a"} <= set(plant.sections)
    assert "S2" in plant.switches


def test_the_line_is_thirty_metres_from_end_to_end():
    plant = load_plant("line30")
    x0, _, x1, _ = plant.bounds_m
    assert abs(x1 - x0 - 30.0) < 0.01
    assert len(plant.switches) >= 10
    assert len(plant.crossings) == 1


def test_the_atlas_has_a_hundred_metres_of_rail_and_130_balises():
    plant = load_plant("atlas100")
    assert abs(plant.length_m - 100.0) <= 1.0
    assert len(plant.balises) == 130
    assert len({balise.code for balise in plant.balises}) == 130
