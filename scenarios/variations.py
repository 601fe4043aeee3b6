"""Variants of a scenario: what its ``[vary]`` lets float is drawn from a seed."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from typing import Any

import msgspec
import numpy as np

from contracts import InputError
from scenarios.schema import Range, Scenario
from sim.streams import stream

Value = float | str
_SEEDS = 2**31


def variants(scenario: Scenario, count: int) -> Iterator[Scenario]:
    """The first ``count`` variants; the same each time, and none depends on how many are asked for."""
    for index in range(count):
        rng = stream(scenario.seed, f"vary/{index}")
        seed = int(rng.integers(_SEEDS))
        values = {key: _drawn(choice, rng) for key, choice in sorted(scenario.vary.items())}
        yield replace(varied(scenario, values), name=f"{scenario.name}-{index}", seed=seed, vary={})


def varied(scenario: Scenario, values: Mapping[str, Value]) -> Scenario:
    """``scenario`` with other values at keys such as ``"light"`` or ``"vehicle.blue.start.offset_m"``.

    Entries of lists go by their id or, from 0, by their number. Raises InputError for a key that is not there or a
    value that it cannot take.
    """
    document = msgspec.json.decode(msgspec.json.encode(asdict(scenario)))
    for key, value in values.items():
        _set(document, key, value)
    try:
        return msgspec.convert(document, type(scenario))
    except msgspec.ValidationError as error:
        raise InputError(f"{', '.join(values)} cannot be {', '.join(map(str, values.values()))}: {error}") from error


def _drawn(choice: Range, rng: np.random.Generator) -> Value:
    if choice.any:
        return choice.any[int(rng.integers(len(choice.any)))]
    low, high = choice.extremes
    return float(rng.uniform(float(low), float(high)))


def _set(document: Any, key: str, value: Value) -> None:
    *path, last = key.split(".")
    for step in path:
        document = _child(document, step, key)
    present = _child(document, last, key)
    document[last] = round(value) if isinstance(present, int) and isinstance(value, float) else value


def _child(document: Any, step: str, key: str) -> Any:
    """What lies under ``step``: a key of a table, or an entry of a list."""
    children = document
    if isinstance(document, list):
        children = {str(number): entry for number, entry in enumerate(document)}
        children |= {entry["id"]: entry for entry in document if "id" in entry}
    if not isinstance(children, dict) or step not in children:
        known = ", ".join(children) if isinstance(children, dict) else "none"
        raise InputError(f"there is no {step!r} in {key!r}; there are {known}")
    return children[step]
