"""Scenario files by name: found, read, checked."""

import tomllib
from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path

from contracts import InputError
from scenarios.check import faults
from scenarios.schema import SCENARIO_TYPES, RailScenario, Scenario
from scenarios.toml_file import dotted, line_of_key, read_toml
from scenarios.worlds import build_world

__all__ = ["LIBRARY", "build_world", "list_scenarios", "load_scenario"]

LIBRARY = Path(__file__).parent / "library"


def list_scenarios(library: Path = LIBRARY) -> tuple[str, ...]:
    """Names of the scenarios in ``library``, sorted."""
    return tuple(sorted(path.stem for path in library.glob("*.toml")))


def load_scenario(name_or_path: str | Path) -> Scenario:
    """The scenario of that name in the library, or in the file of that path.

    Raises InputError naming file, line, key and the accepted values.
    """
    path = _path_of(name_or_path)
    scenario = read_toml(path, _type_of(path))
    if scenario.name not in ("", path.stem):
        raise InputError(
            f"{path}: key name: {scenario.name!r} differs from the file's name {path.stem!r}; leave it out"
        )
    for keys, what in faults(scenario):
        line = line_of_key(path.read_text(encoding="utf-8"), keys)
        raise InputError(f"{path}, line {line}: key {dotted(keys)}: {what}")
    return replace(scenario, name=path.stem)


def _type_of(path: Path) -> type[Scenario]:
    """What a file holds, by its key ``world``; a railway if there is none, or if the file cannot be read at all."""
    try:
        text = path.read_text(encoding="utf-8")
        world = tomllib.loads(text).get("world", "rail")
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return RailScenario  # whose reader says what is wrong
    if not isinstance(world, str) or world not in SCENARIO_TYPES:
        line = line_of_key(text, ("world",))
        raise InputError(f"{path}, line {line}: key world: {world!r} is unknown; accepted: {', '.join(SCENARIO_TYPES)}")
    return SCENARIO_TYPES[world]


def _path_of(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.suffix == ".toml" or path.parent != Path():
        return path
    if not (LIBRARY / f"{path}.toml").is_file():
        raise InputError(f"there is no scenario {str(path)!r}; {_nearest(str(path), list_scenarios())}")
    return LIBRARY / f"{path}.toml"


def _nearest(name: str, names: Sequence[str]) -> str:
    near = get_close_matches(name, names, n=3, cutoff=0.4)
    return f"nearest: {', '.join(near)}" if near else f"known: {', '.join(names) or 'none'}"
