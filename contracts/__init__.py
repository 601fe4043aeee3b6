"""What the rooms hand each other: frozen data types, the stages' protocols, and errors.

Needs NumPy only. Exact truth lives in ``contracts.truth``, which is deliberately not re-exported here:
``perception``, ``georef`` and ``rail`` may not import it.
"""

from contracts.arrays import BoolArray, FloatArray, ImageArray, IntArray, frozen_array
from contracts.camera import Camera, Intrinsics, Pose
from contracts.errors import CalibrationError, GantryError, InputError
from contracts.events import Event, EventKind
from contracts.frame import Frame
from contracts.ground import GroundTracks
from contracts.motion import Compass, Motions, MotionState
from contracts.stages import Analyst, Detector, Fuser, Locator, Perceiver, Tracker
from contracts.survey import Checkerboard, Survey
from contracts.switches import SwitchState
from contracts.tracks import Detections, Tracks

__all__ = [
    "Analyst",
    "BoolArray",
    "CalibrationError",
    "Camera",
    "Checkerboard",
    "Compass",
    "Detections",
    "Detector",
    "Event",
    "EventKind",
    "FloatArray",
    "Frame",
    "Fuser",
    "GantryError",
    "GroundTracks",
    "ImageArray",
    "InputError",
    "IntArray",
    "Intrinsics",
    "Locator",
    "MotionState",
    "Motions",
    "Perceiver",
    "Pose",
    "Survey",
    "SwitchState",
    "Tracker",
    "Tracks",
    "frozen_array",
]
