"""Figure 15 of paper R: all views on one plane, with the vehicles' positions and directions and the switches."""

from bench.report.mosaic import EXPLANATION, grid_of, mosaic_figure, placed_vehicles
from bench.tables.films import Film, Watched
from bench.tables.part import Part
from georef.mosaic import mosaic
from scenarios.check import plant_of
from scenarios.schema import RailScenario


def figure15(shown: Film, watched: Watched) -> Part | None:
    """The moment in the middle of a film as ``watched`` saw it; None without bounded views or a plant."""
    cameras = [one.camera for one in shown.manifest.calibrated_cameras]
    grid = grid_of(cameras)
    if grid is None or not isinstance(shown.scenario, RailScenario):
        return None
    middle = len(shown.steps) // 2
    picture = mosaic({frame.camera: frame.image for frame in shown.steps[middle].frames}, cameras, grid)
    steps = watched.recording.steps
    drawn = mosaic_figure(picture, steps[middle], placed_vehicles(steps[middle]), plant_of(shown.scenario.plant))
    says = f"“{shown.scenario.name}”, the moment in the middle. {EXPLANATION}"
    return Part("figure15", "Figure 15: the mosaic", says, picture=drawn)
