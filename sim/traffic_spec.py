"""Who is on the road and what happens when: the typed specification that ``sim.traffic`` runs."""

import math
from collections import Counter
from dataclasses import dataclass
from typing import Literal

from contracts import InputError
from sim.road_users import KINDS

Ignored = Literal["signals", "right_of_way", "vehicles"]
WARM_UP_S = 30.0  # of traffic before the run begins, so that its first frame finds the road in use


@dataclass(frozen=True)
class DriverSpec:
    """One vehicle with its driver.

    kind: of ``sim.road_users.KINDS``.
    route: edges of the network from the first to the last.
    depart_s: when it enters; up to 30 s before the run begins. Enters as soon after that as there is room.
    lane: on which it enters, the rightmost is 0; the best one for its route if not given.
    offset_m: where its front end enters, along the first edge.
    speed_mps: with which it enters. top_speed_mps: that it does not exceed; the kind's own if not given.
    ignores: what its driver does not care for: ``signals``, ``right_of_way``, ``vehicles`` ahead.
    """

    id: str
    kind: str
    route: tuple[str, ...]
    depart_s: float = 0.0
    lane: int | None = None
    offset_m: float = 0.0
    speed_mps: float = 0.0
    top_speed_mps: float | None = None
    ignores: tuple[Ignored, ...] = ()

    def __post_init__(self) -> None:
        _check_kind(f"vehicle {self.id}", self.kind, walks=False)
        if not self.id or not self.route:
            raise InputError(f"vehicle {self.id!r} needs an id and a route of at least one edge")
        if not (math.isfinite(self.depart_s) and self.depart_s >= -WARM_UP_S):
            raise InputError(f"vehicle {self.id}: depart_s = {self.depart_s} must be finite, {-WARM_UP_S:g} or later")
        if not (math.isfinite(self.speed_mps) and self.speed_mps >= 0 and math.isfinite(self.offset_m)):
            raise InputError(f"vehicle {self.id}: speed_mps and offset_m must be finite, speed_mps not negative")
        if self.offset_m < 0 or (self.lane is not None and self.lane < 0):
            raise InputError(f"vehicle {self.id}: offset_m and lane must not be negative")
        if self.top_speed_mps is not None and not (math.isfinite(self.top_speed_mps) and self.top_speed_mps > 0):
            raise InputError(f"vehicle {self.id}: top_speed_mps = {self.top_speed_mps} must be finite and positive")


@dataclass(frozen=True)
class WalkerSpec:
    """Somebody on foot who goes where the author says. Drivers do not see them: what they do is told by events.

    path_m: corners of the way, (x, y, z) each; they stand at its first one before ``start_s`` and at its last one
    after they have walked it at ``speed_mps``.
    """

    id: str
    kind: str
    path_m: tuple[tuple[float, float, float], ...]
    start_s: float = 0.0
    speed_mps: float = 1.4

    def __post_init__(self) -> None:
        _check_kind(f"walker {self.id}", self.kind, walks=True)
        if not self.id or len(self.path_m) < 2 or len(set(self.path_m)) < len(self.path_m):
            raise InputError(f"walker {self.id!r} needs an id and a path of at least two different points")
        numbers = [self.start_s, self.speed_mps, *(x for point in self.path_m for x in point)]
        if not all(map(math.isfinite, numbers)) or self.speed_mps <= 0:
            raise InputError(f"walker {self.id}: path and start_s must be finite, speed_mps positive")


@dataclass(frozen=True)
class RoadEvent:
    """At ``at_s`` seconds ``vehicle`` brakes with ``braking_mps2`` until it stands, or goes on as before."""

    at_s: float
    vehicle: str
    do: Literal["brake", "go"]
    braking_mps2: float = 6.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.at_s) and self.at_s >= 0):
            raise InputError(f"event: at_s = {self.at_s} must be finite and not negative")
        if not 0 < self.braking_mps2 <= 9.0:
            raise InputError(f"event at {self.at_s} s: braking_mps2 = {self.braking_mps2} must lie in (0, 9]")


@dataclass(frozen=True)
class TrafficSpec:
    """Everybody whom the author names, and how dense the network's own traffic is: 0 none, 1 as its file says."""

    drivers: tuple[DriverSpec, ...] = ()
    walkers: tuple[WalkerSpec, ...] = ()
    events: tuple[RoadEvent, ...] = ()
    density: float = 1.0

    def __post_init__(self) -> None:
        for id_, count in Counter([d.id for d in self.drivers] + [w.id for w in self.walkers]).items():
            if count > 1:
                raise InputError(f"{count} road users have the id {id_}; each needs its own")
        if not 0 <= self.density <= 3:
            raise InputError(f"density = {self.density} must lie in [0, 3]")


def _check_kind(who: str, kind: str, *, walks: bool) -> None:
    accepted = [name for name, known in KINDS.items() if known.walks == walks]
    if kind not in accepted:
        raise InputError(f"{who}: kind {kind!r} is unknown; choose from {', '.join(accepted)}")
