"""Arrays and numbers from a caller: the shape and finite numbers that are needed, or an error that says what came."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.errors import NotFinite, OutOfLimits, ShapeError

__all__ = [
    "LARGEST",
    "REVOLUTION",
    "Array",
    "angles",
    "finite",
    "finite_array",
    "is_finite",
    "is_number",
    "real_array",
    "shown",
    "too_large",
    "vectors",
    "whole_number",
]

Array = NDArray[np.float64]
"""Floats of any shape; docstrings say which."""


LARGEST, REVOLUTION = 1e100, 1e15
"""Largest number, and largest angle (rad), that is taken: products of larger numbers overflow; where angles are larger,
doubles are 1/8 apart, and no revolution can be told."""


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
    ShapeError, NotFinite, OutOfLimits
        Another shape; values that are not finite, or beyond `LARGEST`: names the first.
    """
    array = real_array(name, value)
    fits = array.ndim == len(shape) and all(
        isinstance(b, str) or a == b for a, b in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join(map(str, shape)) + ("," if len(shape) == 1 else "")
        raise ShapeError(f"{name} has shape {array.shape}; it must be ({wanted}), finite")
    return _bounded(array, lambda at: (f"{name}[{', '.join(map(str, at))}] is", ""), "it must be finite")


def finite(name: str, value: Any) -> Array:
    """Return `value` as float64 of any shape that holds finite numbers.

    Raises
    ------
    ShapeError, NotFinite, OutOfLimits
    """
    return _bounded(real_array(name, value), lambda at: (f"{name} holds", ""))


def vectors(name: str, value: Any, width: int, called: Sequence[str] = (), *, largest: float = LARGEST) -> Array:
    """Return `value` as finite float64 (..., width); `called` names what the numbers of a row belong to.

    Raises
    ------
    ShapeError, NotFinite, OutOfLimits
        The wrong last axis, no numbers; NaN or infinity; a number beyond the `largest`: says where.
    """
    array = real_array(name, value)
    if array.shape[-1:] != (width,):
        raise ShapeError(f"{name} has shape {array.shape}; (..., {width}) is needed")

    def place(at: tuple[int, ...]) -> tuple[str, str]:
        *row, k = at
        return f"{name}[{k}]{f' ({called[k]})' if called else ''} is", f" in row {tuple(row)}" if row else ""

    return _bounded(array, place, largest=largest)


def angles(name: str, value: Any, width: int, called: Sequence[str] = ()) -> Array:
    """Return `value` as `vectors` does, of numbers up to `REVOLUTION`; arguments and errors are the same."""
    return vectors(name, value, width, called, largest=REVOLUTION)


def too_large(largest: float) -> str:
    """Why a number beyond a bound is refused."""
    return "whole turns can no longer be told apart" if largest == REVOLUTION else "products of it overflow"


def _bounded(
    array: Array,
    place: Callable[[tuple[int, ...]], tuple[str, str]],
    wanted: str = "finite numbers are needed",
    largest: float = LARGEST,
) -> Array:
    """The array, if it is finite and no number exceeds the largest; `place(index)`: what stands before and after it."""
    with np.errstate(invalid="ignore"):
        fine = np.abs(array) <= largest
    if fine.all():
        return array
    finite_ones = np.isfinite(array)
    if not finite_ones.all():
        at = tuple(int(i) for i in np.argwhere(~finite_ones)[0])
        before, after = place(at)
        raise NotFinite(f"{before} {array[at]}{after}; {wanted}")
    at = tuple(int(i) for i in np.argwhere(~fine)[0])
    before, after = place(at)
    raise OutOfLimits(f"{before} {array[at]:g}{after}: beyond {largest:g} {too_large(largest)}; give less")


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
