"""Small plants to break in tests."""

from dataclasses import replace
from typing import Any

from rail.build import build_plant
from rail.plant import Plant
from rail.spec import (
    BaliseSpec,
    BufferSpec,
    CrossingSpec,
    PieceSpec,
    PlaceSpec,
    PlantSpec,
    SectionSpec,
    SwitchSpec,
)

METRE = (PieceSpec(line_m=1.0),)


def at(x_m: float, y_m: float, heading_deg: float) -> PlaceSpec:
    return PlaceSpec(x_m, y_m, heading_deg)


def fork() -> PlantSpec:
    """A stem of 1 m to the east, and two branches: straight on, and to the left."""
    return PlantSpec(
        title="fork",
        section={
            "stem": SectionSpec(METRE, at=at(0.0, 0.0, 0.0)),
            "main": SectionSpec(METRE, after="stem.end"),
            "side": SectionSpec((PieceSpec(turn_deg=30.0, radius_m=0.5), *METRE), after="stem.end"),
        },
        switch={"S1": SwitchSpec("stem.end", "main.start", "side.start")},
        buffer={name: BufferSpec(port) for name, port in (("W", "stem.start"), ("E", "main.end"), ("N", "side.end"))},
        balise=(BaliseSpec(0x0001, "stem", 0.5), BaliseSpec(0x0002, "side", 0.3)),
    )


def cross() -> PlantSpec:
    """Two lines of 1 m that cross in the origin."""
    return PlantSpec(
        title="cross",
        section={"a": SectionSpec(METRE, at=at(-0.4, 0.0, 0.0)), "b": SectionSpec(METRE, at=at(0.0, -0.3, 90.0))},
        crossing={"X": CrossingSpec(("a", "b"))},
        buffer={f"{s}{e}": BufferSpec(f"{s}.{e}") for s in "ab" for e in ("start", "end")},
    )


def with_section(spec: PlantSpec, name: str, **changes: Any) -> PlantSpec:
    return replace(spec, section={**spec.section, name: replace(spec.section[name], **changes)})


def built(spec: PlantSpec) -> Plant:
    return build_plant(spec, spec.title)
