"""Quantities as a person writes them ("250mm/s", "30deg") and their values in SI.

Conversion happens here, once, at the edge of a cell file; everything behind it is SI and radians.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from decimal import Decimal

from holonom.errors import InputError, UnknownName

__all__ = ["DIMENSIONS", "parse_quantity", "unit_names"]

DEGREE = math.pi / 180

LARGEST = 1e15
"""Of any quantity: no robot has more of anything."""
DIMENSIONS: Mapping[str, Mapping[str, float]] = {
    "length": {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "um": 1e-6},
    "angle": {"deg": DEGREE, "rad": 1.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "mass": {"kg": 1.0, "g": 1e-3},
    "density": {"g/cm3": 1e3, "kg/m3": 1.0},
    "frequency": {"Hz": 1.0, "kHz": 1e3},
    "speed": {"mm/s": 1e-3, "cm/s": 1e-2, "m/s": 1.0},
    "acceleration": {"mm/s2": 1e-3, "cm/s2": 1e-2, "m/s2": 1.0},
    "angular speed": {"deg/s": DEGREE, "rad/s": 1.0, "rpm": 2 * math.pi / 60},
    "angular acceleration": {"deg/s2": DEGREE, "rad/s2": 1.0},
    "jerk": {"m/s3": 1.0, "mm/s3": 1e-3},
    "angular jerk": {"deg/s3": DEGREE, "rad/s3": 1.0},
    "voltage": {"V": 1.0, "mV": 1e-3},
    "current": {"A": 1.0, "mA": 1e-3},
    "resistance": {"ohm": 1.0, "mohm": 1e-3},
    "inductance": {"mH": 1e-3, "uH": 1e-6, "H": 1.0},
    "force": {"N": 1.0, "kN": 1e3},
    "torque": {"mNm": 1e-3, "Nm": 1.0},
    "torque constant": {"mNm/A": 1e-3, "Nm/A": 1.0},
    "voltage constant": {"mVs/rad": 1e-3, "Vs/rad": 1.0, "V/krpm": 0.03 / math.pi},
    "speed constant": {"rpm/V": math.pi / 30, "rad/s/V": 1.0},
    "speed gradient": {"rpm/mNm": 1e3 * math.pi / 30, "rad/s/Nm": 1.0},
    "thermal resistance": {"K/W": 1.0},
    "temperature": {"degC": 1.0},
    "stiffness": {"Nm/rad": 1.0, "mNm/rad": 1e-3, "Nm/deg": 1.0 / DEGREE},
    "rotational damping": {"uNms/rad": 1e-6, "mNms/rad": 1e-3, "Nms/rad": 1.0},
    "inertia": {"gcm2": 1e-7, "kgm2": 1.0},
    "number": {"": 1.0},
}
"""For each dimension the units that it may be written in, the usual one first, and what one of them is in SI."""

_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d{1,3})?)\s*(?P<unit>\S*)\s*", re.ASCII
)


def unit_names(dimension: str) -> str:
    """Return the units of a dimension as prose: "mm, cm, m or um"."""
    *first, last = DIMENSIONS[dimension]
    return f"{', '.join(first)} or {last}" if first else last


def parse_quantity(value: object, dimension: str) -> float:
    """Return the SI value of a quantity.

    Parameters
    ----------
    value : text with a unit such as "250mm/s"; for the dimension "number" a plain number, which is its own value.
    dimension : a key of `DIMENSIONS`.

    Returns
    -------
    float, in the SI unit of the dimension (m, rad, s, kg, ...).

    Raises
    ------
    InputError
        No number, no unit, a unit of another dimension; the message names the units allowed.
    UnknownName
        No such unit.
    """
    if dimension == "number":
        return _plain_number(value)
    if not isinstance(value, str):
        raise InputError(f"{value!r} came; {_expected(dimension)}")
    match = _QUANTITY.fullmatch(value)
    if match is None:
        raise InputError(f"{value!r} came, which is no number with a unit; {_expected(dimension)}")
    return _finite(_product(match["number"], _factor(match["unit"], value, dimension)), value)


def _plain_number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{value!r} came; a plain number without unit is expected, such as 0.5")
    return _finite(float(value) if abs(value) <= LARGEST else math.inf, value)


def _product(number: str, factor: float) -> float:
    """Return the double nearest to a decimal product, so that "36mm" is 0.036 and not its neighbour."""
    try:
        return float(Decimal(number) * Decimal(repr(factor)))
    except ArithmeticError:  # an exponent that no decimal has
        return math.inf


def _factor(unit: str, value: str, dimension: str) -> float:
    units = DIMENSIONS[dimension]
    if unit in units:
        return units[unit]
    if not unit:
        raise InputError(f"{value!r} came without a unit; {_expected(dimension)}")
    for other, others in DIMENSIONS.items():
        if unit in others:
            raise InputError(f"{value!r} came, in a unit of {other}; {_expected(dimension)}")
    raise UnknownName(f"unit of {dimension}", unit, units)


def _expected(dimension: str) -> str:
    example = f"2.5{next(iter(DIMENSIONS[dimension]))}"
    return f'a quantity of {dimension} is expected, in {unit_names(dimension)}, such as "{example}"'


def _finite(number: float, value: object) -> float:
    if not abs(number) <= LARGEST:
        raise InputError(f"{value!r} came; a finite number, at most {LARGEST:g} in SI units, is expected")
    return number
