"""Operators of the language on numbers and strings; what has no result is a `ProgramFault`, never NaN."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from holonom.errors import ProgramFault
from holonom.lang.program import Value
from holonom.lang.vm.formats import shown
from holonom.lang.words.functions import TRUE

__all__ = ["BINARY", "UNARY", "finite"]

_BITS = 2**31


def finite(value: Value) -> Value:
    """Return the value; `ProgramFault` when it is a number that has left the range of numbers."""
    if isinstance(value, float) and not math.isfinite(value):
        raise ProgramFault("the result is too large for a number")
    return value


def _divide(a: float, b: float) -> float:
    if b == 0.0:
        raise ProgramFault(f"division by zero: {shown(a)} / 0")
    return a / b


def _modulo(a: float, b: float) -> float:
    if b == 0.0:
        raise ProgramFault(f"division by zero: {shown(a)} MOD 0")
    return math.fmod(a, b)


def _power(a: float, b: float) -> float:
    try:
        return math.pow(a, b)
    except (ValueError, OverflowError):
        raise ProgramFault(f"{shown(a)} ^ {shown(b)} is no number") from None


def _bits(a: float) -> int:
    if not (a.is_integer() and -_BITS <= a < 2 * _BITS):
        raise ProgramFault(f"bits of {shown(a)}; bit operators take whole numbers of 32 bits")
    return int(a)


def _on_bits(apply: Callable[[int, int], int]) -> Callable[[float, float], float]:
    return lambda a, b: float(apply(_bits(a), _bits(b)))


def _test(compare: Callable[[Any, Any], bool]) -> Callable[[Any, Any], float]:
    return lambda a, b: TRUE if compare(a, b) else 0.0


UNARY: dict[str, Callable[[Any], Value]] = {
    "MINUS": operator.neg,
    "NOT": lambda a: TRUE if a == 0.0 else 0.0,
    "COM": lambda a: float(~_bits(a)),
}

BINARY: dict[str, Callable[[Any, Any], Value]] = {
    "PLUS": operator.add,
    "MINUS": operator.sub,
    "STAR": operator.mul,
    "SLASH": _divide,
    "MOD": _modulo,
    "POWER": _power,
    "AND": _test(lambda a, b: a != 0.0 and b != 0.0),
    "OR": _test(lambda a, b: a != 0.0 or b != 0.0),
    "XOR": _test(lambda a, b: (a != 0.0) != (b != 0.0)),
    "BAND": _on_bits(operator.and_),
    "BOR": _on_bits(operator.or_),
    "BXOR": _on_bits(operator.xor),
    "EQ": _test(operator.eq),
    "NE": _test(operator.ne),
    "LT": _test(operator.lt),
    "LE": _test(operator.le),
    "GT": _test(operator.gt),
    "GE": _test(operator.ge),
}
