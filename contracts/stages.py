"""The stages of the chain, as protocols: write a class with these methods and it plugs in.

A perceiver, detector or tracker serves one camera; the bench makes one for each. No base classes, no registry.
"""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from contracts.frame import Frame
from contracts.ground import GroundTracks
from contracts.motion import Motions
from contracts.tracks import Detections, Tracks


@runtime_checkable
class Detector(Protocol):
    """Finds objects in single frames."""

    def detect(self, frame: Frame) -> Detections:
        """Objects in ``frame``. Must not change the frame; the same frames in the same order give the same answer."""
        ...

    def reset(self) -> None:
        """Forget all frames seen so far."""
        ...


@runtime_checkable
class Tracker(Protocol):
    """Gives detections an identity from frame to frame."""

    def update(self, frame: Frame, detections: Detections) -> Tracks:
        """Tracks in ``frame``, given what was detected in it."""
        ...

    def reset(self) -> None:
        """Forget all frames seen so far."""
        ...


@runtime_checkable
class Perceiver(Protocol):
    """Frames in, tracks out: a detector with a tracker, or one end-to-end object."""

    def perceive(self, frame: Frame) -> Tracks:
        """Tracks in ``frame``."""
        ...

    def reset(self) -> None:
        """Forget all frames seen so far."""
        ...


@runtime_checkable
class Locator(Protocol):
    """Places one camera's tracks on the ground."""

    def locate(self, tracks: Tracks) -> GroundTracks:
        """Metres on the ground with covariance, valid or not."""
        ...


@runtime_checkable
class Fuser(Protocol):
    """Merges the cameras' views of one moment: one row per object, nothing counted twice."""

    def fuse(self, views: Sequence[GroundTracks]) -> GroundTracks:
        """All objects of that moment, ``source == "fused"``."""
        ...


@runtime_checkable
class Analyst(Protocol):
    """Tells how the objects move, from where they are moment by moment."""

    def analyse(self, ground: GroundTracks) -> Motions:
        """Motion of the objects of one moment, row for row; moments come in the order of time."""
        ...

    def reset(self) -> None:
        """Forget all moments seen so far."""
        ...
