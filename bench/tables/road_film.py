"""A road filmed for its tables: what stands still before each camera, and the camera as each calibrator finds it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bench.road_calibration import FRAMES, frames_calibration, picks_of, thinned
from contracts import CalibrationError, Camera, Frame, ImageArray
from georef.calibrated import CalibratedCamera
from georef.ground_homography import GroundHomography
from georef.hd_map import HdMap
from georef.map_calibration import calibrate_camera, calibrate_homography, calibrate_pan_tilt
from georef.map_ground import MapGround
from perception.road_paint import still_picture
from scenarios.schema import RoadScenario
from scenarios.worlds import build_world, maps_of

Finding = CalibratedCamera | GroundHomography
MODELS = {"whole": "whole camera, 25 picks", "pan_tilt": "pan-tilt, 25 picks", "homography": "homography, 25 picks"}
CALIBRATORS = {**MODELS, FRAMES: "whole camera, frames alone"}
"""What the tables call them, by the names in scores."""


@dataclass(frozen=True, eq=False)
class FilmedCamera:
    """One camera over one road.

    true: for the score alone. picture: (H, W, 3) BGR, what stands still. found: by calibrator; a sentence where it
    refused.
    """

    scenario: RoadScenario
    true: Camera
    picture: ImageArray
    true_map: HdMap
    owners_map: HdMap
    found: dict[str, Finding | str]

    @cached_property
    def ground(self) -> MapGround | None:
        """Of the owners' map; None where all of it is level."""
        ground = MapGround.of(self.owners_map)
        return None if ground.is_level else ground


def film_road(scenario: RoadScenario, *, seed: int | None = None) -> list[FilmedCamera]:
    """Film five frames of each camera, two seconds apart, and calibrate it in every way."""
    thin = thinned(scenario if seed is None else replace(scenario, seed=seed))
    world = build_world(thin)
    frames = [frame for step in world.steps() for frame in step.frames]
    true_map, owners_map = maps_of(thin)
    filmed = []
    for nominal, true in zip(world.survey.cameras, world.cameras, strict=True):
        own = [frame for frame in frames if frame.camera == true.name]
        found = _found(thin, nominal, true, own)
        filmed.append(FilmedCamera(thin, true, still_picture(own), true_map, owners_map, found))
    return filmed


def _found(scenario: RoadScenario, nominal: Camera, true: Camera, frames: list[Frame]) -> dict[str, Finding | str]:
    points, lines = picks_of(scenario, true)
    size = nominal.intrinsics.width_px, nominal.intrinsics.height_px

    def rng() -> np.random.Generator:
        return np.random.default_rng(scenario.seed)

    ways: dict[str, Callable[[], Finding]] = {
        "whole": lambda: calibrate_camera(true.name, size, points, lines, rng=rng()).calibrated,
        "pan_tilt": lambda: calibrate_pan_tilt(true.name, size, points, lines, rng=rng()).calibrated,
        "homography": lambda: calibrate_homography(true.name, size, points, rng=rng()).homography,
        FRAMES: lambda: frames_calibration(scenario, nominal, frames),
    }
    found: dict[str, Finding | str] = {}
    for name, way in ways.items():
        try:
            found[name] = way()
        except CalibrationError as reason:
            found[name] = str(reason)
    return found
