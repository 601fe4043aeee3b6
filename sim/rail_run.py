"""One run of the vehicles on a plant, one internal step after the other."""

from math import copysign

import numpy as np

from contracts import Event, EventKind, SwitchState
from contracts.truth import Truth
from rail.graph import advance, metres_to_end
from rail.plant import Balise, Plant
from sim.glide import Glide
from sim.impacts import ImpactWatch, Pair, StepMotion
from sim.lookout import Obstacle, Occupant, obstacle_ahead
from sim.motion_check import initial_states
from sim.motion_spec import MotionSpec, TimedEvent
from sim.streams import stream
from sim.switch_drives import SwitchDrives
from sim.switch_link import request_of
from sim.vehicle import Span, Vehicle

STEP_NS = 5_000_000
STEP_S = STEP_NS * 1e-9


class RailRun:
    """Always at the beginning of an internal step whose motion is already decided.

    The specification must have passed ``sim.motion_check.check_motion``.
    """

    def __init__(self, plant: Plant, spec: MotionSpec, seed: int) -> None:
        self._plant = plant
        self._drives = SwitchDrives(initial_states(plant, spec), round(spec.switch_travel_s * 1e9))
        self._states = self._drives.states
        self._vehicles = [Vehicle.placed(plant, vehicle, self._states) for vehicle in spec.vehicles]
        self._links = [stream(seed, f"link/{vehicle.id}") for vehicle in spec.vehicles]
        self._commands = sorted(spec.events, key=lambda event: event.at_s)[::-1]  # the next one is the last
        self._watch = ImpactWatch()
        self._events: list[Event] = []
        self.begin_ns = 0
        self._spans: list[Span] = []
        self._glides: list[Glide] = []
        self._after_step: list[Vehicle] = []
        self._plan()

    def step(self) -> None:
        """Go on to the beginning of the next step."""
        self._vehicles = self._after_step
        self.begin_ns += STEP_NS
        self._plan()

    def truth(self, index: int, time_ns: int) -> Truth:
        """The state at ``time_ns`` within this step, with the events up to then that were not handed out yet."""
        vehicles = self._vehicles_at((time_ns - self.begin_ns) * 1e-9)
        poses = [vehicle.pose(self._plant, self._states) for vehicle in vehicles]
        velocities = [np.multiply(v.speed_mps, p.velocity_per_speed) for v, p in zip(vehicles, poses, strict=True)]
        happened = tuple(event for event in self._events if event.time_ns <= time_ns)
        self._events = [event for event in self._events if event.time_ns > time_ns]
        return Truth(
            index=index,
            time_ns=time_ns,
            ids=tuple(vehicle.spec.id for vehicle in vehicles),
            labels=tuple(str(vehicle.spec.colour) for vehicle in vehicles),
            positions_m=np.array([(p.centre.x_m, p.centre.y_m, 0.0) for p in poses]).reshape(-1, 3),
            headings_rad=np.array([p.centre.heading_rad for p in poses]),
            sizes_m=np.array([vehicle.spec.size_m for vehicle in vehicles]).reshape(-1, 3),
            velocities_mps=np.array(velocities).reshape(-1, 2),
            places=tuple(vehicle.place for vehicle in vehicles),
            switches=dict(self._states),
            events=happened,
        )

    def _plan(self) -> None:
        """Decide how everything moves in the step that begins now, and note what will happen in it."""
        self._spans = [vehicle.span(self._plant, self._states) for vehicle in self._vehicles]
        while self._commands and round(self._commands[-1].at_s * 1e9) <= self.begin_ns:
            self._obey(self._commands.pop())
        for index in range(len(self._vehicles)):
            self._ask_for_switch(index)
        events = self._moved_switches()
        obstacles = self._obstacles()
        wanted = [v.glide(self.begin_ns * 1e-9, o, STEP_S) for v, o in zip(self._vehicles, obstacles, strict=True)]
        motion = StepMotion(self._plant, self._vehicles, wanted, self._states, STEP_S)
        derailments = self._derailments(motion)
        contacts = self._watch.stop_at_contacts(motion)
        events += self._after_contacts(contacts)
        events += self._after_derailments(derailments, motion)
        self._glides = motion.glides
        events += self._run_through()
        self._events += sorted(events, key=lambda event: event.time_ns)

    def _vehicles_at(self, time_s: float) -> list[Vehicle]:
        moved = zip(self._vehicles, self._glides, strict=True)
        return [vehicle.after(self._plant, glide, time_s, self._states) for vehicle, glide in moved]

    def _obey(self, command: TimedEvent) -> None:
        if command.switch is not None:
            self._drives.ask(command.switch, SwitchState(str(command.set)))
        else:
            self._vehicles = [v.told(command) if v.spec.id == command.vehicle else v for v in self._vehicles]

    def _ask_for_switch(self, index: int) -> None:
        """Send a request once for each approach, if the link carries it."""
        vehicle = self._vehicles[index]
        request = request_of(self._plant, vehicle, vehicle.leading_end(self._spans[index]))
        if request and request.setting and request.switch != vehicle.asked and self._link_carries(index):
            self._drives.ask(request.switch, request.setting)
        self._vehicles[index] = vehicle.having_asked(request.switch if request else None)

    def _link_carries(self, index: int) -> bool:
        spec = self._vehicles[index].spec
        return spec.link == "live" and self._links[index].random() >= spec.link_failure

    def _moved_switches(self) -> list[Event]:
        occupied = frozenset[str]().union(*(span.switches for span in self._spans))
        events = self._drives.update(self.begin_ns, occupied)
        if events:
            self._states = self._drives.states
        return events

    def _obstacles(self) -> list[Obstacle]:
        """What each vehicle that looks ahead sees on its path."""
        pairs = list(zip(self._vehicles, self._spans, strict=True))
        occupants = [Occupant((v.midway, span.nose, span.tail), v.speed_mps) for v, span in pairs]
        return [
            obstacle_ahead(self._plant, v.leading_end(span), self._states, occupants[:k] + occupants[k + 1 :])
            if v.looks_ahead
            else Obstacle()
            for k, (v, span) in enumerate(pairs)
        ]

    def _derailments(self, motion: StepMotion) -> dict[int, float]:
        """Stop each leading end that runs into a buffer stop or a switch that lies against it or moves; and when."""
        times_s: dict[int, float] = {}
        for index, (vehicle, glide) in enumerate(zip(self._vehicles, motion.glides, strict=True)):
            way_m = glide.travelled_m(STEP_S)
            if abs(way_m) < metres_to_end(self._plant, vehicle.leading_end(self._spans[index])):
                continue  # it does not even leave its section
            ahead = advance(self._plant, vehicle.midway, way_m + copysign(vehicle.nose_m, way_m), self._states)
            if way_m != 0.0 and ahead.blocked is not None:
                free_m = max(0.0, abs(ahead.travelled_m) - vehicle.nose_m)
                times_s[index] = glide.time_at(copysign(free_m, way_m))
                motion.stop(index, times_s[index])
        return times_s

    def _after_contacts(self, contacts: dict[Pair, float]) -> list[Event]:
        for index in {index for pair in contacts for index in pair}:
            self._vehicles[index] = self._vehicles[index].halted()
        return [self._event(time_s, EventKind.CONTACT, pair) for pair, time_s in contacts.items()]

    def _after_derailments(self, derailments: dict[int, float], motion: StepMotion) -> list[Event]:
        """Derailments come true where no contact stopped the vehicle before."""
        true = {index: t for index, t in derailments.items() if motion.glides[index].stop_s == t}
        for index in true:
            self._vehicles[index] = self._vehicles[index].wrecked()
        return [self._event(time_s, EventKind.DERAIL, (index,)) for index, time_s in true.items()]

    def _run_through(self) -> list[Event]:
        """Bring the vehicles to the end of the step; the balises they pass on the way."""
        ways = [v.way(self._plant, g, STEP_S, self._states) for v, g in zip(self._vehicles, self._glides, strict=True)]
        self._after_step = [
            vehicle.arrived(way.location, glide.speed_at(STEP_S))
            for vehicle, way, glide in zip(self._vehicles, ways, self._glides, strict=True)
        ]
        return [
            self._event(
                self._glides[k].time_at(copysign(p.distance_m, way.travelled_m)), EventKind.BALISE, (k,), p.subject.name
            )
            for k, way in enumerate(ways)
            for p in way.passages
            if isinstance(p.subject, Balise)
        ]

    def _event(self, time_s: float, kind: EventKind, indices: tuple[int, ...], detail: str = "") -> Event:
        ids = sorted(self._vehicles[k].spec.id for k in indices)
        return Event(self.begin_ns + round(time_s * 1e9), kind, tuple(ids), detail)
