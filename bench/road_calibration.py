"""Cameras over a road, calibrated from the map: from picks made by hand, or from what they film alone."""

from collections.abc import Sequence
from dataclasses import replace

from contracts import Camera, Frame
from contracts.truth import World
from georef.calibrated import CalibratedCamera
from georef.map_calibration import calibrate_camera
from georef.picks import LinePicks, PointPicks
from perception.frame_calibration import calibrate_from_frames
from scenarios.schema import RoadScenario
from scenarios.worlds import maps_of
from sim.hand_picks import hand_picks
from sim.streams import stream

PICKS, FRAMES = "picks", "frames"
CALIBRATORS = (PICKS, FRAMES)
_FRAMES, _EVERY_S = 5, 2.0


def thinned(scenario: RoadScenario) -> RoadScenario:
    """The same world, its beginning filmed five times, two seconds apart: enough to tell the road from its traffic."""
    return replace(scenario, fps=1.0 / _EVERY_S, duration_s=_FRAMES * _EVERY_S)


def calibrated_from_map(
    scenario: RoadScenario, world: World, frames: Sequence[Frame], calibrator: str
) -> tuple[CalibratedCamera, ...]:
    """Every camera of a road's world.

    scenario: with the seed of the run. frames: of each camera, several for choice, looked at by ``frames`` alone.
    calibrator: ``picks``, by hand, made up with a hand's errors; ``frames``, found in the frames themselves.
    Raises CalibrationError where the map's features before a camera do not determine it.
    """
    found = []
    for nominal, true in zip(world.survey.cameras, world.cameras, strict=True):
        if calibrator == FRAMES:
            own = [frame for frame in frames if frame.camera == nominal.name]
            found.append(frames_calibration(scenario, nominal, own))
        else:
            points, lines = picks_of(scenario, true)
            size = nominal.intrinsics.width_px, nominal.intrinsics.height_px
            rng = stream(scenario.seed, f"calibration/{nominal.name}")
            found.append(calibrate_camera(nominal.name, size, points, lines, rng=rng).calibrated)
    return tuple(found)


def frames_calibration(scenario: RoadScenario, nominal: Camera, frames: Sequence[Frame]) -> CalibratedCamera:
    """One camera from its frames and the owners' map alone."""
    _, owners_map = maps_of(scenario)
    return calibrate_from_frames(frames, nominal, owners_map, map_sigma_m=scenario.map_sigma_m).calibrated


def picks_of(scenario: RoadScenario, true: Camera) -> tuple[PointPicks, LinePicks]:
    """An owner's picks in the pictures of one camera, made up from the truth as a hand would make them."""
    return hand_picks(true, *maps_of(scenario), stream(scenario.seed, f"picks/{true.name}"))
