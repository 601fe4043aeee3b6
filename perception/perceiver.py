"""A perceiver made of two parts."""

from contracts import Detector, Frame, Tracker, Tracks


class DetectThenTrack:
    """Perceiver: detects in every frame, then gives the detections their identity."""

    def __init__(self, detector: Detector, tracker: Tracker) -> None:
        self._detector = detector
        self._tracker = tracker

    def reset(self) -> None:
        """Forget all frames, in both parts."""
        self._detector.reset()
        self._tracker.reset()

    def perceive(self, frame: Frame) -> Tracks:
        """Tracks in ``frame``."""
        return self._tracker.update(frame, self._detector.detect(frame))
