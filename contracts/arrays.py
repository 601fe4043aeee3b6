"""Arrays that are checked once, at the door, and cannot be edited afterwards."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from contracts.errors import InputError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ImageArray = NDArray[np.uint8]


def frozen_array(
    value: ArrayLike,
    *,
    name: str,
    shape: tuple[int | None, ...],
    dtype: DTypeLike = np.float64,
    finite: bool = True,
) -> NDArray[Any]:
    """Copy ``value`` to a read-only, C-contiguous array of ``dtype`` and check it.

    shape: expected shape; ``None`` accepts any length on that axis.
    finite: refuse NaN and infinity (floating dtypes only).
    Raises InputError naming ``name`` and what is wrong with it. An array without elements takes the expected shape
    when that has exactly one open axis, so that ``[]`` is a valid "no boxes".
    """
    try:
        array = np.array(value, dtype=dtype, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} cannot be read as an array of {np.dtype(dtype).name}: {error}") from error
    if array.size == 0 and shape.count(None) + shape.count(0) == 1:
        array = array.reshape([n or 0 for n in shape])
    if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape, strict=True)):
        wanted = " x ".join("N" if n is None else str(n) for n in shape)
        raise InputError(f"{name} has shape {array.shape}, expected {wanted}")
    if finite and np.issubdtype(array.dtype, np.floating) and not np.isfinite(array).all():
        raise InputError(f"{name} holds NaN or infinity")
    array.setflags(write=False)
    return array


def freeze(owner: object, field: str, **kwargs: Any) -> None:
    """Replace ``owner.field`` of a frozen dataclass by its ``frozen_array``; for use in ``__post_init__``."""
    name = f"{type(owner).__name__}.{field}"
    object.__setattr__(owner, field, frozen_array(getattr(owner, field), name=name, **kwargs))
