"""Numbers from a caller: floats, finite ones, whole ones, or an error that says what came."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.errors import OutOfLimits, ShapeError

__all__ = ["finite_array", "real_array", "whole_number"]


def real_array(name: str, value: Any) -> NDArray[np.float64]:
    """Return `value` as float64.

    Raises
    ------
    ShapeError
        It holds something else than real numbers. NumPy alone would drop an imaginary part with no more than a warning.
    """
    try:
        given = np.asarray(value)
        if given.dtype.kind != "c":
            return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as problem:
        raise ShapeError(f"{name} holds something that is not a number: {problem}") from None
    raise ShapeError(f"{name} holds complex numbers; give real ones (its .real, if the rest is rounding)")


def finite_array(name: str, value: Any, shape: Sequence[int | str]) -> NDArray[np.float64]:
    """Return `value` as finite float64 of a shape, in which a word stands for any length.

    Raises
    ------
    ShapeError
        Another shape, or values that are not finite; names the first.
    """
    array = real_array(name, value)
    fits = array.ndim == len(shape) and all(
        isinstance(b, str) or a == b for a, b in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join(map(str, shape)) + ("," if len(shape) == 1 else "")
        raise ShapeError(f"{name} has shape {array.shape}; it must be ({wanted}), finite")
    if not np.isfinite(array).all():
        at = np.argwhere(~np.isfinite(array))[0]
        raise ShapeError(f"{name}[{', '.join(map(str, at))}] is {array[tuple(at)]}; it must be finite")
    return array


def whole_number(name: str, value: Any, *, least: int = 0) -> int:
    """Return `value` as an int.

    Raises
    ------
    OutOfLimits
        It is no whole number, or below the least one.
    """
    if not isinstance(value, int | np.integer) or value < least:
        raise OutOfLimits(f"{name} is {value!r}; it must be a whole number of at least {least}")
    return int(value)
