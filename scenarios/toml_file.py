"""TOML files read strictly into frozen dataclasses; every failure is one sentence with file, line and key."""

import dataclasses
import math
import re
import tomllib
import types
from difflib import get_close_matches
from enum import Enum
from pathlib import Path
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec
import numpy as np

from contracts import InputError

T = TypeVar("T")
KeyPath = tuple[str | int, ...]

_FAULT_PLACE = re.compile(r"(?P<what>.*?)(?: - at `\$(?P<where>.*)`)?", re.DOTALL)
_STEP = re.compile(r"\.(?P<key>[^.\[\]]+)|\[(?P<index>\d+|\.\.\.)\]")
_HEADER = re.compile(r"\s*(?P<open>\[\[?)\s*(?P<name>[^\[\]]+?)\s*\]\]?\s*(#.*)?$")
_ASSIGNMENT = re.compile(r"\s*(?P<key>[\w.\-\"']+)\s*=")


class _KeyFaultError(ValueError):
    """What is wrong with the value at one key."""

    def __init__(self, keys: KeyPath, what: str) -> None:
        super().__init__(what)
        self.keys = keys


def read_toml(path: Path, type_: type[T]) -> T:
    """Read ``path`` into the dataclass ``type_``: no unknown key, no conversion of strings, no NaN or infinity.

    Fields may be dataclasses, tuples, lists, mappings by name, enumerations, literals, optional values and
    NumPy arrays; ``__post_init__`` may refuse values with ValueError (so with InputError).
    Raises InputError naming file, line, key and the accepted keys or values.
    """
    try:
        text = path.read_text(encoding="utf-8")
        document = tomllib.loads(text)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no UTF-8 text, so no TOML: {error.reason} at byte {error.start}") from error
    except tomllib.TOMLDecodeError as error:
        what, _, place = str(error).rpartition(" (at ")
        stated = re.search(r"line (\d+)", place)  # tomllib says "end of document" for the last one
        raise InputError(
            f"{path}, line {stated[1] if stated else len(text.splitlines())}: is not TOML: {what}"
        ) from error
    try:
        _check_keys(document, type_, ())
        return _convert(document, type_)
    except _KeyFaultError as fault:
        line = line_of_key(text, fault.keys)
        key = f"key {dotted(fault.keys)}: " if fault.keys else ""
        raise InputError(f"{path}, line {line}: {key}{fault}") from fault


def line_of_key(text: str, keys: KeyPath) -> int:
    """Line (from 1) of TOML ``text`` on which the value at ``keys`` is set.

    If that key stands on no line of its own (it is missing, or inside an inline table), the line of the innermost table
    or key around it; 1 if there is none.
    """
    lines = _lines_by_key(text)
    return next((lines[keys[:n]] for n in range(len(keys), 0, -1) if keys[:n] in lines), 1)


def _convert(document: dict[str, Any], type_: type[T]) -> T:
    """``document`` as ``type_``; msgspec's complaint becomes a _KeyFaultError."""
    try:
        return msgspec.convert(document, type_, strict=True, dec_hook=_array_from_list)
    except msgspec.ValidationError as error:
        match = _FAULT_PLACE.fullmatch(str(error))
        assert match is not None
        keys = _keys_at(match["where"] or "", document, type_)
        what = match["what"].replace("`", "").replace("Object missing required field", "lacks the key")
        accepted = _accepted_values(_type_at(type_, keys))
        raise _KeyFaultError(
            keys, what[:1].lower() + what[1:] + (f"; accepted: {accepted}" if accepted else "")
        ) from error


def _keys_at(where: str, document: Any, type_: Any) -> KeyPath:
    """The keys that msgspec's ``.key[index]`` means; for its ``[...]``, some entry of a mapping, the first bad one."""
    keys: list[str | int] = []
    for step in _STEP.finditer(where):
        key: str | int = step["key"] or step["index"]
        if key == "...":
            key = next(name for name, value in document.items() if not _fits(value, _child_type(type_, name)))
        elif step["index"]:
            key = int(key)
        document, type_ = document[key], _child_type(type_, key)
        keys.append(key)
    return tuple(keys)


def _fits(value: Any, type_: Any) -> bool:
    try:
        msgspec.convert(value, type_, strict=True, dec_hook=_array_from_list)
    except msgspec.ValidationError:
        return False
    return True


def _array_from_list(type_: Any, value: Any) -> Any:
    """Hook of msgspec for types that it does not know: NumPy arrays of numbers."""
    if (get_origin(type_) or type_) is not np.ndarray:
        raise NotImplementedError(type_)
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"expected an array of numbers, got {value!r}") from error


def _check_keys(value: Any, type_: Any, keys: KeyPath) -> None:
    """Refuse keys that no dataclass under ``type_`` has, and numbers that are not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        raise _KeyFaultError(keys, f"{value} is no usable number; give a finite one")
    children: list[tuple[str | int, Any]] = []
    if isinstance(value, dict):
        names = _field_names(type_)
        for key in value:
            if names and key not in names:
                near = get_close_matches(key, names, n=3, cutoff=0.5) or names
                raise _KeyFaultError((*keys, key), f"unknown key; accepted {_nearest(near, names)}")
        children = list(value.items())
    elif isinstance(value, list):
        children = list(enumerate(value))
    for key, child in children:
        _check_keys(child, _child_type(type_, key), (*keys, key))


def _nearest(near: list[str], names: list[str]) -> str:
    return ", ".join(names) if len(near) == len(names) else f"nearest: {', '.join(near)} (of {', '.join(names)})"


def _field_names(type_: Any) -> list[str]:
    """Names of the fields if ``type_`` is, or may be, a dataclass; else none."""
    classes = [t for t in _alternatives(type_) if isinstance(t, type) and dataclasses.is_dataclass(t)]
    return [field.name for t in classes for field in dataclasses.fields(t)]


def _type_at(type_: Any, keys: KeyPath) -> Any:
    for key in keys:
        type_ = _child_type(type_, key)
    return type_


def _child_type(type_: Any, key: str | int) -> Any:
    """Declared type of what lies under ``key``; Any where nothing is declared."""
    for alternative in _alternatives(type_):
        if isinstance(alternative, type) and dataclasses.is_dataclass(alternative):
            return get_type_hints(alternative, include_extras=True).get(str(key), Any)
        arguments = get_args(alternative)
        if isinstance(key, int) and get_origin(alternative) is tuple and arguments[-1:] != (...,):
            return arguments[key] if key < len(arguments) else Any
        if arguments and get_origin(alternative) is not Literal:
            return arguments[0] if isinstance(key, int) else arguments[-1]
    return Any


def _alternatives(type_: Any) -> tuple[Any, ...]:
    """The members of a union, or the type alone; ``Annotated`` is looked through."""
    if hasattr(type_, "__metadata__"):
        return _alternatives(type_.__origin__)
    if get_origin(type_) in (Union, types.UnionType):
        return tuple(a for member in get_args(type_) for a in _alternatives(member))
    return (type_,)


def _accepted_values(type_: Any) -> str:
    """The values of an enumeration or literal, for a message."""
    values: list[Any] = []
    for alternative in _alternatives(type_):
        if isinstance(alternative, type) and issubclass(alternative, Enum):
            values += [member.value for member in alternative]
        elif get_origin(alternative) is Literal:
            values += get_args(alternative)
    return ", ".join(str(value) for value in values)


def dotted(keys: KeyPath) -> str:
    """The path as one writes it: ``vehicle[0].start``."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys).lstrip(".")


def _lines_by_key(text: str) -> dict[KeyPath, int]:
    """First line of every table header and of every key that stands at the start of a line."""
    lines: dict[KeyPath, int] = {}
    counts: dict[KeyPath, int] = {}  # entries so far of each array of tables
    table: KeyPath = ()
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            table = ()
            *outer, last = _split(header["name"])
            for name in outer:  # a header below an array of tables means its latest entry
                table = _latest((*table, name), counts)
            table = (*table, last)
            if header["open"] == "[[":
                counts[table] = counts.get(table, 0) + 1
                lines.setdefault(table, number)
                table = _latest(table, counts)
            lines.setdefault(table, number)
        elif assignment := _ASSIGNMENT.match(line):
            lines.setdefault((*table, *_split(assignment["key"])), number)
    return lines


def _latest(table: KeyPath, counts: dict[KeyPath, int]) -> KeyPath:
    return (*table, counts[table] - 1) if table in counts else table


def _split(name: str) -> list[str]:
    return [part.strip().strip("\"'") for part in name.split(".")]
