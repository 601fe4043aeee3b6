"""Small worlds to move in, and what a run of them says."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from contracts import Event, EventKind
from contracts.truth import Truth
from rail.build import build_plant
from rail.plant import Plant
from rail.spec import BaliseSpec, BufferSpec, PieceSpec, PlaceSpec, PlantSpec, SectionSpec, SwitchSpec
from sim.boxes import Box
from sim.colours import Colour
from sim.motion_spec import Heading, MotionSpec, Start, TimedEvent, VehicleSpec
from sim.rail_motion import RailMotion


def fork() -> Plant:
    """A stem of 2 m to the east, then 2 m straight on, or to the left; buffer stops at all ends.

    The line starts 2 m west of the origin, so that the toe of S1 is the origin and x runs along the track.
    """
    metres = (PieceSpec(line_m=2.0),)
    return build_plant(
        PlantSpec(
            title="fork",
            section={
                "stem": SectionSpec(metres, at=PlaceSpec(-2.0, 0.0, 0.0)),
                "main": SectionSpec(metres, after="stem.end"),
                "side": SectionSpec((PieceSpec(turn_deg=40.0, radius_m=0.5), *metres), after="stem.end"),
            },
            switch={"S1": SwitchSpec("stem.end", "main.start", "side.start")},
            buffer={
                name: BufferSpec(f"{name}.{'start' if name == 'stem' else 'end'}") for name in ("stem", "main", "side")
            },
            balise=(BaliseSpec(0x0001, "stem", 0.5), BaliseSpec(0x0002, "main", 0.3), BaliseSpec(0x0003, "side", 0.3)),
        ),
        "fork",
    )


FORK = fork()


def vehicle(
    section: str = "stem", offset_m: float = 1.0, heading: str = "forward", *, colour: str = "red", **keys: Any
) -> VehicleSpec:
    speed_mps = keys.pop("speed_mps", 0.4)
    start = Start(section, offset_m, Heading(heading))
    return VehicleSpec(id=colour, colour=Colour(colour), start=start, speed_mps=speed_mps, **keys)


def run(
    *vehicles: VehicleSpec, events: Sequence[TimedEvent] = (), until_s: float, step_s: float = 0.02, **keys: Any
) -> list[Truth]:
    """Truth from 0 to ``until_s`` on the fork."""
    motion = RailMotion(FORK, MotionSpec(vehicles, tuple(events), **keys), seed=1)
    return list(motion.run(times(until_s, step_s)))


def times(until_s: float, step_s: float) -> list[int]:
    return [round(k * step_s * 1e9) for k in range(round(until_s / step_s) + 1)]


def happened(truths: Sequence[Truth], kind: EventKind | None = None) -> list[Event]:
    return [event for truth in truths for event in truth.events if kind in (None, event.kind)]


def seconds(event: Event) -> float:
    return event.time_ns * 1e-9


def speeds(truths: Sequence[Truth]) -> np.ndarray:
    """(T, N) without sign."""
    return np.array([np.hypot(*truth.velocities_mps.T) for truth in truths])


def footprints(truth: Truth) -> list[Box]:
    rows = zip(truth.positions_m, truth.headings_rad, truth.sizes_m, strict=True)
    return [Box(p[0], p[1], heading, size[0], size[1]) for p, heading, size in rows]
