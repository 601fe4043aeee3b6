"""One run of the traffic, one step after the other: SUMO's samples in, bodies, contacts and truth out."""

from dataclasses import dataclass, field
from itertools import combinations
from math import atan2, cos, degrees, hypot, pi, radians, sin, tan

import numpy as np

from contracts import Event, EventKind
from contracts.truth import Truth
from sim.contacts import first_touch
from sim.road_users import KINDS, Kind, Size
from sim.smooth_motion import SPAN, Pose, Stretch, Wreck, node_of
from sim.sumo_run import STEP_S, SumoRun
from sim.traffic_spec import WARM_UP_S, TrafficSpec
from sim.trails import Place, Trail
from sim.user_sizes import Sizes
from sim.walks import Walk

_WARM_UP_STEPS = round(WARM_UP_S / STEP_S)
_NEEDED_S = (SPAN + 3) * STEP_S  # of samples before the run's time 0


@dataclass
class _Body:
    """Somebody on the road: the samples SUMO gave, and the motion in the present step once there are enough."""

    kind: Kind
    size_m: Size
    trail: Trail | None = None
    samples: list[Place] = field(default_factory=list)
    angles_rad: list[float] = field(default_factory=list)
    stretch: Stretch | None = None
    wreck: Wreck | None = None
    travelled_m: float = 0.0  # until the present step began

    def pose(self, begin_s: float, time_s: float) -> Pose:
        """At ``time_s`` of the run, within the step that began at ``begin_s``."""
        if self.wreck is not None and time_s >= self.wreck.since_s:
            return self.wreck.at(time_s)
        assert self.stretch is not None
        return self.stretch.pose(time_s - begin_s)

    def way_m(self, begin_s: float, time_s: float) -> float:
        """How far it has come until then; who came to rest by a contact goes no farther."""
        if self.wreck is not None:
            return self.travelled_m
        assert self.stretch is not None
        return self.travelled_m + (time_s - begin_s) / STEP_S * self.stretch.way_m

    @property
    def fastest_mps(self) -> float:
        return self.stretch.fastest_mps if self.stretch is not None else 0.0

    @property
    def reach_m(self) -> float:
        """From the centre to a corner."""
        return hypot(*self.size_m[:2]) / 2

    def take(self, front_m: tuple[float, float, float], slope: float, heading_rad: float) -> None:
        """One more sample; the motion of the step that lies half the window back."""
        length_m = self.size_m[0]
        if self.trail is None:
            self.trail = Trail((*front_m, slope), heading_rad, self.kind.front_axle * length_m)
        else:
            self.trail.take((*front_m, slope))
        self.samples = [*self.samples, self.trail.end()][-SPAN - 1 :]
        self.angles_rad = [*self.angles_rad, heading_rad][-SPAN - 1 :]
        if len(self.samples) <= SPAN:
            return
        rows = np.array(self.samples)
        self.travelled_m += self.stretch.way_m if self.stretch else 0.0
        self.stretch = Stretch.following(
            self.stretch.end if self.stretch else node_of(rows[:-1], STEP_S),
            node_of(rows[1:], STEP_S),
            self.stretch.end_heading_rad if self.stretch else self.angles_rad[SPAN // 2],
            step_s=STEP_S,
            length_m=length_m,
            guide_m=self.kind.front_axle * length_m,
            wheelbase_m=(self.kind.rear_axle - self.kind.front_axle) * length_m,
        )


class TrafficRun:
    """After ``step`` has been called often enough, always at the beginning of a step whose motion is decided."""

    def __init__(self, sumo: SumoRun, spec: TrafficSpec, sizes: Sizes) -> None:
        self._sumo = sumo
        self._walks = {walker.id: Walk(walker, sizes.of(walker.kind, walker.id)) for walker in spec.walkers}
        self._commands = sorted(spec.events, key=lambda event: event.at_s)[::-1]  # the next one is the last
        self._bodies: dict[str, _Body] = {}
        self._events: list[Event] = []
        self._samples = 0
        self._touched: set[tuple[str, str]] = set()

    @property
    def begin_ns(self) -> int:
        """When the present step began: SUMO is ahead by half the window and one."""
        return round((self._samples - _WARM_UP_STEPS - SPAN // 2 - 1) * STEP_S * 1e9)

    def step(self) -> None:
        """Go on to the next step."""
        sumo_s = (self._samples + 1 - _WARM_UP_STEPS) * STEP_S
        while self._commands and self._commands[-1].at_s <= sumo_s + 1e-9:
            self._sumo.obey(self._commands.pop())
        seen = self._sumo.step()
        self._samples += 1
        if sumo_s < -_NEEDED_S:
            return  # nobody asks for the truth of the warm-up
        for id_, body in list(self._bodies.items()):
            if id_ not in seen and id_ not in self._walks and body.wreck is None:
                del self._bodies[id_]
        for id_, sample in seen.items():
            body = self._bodies.setdefault(id_, _Body(KINDS[sample.kind], sample.size_m))
            if body.wreck is None:
                body.take(sample.front_m, tan(radians(sample.slope_deg)), pi / 2 - radians(sample.angle_deg))
        for id_, walk in self._walks.items():
            body = self._bodies.setdefault(id_, _Body(walk.kind, walk.size_m))
            if body.wreck is None:
                body.take(*walk.at(sumo_s))
        self._find_contacts()

    def truth(self, index: int, time_ns: int) -> Truth:
        """The state at ``time_ns`` within this step, with the events up to then that were not handed out yet."""
        time_s, begin_s = time_ns * 1e-9, self.begin_ns * 1e-9
        there = sorted(id_ for id_, body in self._bodies.items() if body.stretch is not None)
        bodies = [self._bodies[id_] for id_ in there]
        poses = [body.pose(begin_s, time_s) for body in bodies]
        happened = tuple(event for event in self._events if event.time_ns <= time_ns)
        self._events = [event for event in self._events if event.time_ns > time_ns]
        return Truth(
            index=index,
            time_ns=time_ns,
            ids=tuple(there),
            labels=tuple(str(body.kind.label) for body in bodies),
            positions_m=np.array([(p.x_m, p.y_m, p.z_m) for p in poses]).reshape(-1, 3),
            headings_rad=np.array([_wrapped(p.heading_rad) for p in poses]),
            sizes_m=np.array([body.size_m for body in bodies]).reshape(-1, 3),
            velocities_mps=np.array([(p.vx_mps, p.vy_mps) for p in poses]).reshape(-1, 2),
            places=(None,) * len(there),
            kinds=tuple(body.kind.name for body in bodies),
            events=happened,
            travelled_m=np.array([body.way_m(begin_s, time_s) for body in bodies]),
        )

    def _find_contacts(self) -> None:
        """Let whoever touches somebody in this step come to rest, the earliest contact first."""
        begin_s = self.begin_ns * 1e-9
        if begin_s < 0:
            return  # what happened before the run is not its business
        pairs = self._near_pairs(begin_s)
        while touches := [(time_s, pair) for pair in pairs if (time_s := self._touch(pair, begin_s)) is not None]:
            time_s, pair = min(touches)
            pairs.remove(pair)
            self._touched.add(pair)
            self._events.append(Event(round(time_s * 1e9), EventKind.CONTACT, pair))
            for id_ in pair:
                self._wreck(id_, begin_s, time_s)

    def _near_pairs(self, begin_s: float) -> list[tuple[str, str]]:
        """Pairs that could touch in this step. People brush past each other: two of them make no contact."""
        there = sorted(id_ for id_, body in self._bodies.items() if body.stretch is not None)
        if len(there) < 2:
            return []
        bodies = [self._bodies[id_] for id_ in there]
        poses = [body.pose(begin_s, begin_s) for body in bodies]
        places = np.array([(p.x_m, p.y_m) for p in poses])
        reaches = np.array([body.reach_m + body.fastest_mps * STEP_S for body in bodies])
        gaps = np.linalg.norm(places[:, None] - places, axis=2) - reaches[:, None] - reaches
        near = gaps <= 0
        return [
            (there[a], there[b])
            for a, b in combinations(range(len(there)), 2)
            if near[a, b]
            and not (bodies[a].kind.walks and bodies[b].kind.walks)
            and not (bodies[a].wreck and bodies[b].wreck)
            and (there[a], there[b]) not in self._touched
        ]

    def _touch(self, pair: tuple[str, str], begin_s: float) -> float | None:
        a, b = (self._bodies[id_] for id_ in pair)
        found_s = first_touch(
            lambda time_s: a.pose(begin_s, begin_s + time_s).box(a.size_m),
            lambda time_s: b.pose(begin_s, begin_s + time_s).box(b.size_m),
            closing_mps=a.fastest_mps + b.fastest_mps,
            until_s=STEP_S,
        )
        return None if found_s is None else begin_s + found_s

    def _wreck(self, id_: str, begin_s: float, time_s: float) -> None:
        body = self._bodies[id_]
        if body.wreck is not None:
            return
        body.travelled_m = body.way_m(begin_s, time_s)
        body.wreck = Wreck(body.pose(begin_s, time_s), time_s)
        rest = body.wreck.at(time_s + 10.0)
        half_m = body.size_m[0] / 2
        front = (rest.x_m + half_m * cos(rest.heading_rad), rest.y_m + half_m * sin(rest.heading_rad))
        self._sumo.hold(id_, front, 90.0 - degrees(rest.heading_rad))


def _wrapped(angle_rad: float) -> float:
    return atan2(sin(angle_rad), cos(angle_rad))
