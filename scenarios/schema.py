"""What a scenario file may say. The keys are documented here; ``scenarios.loader`` reads and checks files."""

import math
from dataclasses import dataclass, field
from typing import Annotated, Literal

from msgspec import Meta

from contracts import InputError
from sim.air import Weather
from sim.floor import FloorSpec
from sim.highlights import HighlightSpec
from sim.light_program import LightChange
from sim.lights import LightPreset
from sim.motion_spec import MotionSpec, SwitchSetting, TimedEvent, VehicleSpec
from sim.sensor import SensorSpec
from sim.surroundings import BridgeSpec, ObjectSpec, Surroundings
from sim.traffic_spec import DriverSpec, RoadEvent, TrafficSpec, WalkerSpec

MAX_FPS = 1000.0


@dataclass(frozen=True)
class Bound:
    """Limits that a score must keep; at least one."""

    min: float | None = None
    max: float | None = None

    def __post_init__(self) -> None:
        if self.min is None and self.max is None:
            raise InputError("a bound needs min, max or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise InputError(f"min = {self.min} exceeds max = {self.max}")

    def holds(self, value: float) -> bool:
        """Whether ``value`` keeps the limits; NaN does not."""
        above = self.min is None or value >= self.min
        return above and (self.max is None or value <= self.max) and not math.isnan(value)


@dataclass(frozen=True)
class Expect:
    """What must come out.

    contact: exactly these pairs of vehicles touch.
    derail: exactly these vehicles derail.
    scores: limits by the name of the score, for example ``"ground.rms_x_m" = { max = 0.003 }``.
    """

    contact: tuple[tuple[str, str], ...] = ()
    derail: tuple[str, ...] = ()
    scores: dict[str, Bound] = field(default_factory=dict)


@dataclass(frozen=True)
class Range:
    """Values that a key takes in the variants: uniform between ``min`` and ``max``, or one of ``any``."""

    min: float | None = None
    max: float | None = None
    any: tuple[float | str, ...] = ()

    def __post_init__(self) -> None:
        if bool(self.any) == (self.min is not None and self.max is not None) or (self.min is None) != (
            self.max is None
        ):
            raise InputError("a range to vary needs min and max, or any = [values]")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise InputError(f"min = {self.min} exceeds max = {self.max}")

    @property
    def extremes(self) -> tuple[float | str, ...]:
        """Both ends, or all values."""
        return self.any if self.min is None or self.max is None else (self.min, self.max)


@dataclass(frozen=True)
class Scenario:
    """What every scenario says; a file holds a ``RailScenario`` or a ``RoadScenario``.

    name: the file's name without ``.toml``; filled in by the loader.
    rig: name of a file in ``scenarios/rigs``.
    split: whether models may learn from it (``"train"``) or it is kept for the test (``"test"``); neither if not said.
    light: at the beginning. light_change: other lights that come up later, in order (``sim.light_program``).
    vary: ranges by key, for example ``"vehicle.blue.speed_mps" = { min = 0.2, max = 0.4 }``.
    """

    title: str
    rig: str
    light: LightPreset
    seed: Annotated[int, Meta(ge=0)]
    duration_s: Annotated[float, Meta(gt=0)]
    fps: Annotated[float, Meta(gt=0, le=MAX_FPS)]
    name: str = ""
    world: str = ""
    light_change: tuple[LightChange, ...] = ()
    split: Literal["train", "test"] | None = None
    expect: Expect = field(default_factory=Expect)
    vary: dict[str, Range] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise InputError(f"seed = {self.seed} must not be negative")
        if not (math.isfinite(self.duration_s) and self.duration_s > 0):
            raise InputError(f"duration_s = {self.duration_s} must be finite and positive")
        if not 0 < self.fps <= MAX_FPS:
            raise InputError(f"fps = {self.fps} must lie in (0, {MAX_FPS:.0f}]")

    @property
    def actors(self) -> tuple[str, ...]:
        """Ids of all whom the author names."""
        return ()

    @property
    def event_times_s(self) -> tuple[float, ...]:
        """When the author's events happen, in the order of the file."""
        return ()

    @property
    def frame_count(self) -> int:
        """Number of frames of each camera; the first is taken at time 0."""
        return max(1, round(self.duration_s * self.fps))

    @property
    def frame_times_ns(self) -> tuple[int, ...]:
        """Mid-exposure of each frame."""
        return tuple(round(k * 1e9 / self.fps) for k in range(self.frame_count))


@dataclass(frozen=True, kw_only=True)
class RailScenario(Scenario):
    """A scenario of the model railway.

    plant: name of a file in ``scenarios/plants``.
    sensor: of all cameras, instead of the rig's: noise, exposure, drift of the white balance (``sim.sensor``).
    floor: colour and contrast of the floor (``sim.floor``).
    object, bridge: what lies, stands or spans the track (``sim.surroundings``); marks and clutter make room for it.
    highlight: mirror images of lamps in floor and roofs (``sim.highlights``).
    switch: how switches lie at the beginning, by id; straight where not said.
    """

    plant: str
    world: Literal["rail"] = "rail"
    sensor: SensorSpec | None = None
    floor: FloorSpec = field(default_factory=FloorSpec)
    object: tuple[ObjectSpec, ...] = ()
    bridge: tuple[BridgeSpec, ...] = ()
    highlight: tuple[HighlightSpec, ...] = ()
    switch: dict[str, SwitchSetting] = field(default_factory=dict)
    switch_travel_s: float = 0.25
    vehicle: tuple[VehicleSpec, ...] = ()
    event: tuple[TimedEvent, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.motion  # its checks are ours

    @property
    def motion(self) -> MotionSpec:
        """What moves."""
        return MotionSpec(self.vehicle, self.event, self.switch, self.switch_travel_s)

    @property
    def surroundings(self) -> Surroundings:
        """What the author put round the track."""
        return Surroundings(self.floor, self.object, self.bridge, self.highlight)

    @property
    def actors(self) -> tuple[str, ...]:
        """Ids of the vehicles."""
        return tuple(vehicle.id for vehicle in self.vehicle)

    @property
    def event_times_s(self) -> tuple[float, ...]:
        """When the events happen."""
        return tuple(event.at_s for event in self.event)


@dataclass(frozen=True, kw_only=True)
class RoadScenario(Scenario):
    """A scenario of road traffic.

    network: name of a folder in ``scenarios/networks``.
    density: of the network's own traffic: 0 none, 1 as the network's file says.
    weather: ``dry``, ``wet``, ``rain`` or ``fog`` (``sim.air``).
    sensor: of all cameras, instead of the rig's: a night asks for a long exposure and much gain (``sim.sensor``).
    map_sigma_m: how far features of the owners' map lie from the road's own, standard deviation per axis.
    vehicle, walker: who does what the author says, beside that traffic.
    """

    network: str
    world: Literal["road"] = "road"
    density: float = 1.0
    weather: Weather = Weather.DRY
    sensor: SensorSpec | None = None
    map_sigma_m: Annotated[float, Meta(ge=0)] = 0.0
    vehicle: tuple[DriverSpec, ...] = ()
    walker: tuple[WalkerSpec, ...] = ()
    event: tuple[RoadEvent, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.traffic  # its checks are ours

    @property
    def traffic(self) -> TrafficSpec:
        """Who is on the road."""
        return TrafficSpec(self.vehicle, self.walker, self.event, self.density)

    @property
    def actors(self) -> tuple[str, ...]:
        """Ids of the vehicles and walkers."""
        return tuple(one.id for one in self.vehicle) + tuple(one.id for one in self.walker)

    @property
    def event_times_s(self) -> tuple[float, ...]:
        """When the events happen."""
        return tuple(event.at_s for event in self.event)


SCENARIO_TYPES: dict[str, type[Scenario]] = {"rail": RailScenario, "road": RoadScenario}
