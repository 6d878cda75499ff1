"""Quantities with units: their SI values, exactly, and every way to write them wrong."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.app.fields.units import DIMENSIONS, parse_quantity
from holonom.errors import InputError, UnknownName

WRITTEN = [(dimension, unit) for dimension, units in DIMENSIONS.items() for unit in units if unit]


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("250mm/s", "speed", 0.25),
        ("30deg", "angle", math.pi / 6),
        ("0.3m", "length", 0.3),
        ("36mm", "length", 0.036),
        ("-12.5 cm", "length", -0.125),
        ("150ms", "time", 0.15),
        ("2min", "time", 120.0),
        ("40g", "mass", 0.04),
        ("2.5kg", "mass", 2.5),
        ("90deg/s", "angular speed", math.pi / 2),
        ("60rpm", "angular speed", 2 * math.pi),
        ("1.5m/s2", "acceleration", 1.5),
        ("1kHz", "frequency", 1000.0),
        ("8.7g/cm3", "density", 8700.0),
        ("1e-3m", "length", 0.001),
        (0.5, "number", 0.5),
        (3, "number", 3.0),
    ],
)
def test_value_in_si(text: object, dimension: str, value: float) -> None:
    # The nearest double where the factor is decimal; degrees are right to the last place but one.
    assert parse_quantity(text, dimension) == pytest.approx(value, rel=3e-16, abs=0)


@pytest.mark.parametrize(("dimension", "unit"), WRITTEN)
@given(number=st.floats(-1e6, 1e6))
def test_proportional_and_odd(dimension: str, unit: str, number: float) -> None:
    value = parse_quantity(f"{number!r}{unit}", dimension)
    assert value == pytest.approx(number * parse_quantity(f"1{unit}", dimension), rel=1e-15, abs=1e-320)
    assert parse_quantity(f"{-number!r}{unit}", dimension) == -value


@pytest.mark.parametrize(
    ("value", "dimension", "said"),
    [
        (250, "length", r"250 came; .* mm, cm, m or um, such as \"2.5mm\""),
        ("250", "length", "without a unit"),
        ("30deg", "length", "in a unit of angle; a quantity of length is expected"),
        ("1m/s", "acceleration", "in a unit of speed; .* mm/s2"),
        ("mm", "length", "no number with a unit"),
        ("1,5mm", "length", "no unit of length ',5mm'"),
        ("1e9999mm", "length", "no unit of length"),
        ("1e999mm", "length", "finite"),
        ("nanmm", "length", "no number"),
        ("", "length", "no number"),
        (["1mm"], "length", "a quantity of length is expected"),
        ("1", "number", "plain number"),
        (True, "number", "plain number"),
        (math.nan, "number", "finite"),
    ],
)
def test_what_is_no_quantity(value: object, dimension: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse_quantity(value, dimension)


def test_unknown_unit_lists_the_units_and_the_nearest() -> None:
    with pytest.raises(UnknownName, match=r"no unit of speed 'mm/sec'; there is .*m/s.*; did you mean 'mm/s'"):
        parse_quantity("250mm/sec", "speed")
