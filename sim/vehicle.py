"""One vehicle as it runs: where it is, how fast, and what it was told."""

from dataclasses import dataclass, replace
from math import copysign, cos, isfinite, pi

from contracts import InputError
from contracts.truth import Place
from rail.graph import Advance, Location, SwitchStates, advance, check_location, pose_at
from rail.plant import Plant, Switch
from sim.boxes import Box
from sim.drivers import Driver, Outlook, blind, driver_of
from sim.glide import Glide
from sim.lookout import Obstacle
from sim.motion_spec import Heading, Start, TimedEvent, VehicleSpec
from sim.running_gear import MAX_AXLE_GAIN, BodyPose, body_pose, reach

_COMPASS_RAD = {Heading.EAST: 0.0, Heading.NORTH: pi / 2, Heading.WEST: pi, Heading.SOUTH: -pi / 2}
_ACROSS = 0.05  # cosine below which a track runs across a compass direction
_AT_REST_MPS = 1e-12  # rounding left over from braking


@dataclass(frozen=True)
class Span:
    """The track beneath a body.

    nose, tail: its ends, looking the way the vehicle faces. switches: those whose toes lie between them.
    """

    nose: Location
    tail: Location
    switches: frozenset[str]


@dataclass(frozen=True)
class Vehicle:
    """The state of one vehicle at the beginning of an internal step.

    midway: on the track, midway between the axles, looking the way the vehicle faces.
    speed_mps, commanded_mps: along the track, positive the way it faces.
    cruise_mps: the last command that was not to stand; what "reverse" turns round.
    derailed: it stands for good. asked: the switch that it asked for last on this approach.
    """

    spec: VehicleSpec
    driver: Driver
    midway: Location
    speed_mps: float
    commanded_mps: float
    cruise_mps: float
    derailed: bool = False
    asked: str | None = None

    @classmethod
    def placed(cls, plant: Plant, spec: VehicleSpec, states: SwitchStates) -> "Vehicle":
        """At its start; InputError if the plant has no such place or the way beneath the vehicle is interrupted."""
        speed_mps = spec.speed_mps
        vehicle = cls(spec, driver_of(spec), start_location(plant, spec.start), speed_mps, speed_mps, speed_mps)
        for ahead_m in (vehicle.nose_m, -vehicle.nose_m):
            if blocked := advance(plant, vehicle.midway, ahead_m, states).blocked:
                raise InputError(
                    f"vehicle {spec.id}: {vehicle.nose_m:.3f} m of free track are needed on both sides of its start, "
                    f"but {blocked.subject} ({blocked.kind}) is nearer"
                )
        return vehicle

    @property
    def sense(self) -> int:
        """+1 if it runs, or is about to run, the way it faces, else -1."""
        return -1 if (self.speed_mps or self.commanded_mps) < 0 else 1

    @property
    def nose_m(self) -> float:
        """Track between its centre and either end of the body."""
        return max(self.spec.size_m[0] / 2.0, MAX_AXLE_GAIN * self.spec.wheelbase_m / 2.0)

    @property
    def reach(self) -> float:
        """How far any point of the body moves for each metre along the track, at most."""
        return reach(self.spec.size_m[0], self.spec.size_m[1], self.spec.wheelbase_m)

    @property
    def place(self) -> Place:
        """Section, offset and direction of its centre."""
        return Place(self.midway.section, self.midway.offset_m, self.midway.direction)

    def pose(self, plant: Plant, states: SwitchStates) -> BodyPose:
        """Where the body is."""
        return body_pose(plant, self.midway, states, self.spec.wheelbase_m)

    def box(self, plant: Plant, states: SwitchStates) -> Box:
        """The footprint."""
        centre = self.pose(plant, states).centre
        return Box(centre.x_m, centre.y_m, centre.heading_rad, self.spec.size_m[0], self.spec.size_m[1])

    def span(self, plant: Plant, states: SwitchStates) -> Span:
        """The track beneath the body."""
        ahead, behind = (advance(plant, self.midway, way_m, states) for way_m in (self.nose_m, -self.nose_m))
        toes = (passage.subject for passage in (*ahead.passages, *behind.passages))
        return Span(ahead.location, behind.location, frozenset(toe.id for toe in toes if isinstance(toe, Switch)))

    def leading_end(self, span: Span) -> Location:
        """The end of the body that goes first, looking the way it goes."""
        return span.nose if self.sense > 0 else span.tail.reversed()

    def glide(self, time_s: float, obstacle: Obstacle, step_s: float) -> Glide:
        """How it moves during the next step: what its driver wants, within its limits."""
        if self.derailed:
            return Glide(0.0, 0.0)
        outlook = Outlook(
            time_s, self.spec, self.commanded_mps, self.speed_mps, obstacle.distance_m, obstacle.speed_mps
        )
        wanted = self.driver(outlook)
        if not isfinite(wanted):
            raise InputError(f"vehicle {self.spec.id}: its behaviour wants a speed of {wanted} m/s")
        if wanted * self.speed_mps < 0.0:
            wanted = 0.0  # stop first
        slower = abs(wanted) < abs(self.speed_mps)
        limit = self.spec.braking_mps2 if slower else self.spec.acceleration_mps2
        change = wanted - self.speed_mps
        return Glide(self.speed_mps, copysign(min(abs(change) / step_s, limit), change))

    @property
    def looks_ahead(self) -> bool:
        """Whether its driver cares for what is ahead."""
        return self.driver is not blind and not self.derailed

    def having_asked(self, switch: str | None) -> "Vehicle":
        """The vehicle on its approach to ``switch``."""
        return self if switch == self.asked else replace(self, asked=switch)

    def halted(self) -> "Vehicle":
        """The vehicle after an impact: it stays where it is until told otherwise."""
        return replace(self, commanded_mps=0.0)

    def wrecked(self) -> "Vehicle":
        """The vehicle after it has derailed: it stands for good."""
        return replace(self, derailed=True)

    def told(self, command: TimedEvent) -> "Vehicle":
        """The vehicle after a command of the scenario."""
        if command.do == "stop" or command.speed_mps == 0.0:
            return replace(self, commanded_mps=0.0)
        cruise_mps = -self.cruise_mps if command.speed_mps is None else command.speed_mps
        return replace(self, commanded_mps=cruise_mps, cruise_mps=cruise_mps)

    def way(self, plant: Plant, glide: Glide, time_s: float, states: SwitchStates) -> Advance:
        """What it runs through up to ``time_s`` into ``glide``."""
        return advance(plant, self.midway, glide.travelled_m(time_s), states)

    def arrived(self, midway: Location, speed_mps: float) -> "Vehicle":
        """The vehicle at another place."""
        return replace(self, midway=midway, speed_mps=0.0 if abs(speed_mps) < _AT_REST_MPS else speed_mps)

    def after(self, plant: Plant, glide: Glide, time_s: float, states: SwitchStates) -> "Vehicle":
        """The vehicle ``time_s`` into ``glide``."""
        return self.arrived(self.way(plant, glide, time_s, states).location, glide.speed_at(time_s))


def start_location(plant: Plant, start: Start) -> Location:
    """The place on the track that ``start`` means; InputError where there is none."""
    section = plant.section(start.section)
    location = check_location(plant, Location(section.id, start.offset_m, 1))
    if start.heading is Heading.FORWARD:
        return location
    if start.heading is Heading.BACKWARD:
        return location.reversed()
    pose = pose_at(plant, location)
    cosine = cos(pose.heading_rad - _COMPASS_RAD[start.heading])
    if abs(cosine) < _ACROSS:
        raise InputError(
            f"section {section.id!r} runs across {start.heading} at {start.offset_m} m; give forward, backward or "
            f"{', '.join(h for h, a in _COMPASS_RAD.items() if abs(cos(pose.heading_rad - a)) >= _ACROSS)}"
        )
    return location if cosine > 0 else location.reversed()
