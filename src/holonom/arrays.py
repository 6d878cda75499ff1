"""Arrays and numbers from a caller: the shape and finite numbers that are needed, or an error that says what came."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.errors import NotFinite, OutOfLimits, ShapeError

__all__ = [
    "REVOLUTION",
    "Array",
    "angles",
    "finite",
    "finite_array",
    "is_finite",
    "is_number",
    "real_array",
    "shown",
    "vectors",
    "whole_number",
]

Array = NDArray[np.float64]
"""Floats of any shape; docstrings say which."""


REVOLUTION = 1e15
"""Largest angle, rad: doubles are 1/8 apart there, and beyond no revolution can be told."""


def is_number(value: object) -> bool:
    """Whether a single value is a real number; True and False are none."""
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def is_finite(value: object) -> bool:
    """Whether a single value is a real number, neither NaN nor infinite."""
    return is_number(value) and math.isfinite(value)  # type: ignore[arg-type]


def shown(value: object) -> str:
    """How a refusal shows what came: a number plainly, anything else as it would be typed."""
    return str(value) if is_number(value) else repr(value)


def real_array(name: str, value: Any) -> Array:
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
    except (TypeError, ValueError):
        raise ShapeError(f"{name} holds something that is not a number, or rows that differ in length") from None
    raise ShapeError(f"{name} holds complex numbers; give real ones (its .real, if the rest is rounding)")


def finite_array(name: str, value: Any, shape: Sequence[int | str]) -> Array:
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
        raise NotFinite(f"{name}[{', '.join(map(str, at))}] is {array[tuple(at)]}; it must be finite")
    return array


def finite(name: str, value: Any) -> Array:
    """Return `value` as float64 of any shape that holds finite numbers.

    Raises
    ------
    ShapeError
    """
    array = real_array(name, value)
    if not np.isfinite(array).all():
        raise NotFinite(f"{name} holds {array[~np.isfinite(array)].flat[0]}; finite numbers are needed")
    return array


def vectors(name: str, value: Any, width: int, called: Sequence[str] = ()) -> Array:
    """Return `value` as finite float64 (..., width); `called` names what the numbers of a row belong to.

    Raises
    ------
    ShapeError
        The wrong last axis, no numbers, NaN or infinity: says where.
    """
    array = real_array(name, value)
    if array.shape[-1:] != (width,):
        raise ShapeError(f"{name} has shape {array.shape}; (..., {width}) is needed")
    if not np.isfinite(array).all():
        *row, k = (int(i) for i in np.argwhere(~np.isfinite(array))[0])
        owner = f" ({called[k]})" if called else ""
        place = f" in row {tuple(row)}" if row else ""
        raise NotFinite(f"{name}[{k}]{owner} is {array[(*row, k)]}{place}; finite numbers are needed")
    return array


def angles(name: str, value: Any, width: int, called: Sequence[str] = ()) -> Array:
    """Return `value` as float64 (..., width) like `vectors`, of numbers up to `REVOLUTION`.

    Raises
    ------
    ShapeError, NotFinite
        As for `vectors`.
    OutOfLimits
        A larger number.
    """
    array = vectors(name, value, width, called)
    if not (np.abs(array) <= REVOLUTION).all():
        *row, k = (int(i) for i in np.argwhere(np.abs(array) > REVOLUTION)[0])
        owner = f" ({called[k]})" if called else ""
        raise OutOfLimits(
            f"{name}[{k}]{owner} is {array[(*row, k)]:g}: beyond {REVOLUTION:g} whole turns can no longer be told apart"
        )
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
