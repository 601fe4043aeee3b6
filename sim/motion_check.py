"""Whether a specification of motion fits a plant: each fault with the key at which it stands."""

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import combinations

from contracts import InputError, SwitchState
from rail.graph import SwitchStates
from rail.plant import Plant, known
from sim.boxes import separation_m
from sim.contacts import TOUCH_M
from sim.drivers import driver_of
from sim.motion_spec import MotionSpec
from sim.vehicle import Vehicle, start_location

KeyPath = tuple[str | int, ...]


class MotionFaultError(InputError):
    """A specification that the plant cannot serve.

    keys: where the fault stands, in the words of a scenario file: ``("vehicle", 0, "start", "section")``.
    """

    def __init__(self, keys: KeyPath, what: str) -> None:
        super().__init__(what)
        self.keys = keys


def initial_states(plant: Plant, spec: MotionSpec) -> dict[str, SwitchState]:
    """How the switches lie at the beginning."""
    settings = {switch: SwitchState(setting) for switch, setting in spec.switches.items()}
    return dict.fromkeys(plant.switches, SwitchState.STRAIGHT) | settings


def check_motion(plant: Plant, spec: MotionSpec) -> None:
    """Raise MotionFaultError for the first thing in ``spec`` that ``plant`` does not have or that cannot be."""
    for switch in spec.switches:
        with _at("switch", switch):
            plant.switch(switch)
    _check_vehicles(plant, spec)
    _check_events(plant, spec)
    _check_starts(plant, spec, initial_states(plant, spec))


def _check_vehicles(plant: Plant, spec: MotionSpec) -> None:
    for index, vehicle in enumerate(spec.vehicles):
        with _at("vehicle", index, "start", "section"):
            plant.section(vehicle.start.section)
        with _at("vehicle", index, "start"):
            start_location(plant, vehicle.start)
        with _at("vehicle", index, "behaviour"):
            driver_of(vehicle)
        for switch in vehicle.route:
            with _at("vehicle", index, "route", switch):
                plant.switch(switch)


def _check_events(plant: Plant, spec: MotionSpec) -> None:
    ids = [vehicle.id for vehicle in spec.vehicles]
    for index, event in enumerate(spec.events):
        if event.switch is not None:
            with _at("event", index, "switch"):
                plant.switch(event.switch)
        if event.vehicle is not None:
            with _at("event", index, "vehicle"):
                known(event.vehicle, ids, "vehicle")


def _check_starts(plant: Plant, spec: MotionSpec, states: SwitchStates) -> None:
    """All vehicles stand on free track and apart from each other."""
    boxes = []
    for index, vehicle in enumerate(spec.vehicles):
        with _at("vehicle", index, "start"):
            boxes.append(Vehicle.placed(plant, vehicle, states).box(plant, states))
    for a, b in combinations(range(len(boxes)), 2):
        if separation_m(boxes[a], boxes[b]) <= TOUCH_M:
            names = f"{spec.vehicles[b].id} and {spec.vehicles[a].id}"
            raise MotionFaultError(("vehicle", b, "start"), f"vehicles {names} touch at the start; move one of them")


@contextmanager
def _at(*keys: str | int) -> Iterator[None]:
    """Say at which key an InputError stands."""
    try:
        yield
    except InputError as error:
        raise MotionFaultError(keys, str(error)) from error
