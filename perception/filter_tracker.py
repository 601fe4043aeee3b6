"""Detection at the start and on loss, a correlation filter alone in between: what the hybrid is compared with."""

from collections.abc import Callable

import numpy as np

from contracts import Detections, Detector, FloatArray, Frame, Tracks
from perception.identity import ColourIdentity
from perception.target_filter import Found, TargetFilter

LOST_BELOW = 5.0  # peak to side lobe ratio; Bolme et al. 2010 name 7 for a target that is there
SEARCH_EVERY = 30  # frames between looks at the whole frame for those who entered
MEMORY = 6  # places from which the motion is read
SLOW_PX = 1.5  # a frame: below this the direction of motion is noise
BORDER_PX = 2.0  # a target whose middle comes so near to the border has left

# velocity at the newest of MEMORY places, from the parabola through them by least squares
_PARABOLA = np.linalg.pinv(np.vander(np.arange(1.0 - MEMORY, 1.0), 3))[1]


class FilterTracker:
    """Perceiver: ``detector`` starts targets; a filter of ``make_filter`` follows each until its response falls."""

    def __init__(self, detector: Detector, make_filter: Callable[[], TargetFilter]) -> None:
        self._detector = detector
        self._make_filter = make_filter
        self._identity = ColourIdentity()
        self.reset()

    def reset(self) -> None:
        """Forget all frames."""
        self._detector.reset()
        self._identity.reset()
        self._targets: dict[str, _Target] = {}
        self._since_search = SEARCH_EVERY

    def perceive(self, frame: Frame) -> Tracks:
        """Tracks in ``frame``."""
        kept = {label: target for label, target in self._targets.items() if target.follow(frame)}
        lost = len(kept) < len(self._targets)
        self._targets = kept
        self._since_search += 1
        if lost or self._since_search >= SEARCH_EVERY:
            self._search(frame)
        return self._identity.update(frame, _rows(frame, list(self._targets.values())))

    def _search(self, frame: Frame) -> None:
        """Start those who are not followed; those who are keep their filters."""
        self._since_search = 0
        found = self._detector.detect(frame)
        for row, label in enumerate(found.labels):
            if label not in self._targets:
                self._targets[label] = _Target(self._make_filter(), found.take([row]), frame)


class _Target:
    """One target: what was detected, and where it has moved since."""

    def __init__(self, seeker: TargetFilter, detected: Detections, frame: Frame) -> None:
        self._seeker, self.detected = seeker, detected
        quad = detected.quads_px[0]
        middle = quad.mean(axis=0)
        self._outline_px = np.concatenate([quad, detected.anchors_px]) - middle  # (5, 2)
        sides = np.roll(quad, -1, axis=0) - quad
        self._first_angle_rad = self._angle_rad = _angle_of(quad)
        size = float(np.linalg.norm(sides[0])), float(np.linalg.norm(sides[1]))
        self._places = [middle]
        seeker.start(frame.image, middle, (max(size[0], 1.0), max(size[1], 1.0)), self._angle_rad)

    def follow(self, frame: Frame) -> bool:
        """Whether the target is still there."""
        found = self._seeker.find(frame.image, self._places[-1] + self._velocity_px(), self._angle_rad)
        if found.confidence < LOST_BELOW or not _inside(found, frame):
            return False
        self._seeker.learn(frame.image, found.centre_px, self._angle_rad)
        self._places = [*self._places, found.centre_px][-MEMORY:]
        self._turn()
        return True

    def _velocity_px(self) -> FloatArray:
        """(2,) a frame."""
        if len(self._places) < MEMORY:
            return self._places[-1] - self._places[-2] if len(self._places) > 1 else np.zeros(2)
        return np.asarray(_PARABOLA @ np.array(self._places))

    def _turn(self) -> None:
        """A vehicle moves along its length, ahead or back; while it is too slow to tell, its angle stays."""
        velocity = self._velocity_px()
        if len(self._places) == MEMORY and np.hypot(*velocity) >= SLOW_PX:
            turned = float(np.arctan2(velocity[1], velocity[0])) - self._angle_rad
            self._angle_rad += (turned + np.pi / 2) % np.pi - np.pi / 2

    def outline_px(self) -> FloatArray:
        """(5, 2) the detected corners and the anchor, moved and turned to where the target is now."""
        turned_rad = self._angle_rad - self._first_angle_rad
        c, s = np.cos(turned_rad), np.sin(turned_rad)
        return np.asarray(self._outline_px @ np.array([[c, s], [-s, c]]) + self._places[-1])


def _rows(frame: Frame, targets: list[_Target]) -> Detections:
    if not targets:
        return Detections.empty(frame.camera, frame.index, frame.time_ns)
    outlines = np.array([target.outline_px() for target in targets])  # (N, 5, 2)
    quads, detected = outlines[:, :4], [target.detected for target in targets]
    return Detections(
        frame.camera,
        frame.index,
        frame.time_ns,
        tuple(seen.labels[0] for seen in detected),
        np.concatenate([seen.scores for seen in detected]),
        np.concatenate([quads.min(axis=1), quads.max(axis=1)], axis=1),
        quads,
        outlines[:, 4],
        np.concatenate([seen.anchor_heights_m for seen in detected]),
        np.concatenate([seen.anchor_covs_px2 for seen in detected]),
    )


def _angle_of(quad_px: FloatArray) -> float:
    side = quad_px[1] - quad_px[0]
    return float(np.arctan2(side[1], side[0]))


def _inside(found: Found, frame: Frame) -> bool:
    (u, v), (height, width) = found.centre_px.tolist(), frame.image.shape[:2]
    return bool(BORDER_PX <= u <= width - 1 - BORDER_PX and BORDER_PX <= v <= height - 1 - BORDER_PX)
