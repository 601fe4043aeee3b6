"""How soon is a vehicle found that comes into sight? Counted in frames of one camera, per time that it came.

A vehicle is in sight while it is a target (``bench.matching``). The delay of one coming into sight is the number of
frames until its first hit: 0 when it is found in its first frame, the length of the whole stay when it is never found.
If just before the stay all of the vehicle was inside the image, something hid it, and it is found again; otherwise it
entered.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bench.matching import is_target
from bench.scores import Score
from bench.scoring.population import MatchedFrame, Population
from contracts import Camera, FloatArray


@dataclass(frozen=True)
class Arrival:
    """A vehicle comes into sight of a camera.

    index: of the first frame in which it is a target. hidden: whether something had hidden it before.
    delay: frames until its first hit.
    """

    camera: str
    object: str
    index: int
    hidden: bool
    delay: int


def latency_scores(prefix: str, populations: Sequence[Population], cameras: Sequence[Camera]) -> list[Score]:
    """Longest delay of a vehicle that entered, and of one that had been hidden; not valid where there was none."""
    named = {camera.name: camera for camera in cameras}
    seen = [population for population in populations if population.source in named]
    found = [arrival for population in seen for arrival in arrivals(population, named[population.source])]
    return [
        _longest(f"{prefix}.entry_frames_max", [arrival.delay for arrival in found if not arrival.hidden]),
        _longest(f"{prefix}.refound_frames_max", [arrival.delay for arrival in found if arrival.hidden]),
    ]


def _longest(name: str, delays: list[int]) -> Score:
    return Score.of(name, max(delays, default=0), "count", len(delays))


def arrivals(population: Population, camera: Camera) -> list[Arrival]:
    """Every time that a vehicle came into sight of ``camera``, in the order of the vehicles."""
    names = dict.fromkeys(name for frame in population.frames for name in frame.truth.ids)
    return [arrival for name in names for arrival in _arrivals_of(name, population.frames, camera)]


def _arrivals_of(name: str, frames: Sequence[MatchedFrame], camera: Camera) -> Iterator[Arrival]:
    states = np.array([_state(name, frame, camera) for frame in frames], np.bool_).reshape(-1, 3)  # (F, 3)
    in_sight, hit, inside = states.T
    changes = np.flatnonzero(np.diff(in_sight.astype(np.int8), prepend=0, append=0))  # begin, end, begin, end, ...
    for begin, end in changes.reshape(-1, 2).tolist():
        hits = np.flatnonzero(hit[begin:end])
        hidden = begin > 0 and bool(inside[begin - 1])
        delay = int(hits[0]) if len(hits) else end - begin
        yield Arrival(camera.name, name, frames[begin].truth.index, hidden, delay)


def _state(name: str, frame: MatchedFrame, camera: Camera) -> tuple[bool, bool, bool]:
    """Whether the object is a target, is hit, and lies wholly inside the image, hidden or not."""
    if name not in frame.truth.ids:
        return False, False, False
    row = frame.truth.ids.index(name)
    (view,) = (view for view in frame.truth.cameras if view.camera == camera.name)
    hit = row in frame.matching.hits[:, 0]
    return bool(is_target(frame.fractions)[row]), hit, _inside(view.full_boxes_px[row], camera)


def _inside(box_px: FloatArray, camera: Camera) -> bool:
    size = camera.intrinsics
    last = (size.width_px - 1, size.height_px - 1)
    return bool(np.isfinite(box_px).all() and (box_px[:2] >= 0).all() and (box_px[2:] <= last).all())
