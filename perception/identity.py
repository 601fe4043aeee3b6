"""Identity by colour: every vehicle has a colour of its own, so the label is the identity."""

import numpy as np

from contracts import Detections, Frame, Tracks


class ColourIdentity:
    """Tracker: each label gets the next free number when it is first seen, and keeps it until ``reset``."""

    def __init__(self) -> None:
        self._ids: dict[str, int] = {}

    def reset(self) -> None:
        """Forget which label has which number."""
        self._ids.clear()

    def update(self, frame: Frame, detections: Detections) -> Tracks:
        """The detections with their numbers; of several with one label, the best-scored one."""
        best: dict[str, int] = {}
        for row in np.argsort(-detections.scores, kind="stable").tolist():
            best.setdefault(detections.labels[row], row)
        rows = sorted(best.values())
        ids = [self._ids.setdefault(detections.labels[row], len(self._ids)) for row in rows]
        return Tracks(np.array(ids, np.int64), detections.take(rows))
