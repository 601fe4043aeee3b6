"""SUMO, step by step: who is where. One simulation per process, because libsumo is a single global one.

The options make the simulation exact: nobody is teleported, a collision changes nothing (Gantry finds contacts itself,
from the truth), junctions are shared as the right of way says, and who changes lanes drives across, never slides.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import libsumo

from contracts import InputError
from sim.road_network import RoadNetwork
from sim.road_users import KINDS, Size, room_m, types_xml
from sim.traffic_spec import WARM_UP_S, DriverSpec, RoadEvent, TrafficSpec
from sim.user_sizes import Sizes

STEP_S = 0.05
_LATERAL_RESOLUTION_M = 0.8  # of the strips into which lanes are parted, so that a change of lane is a way across
_CAREFUL = 31  # SUMO's speed mode: safe speed 1, acceleration 2, braking 4, right of way 8, red lights 16
_MODES = {"vehicles": -1, "right_of_way": -8 + 32, "signals": 0}  # 32: also on the junction


@dataclass(frozen=True)
class Sample:
    """Where SUMO has somebody: front end (x, y, z), compass angle and slope in degrees; the kind, and the size."""

    front_m: tuple[float, float, float]
    angle_deg: float
    slope_deg: float
    kind: str
    size_m: Size


class SumoRun:
    """A running simulation, begun ``WARM_UP_S`` before the run's time 0; use it in a ``with`` statement.

    Raises InputError if another one runs in this process, or SUMO refuses the network or a route.
    """

    def __init__(self, network: RoadNetwork, routes: Path | None, spec: TrafficSpec, seed: int) -> None:
        self._network, self._routes, self._spec, self._seed = network, routes, spec, seed
        self._sizes = Sizes(seed)
        self._known: dict[str, tuple[str, Size]] = {}
        self._modes = {driver.id: _speed_mode(driver) for driver in spec.drivers}
        self._braking: dict[str, float] = {}
        self._held: dict[str, tuple[tuple[float, float], float]] = {}

    def __enter__(self) -> "SumoRun":
        if libsumo.isLoaded():
            raise InputError("SUMO runs already in this process and can run only once: finish or close that run first")
        with tempfile.TemporaryDirectory() as directory:
            types = Path(directory) / "types.add.xml"
            types.write_text(types_xml({_own_type(d): (d.kind, _habits(d)) for d in self._spec.drivers}), "utf-8")
            try:
                libsumo.start(self._command(types))
                for driver in self._spec.drivers:
                    _enter(driver)
            except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
                self._close()
                raise InputError(f"SUMO refuses {self._network.path.name}: {error}") from error
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._close()

    def step(self) -> dict[str, Sample]:
        """One step on; where everybody is who is on the road."""
        for id_, (front_m, angle_deg) in self._held.items():
            _hold(id_, front_m, angle_deg)
        there = set(libsumo.vehicle.getIDList())
        for id_, braking_mps2 in self._braking.items():
            if id_ in there:
                libsumo.vehicle.setSpeed(id_, max(0.0, libsumo.vehicle.getSpeed(id_) - braking_mps2 * STEP_S))
        libsumo.simulationStep()
        vehicles, persons = libsumo.vehicle, libsumo.person
        return {id_: self._sample(vehicles, id_) for id_ in vehicles.getIDList()} | {
            id_: self._sample(persons, id_) for id_ in persons.getIDList()
        }

    def obey(self, event: RoadEvent) -> None:
        """Brake or go on."""
        if event.vehicle not in libsumo.vehicle.getIDList():
            return
        if event.do == "brake":
            self._braking[event.vehicle] = event.braking_mps2
            libsumo.vehicle.setSpeedMode(event.vehicle, 0)
            return
        self._braking.pop(event.vehicle, None)
        libsumo.vehicle.setSpeed(event.vehicle, -1.0)
        libsumo.vehicle.setSpeedMode(event.vehicle, self._modes[event.vehicle])

    def hold(self, id_: str, front_m: tuple[float, float], angle_deg: float) -> None:
        """Keep somebody where a contact left them, so that the others see them there."""
        self._held[id_] = (front_m, angle_deg)

    def _sample(self, domain: type, id_: str) -> Sample:
        if id_ not in self._known:
            self._known[id_] = self._measured(domain, id_)
        x, y, z = domain.getPosition3D(id_)  # type: ignore[attr-defined]
        return Sample((x, y, z), domain.getAngle(id_), domain.getSlope(id_), *self._known[id_])  # type: ignore[attr-defined]

    def _measured(self, domain: type, id_: str) -> tuple[str, Size]:
        """Kind and size of somebody new; SUMO is told the size, which gives them a vehicle type of their own."""
        kind = domain.getTypeID(id_).split("@")[0]  # type: ignore[attr-defined]
        size_m = self._sizes.of(kind, id_)
        length, width, height = room_m(KINDS[kind], size_m)
        domain.setLength(id_, length)  # type: ignore[attr-defined]
        domain.setWidth(id_, width)  # type: ignore[attr-defined]
        domain.setHeight(id_, height)  # type: ignore[attr-defined]
        return kind, size_m

    def _command(self, types: Path) -> list[str]:
        files = ["-n", str(self._network.path), "-a", str(types)]
        if self._routes is not None and self._spec.density > 0:
            files += ["-r", str(self._routes)]
        options = {
            "step-length": STEP_S,
            "seed": self._seed % 2**31,
            "scale": self._spec.density,
            "lateral-resolution": _LATERAL_RESOLUTION_M,
            "collision.mingap-factor": 0,
            "collision.action": "none",
            "time-to-teleport": -1,
            "no-warnings": "true",
            "no-step-log": "true",
            "xml-validation": "never",
            "xml-validation.net": "never",
            "xml-validation.routes": "never",
        }
        return ["sumo", *files, *(text for key, value in options.items() for text in (f"--{key}", str(value)))]

    def _close(self) -> None:
        if libsumo.isLoaded():
            libsumo.close()


def _own_type(driver: DriverSpec) -> str:
    return f"{driver.kind}@{driver.id}"


def _habits(driver: DriverSpec) -> dict[str, str]:
    """SUMO's attributes of a driver whom the author describes: exact, and careless where told to be."""
    habits = {"sigma": "0", "speedDev": "0"}
    if driver.top_speed_mps is not None:
        habits["maxSpeed"] = str(driver.top_speed_mps)
    if "signals" in driver.ignores:
        habits |= {"jmDriveAfterRedTime": "1e6", "jmDriveAfterYellowTime": "1e6"}
    if "right_of_way" in driver.ignores:
        habits |= {"jmIgnoreFoeProb": "1", "jmIgnoreFoeSpeed": "1e3", "jmIgnoreJunctionFoeProb": "1"}
    return habits


def _enter(driver: DriverSpec) -> None:
    libsumo.route.add(f"route/{driver.id}", list(driver.route))
    libsumo.vehicle.add(
        driver.id,
        f"route/{driver.id}",
        _own_type(driver),
        depart=str(driver.depart_s + WARM_UP_S),
        departLane="best" if driver.lane is None else str(driver.lane),
        departPos=str(driver.offset_m),
        departSpeed=str(driver.speed_mps),
    )
    libsumo.vehicle.setSpeedMode(driver.id, _speed_mode(driver))


def _speed_mode(driver: DriverSpec) -> int:
    return _CAREFUL + sum(_MODES[what] for what in set(driver.ignores))


def _hold(id_: str, front_m: tuple[float, float], angle_deg: float) -> None:
    x, y = front_m
    if id_ in libsumo.vehicle.getIDList():
        libsumo.vehicle.setSpeedMode(id_, 0)
        libsumo.vehicle.setSpeed(id_, 0.0)
        libsumo.vehicle.moveToXY(id_, "", -1, x, y, angle_deg, 2)
    elif id_ in libsumo.person.getIDList():
        libsumo.person.moveToXY(id_, "", x, y, angle_deg, 2)
