"""Recorded types to JSON bytes and back, without losing a bit of any float64.

JSON, because a recording must be readable by other tools in ten years' time. NaN, which JSON lacks, is written as
``null``; infinity has no place in a recording and is refused.
"""

from typing import Any, TypeVar, get_args, get_origin

import msgspec
import numpy as np

from contracts import InputError

T = TypeVar("T")


def encode(value: object) -> bytes:
    """``value``, a dataclass of plain values and arrays, as JSON bytes; equal values give equal bytes.

    Raises InputError if an array holds infinity or ``value`` something that JSON cannot say.
    """
    try:
        return _ENCODER.encode(value)
    except TypeError as error:
        raise InputError(f"{type(value).__name__} cannot be recorded: {error}") from error


def decode(data: bytes, kind: type[T]) -> T:
    """The inverse of ``encode``; ``kind`` is the dataclass, which validates itself as always.

    Raises InputError saying what does not fit.
    """
    try:
        return msgspec.json.decode(data, type=kind, dec_hook=_array_from_lists)
    except msgspec.MsgspecError as error:
        raise InputError(f"{kind.__name__} cannot be read: {error}") from error


def json_schema(kind: type) -> dict[str, Any]:
    """JSON Schema of ``kind`` with an object at the top and no references, as viewers of MCAP files want it."""
    schema = msgspec.json.schema(kind, schema_hook=_array_schema)
    inlined: dict[str, Any] = _inline(schema, schema.get("$defs", {}))
    return inlined


def _lists_from_array(value: object) -> object:
    if isinstance(value, np.ndarray):
        if np.issubdtype(value.dtype, np.floating) and np.isinf(value).any():
            raise InputError("an array to be recorded holds infinity; write NaN for what is unknown")
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no JSON form")


def _array_from_lists(kind: Any, value: object) -> object:
    if get_origin(kind) is not np.ndarray:
        raise TypeError(f"{kind} has no JSON form")
    _, dtype = get_args(kind)  # ndarray[shape, dtype[scalar]]
    return np.array(value, dtype=get_args(dtype)[0])  # null becomes NaN


def _array_schema(kind: Any) -> dict[str, Any]:
    return {"type": "array", "items": {}}


def _inline(schema: Any, definitions: dict[str, Any]) -> Any:
    if isinstance(schema, list | tuple):
        return [_inline(part, definitions) for part in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        return _inline(definitions[schema["$ref"].rsplit("/", 1)[-1]], definitions)
    return {key: _inline(part, definitions) for key, part in schema.items() if key not in ("$defs", "default")}


_ENCODER = msgspec.json.Encoder(enc_hook=_lists_from_array, order="deterministic")
