"""Limits of an axis: each violation found, in its order, and worded."""

from __future__ import annotations

import math

import pytest

from holonom.control import AxisLimits, Violation, axis_violation, drive_fault
from holonom.errors import DriveFault, OutOfLimits

LIMITS = AxisLimits(lower=-2.0, upper=1.5, speed=3.0, current=9.0, following_error=0.05)
GOOD = {"reference": 0.5, "position": 0.48, "speed": -2.9, "current": -8.9}

CASES = [
    ({}, Violation.NONE, ""),
    ({"reference": math.nan}, Violation.LOST_REFERENCE, "lost reference: the commanded position is nan"),
    ({"reference": math.inf}, Violation.LOST_REFERENCE, "lost reference"),
    ({"reference": -2.01, "position": -2.01}, Violation.POSITION_LOW, r"position -2.01 rad is below .* -2 rad"),
    ({"reference": 1.51, "position": 1.51}, Violation.POSITION_HIGH, r"position 1.51 rad is above .* 1.5 rad"),
    ({"position": 0.44}, Violation.FOLLOWING_ERROR, r"following error 0.06 exceeds 0.05"),
    ({"position": 0.56}, Violation.FOLLOWING_ERROR, r"following error -0.06 exceeds 0.05"),
    ({"speed": -3.01}, Violation.SPEED, r"speed -3.01 rad/s exceeds 3 rad/s"),
    ({"current": 9.5}, Violation.CURRENT, r"current 9.5 A exceeds 9 A"),
]


@pytest.mark.parametrize(("change", "violation", "words"), CASES)
def test_each_violation_is_found_and_worded(change: dict[str, float], violation: Violation, words: str) -> None:
    values = {**GOOD, **change}
    found = Violation(axis_violation(LIMITS.params(), *values.values()))
    assert found is violation
    if found is not Violation.NONE:
        with pytest.raises(DriveFault, match=rf"axis 'elbow' stopped at 1\.2500 s: {words}") as caught:
            raise drive_fault(found, LIMITS, axis="elbow", time=1.25, **values)
        assert "command within the limits" in str(caught.value)


@pytest.mark.parametrize("name", ["position", "speed", "current"])
def test_nan_never_passes(name: str) -> None:
    assert axis_violation(LIMITS.params(), *{**GOOD, name: math.nan}.values()) != Violation.NONE


def test_infinite_limits_never_trip() -> None:
    free = AxisLimits(-math.inf, math.inf, math.inf, math.inf, math.inf)
    assert axis_violation(free.params(), 1e9, -1e9, 1e9, 1e9) == Violation.NONE


@pytest.mark.parametrize(
    ("numbers", "named"),
    [
        ((1.0, 1.0, 1.0, 1.0, 1.0), "lower is 1.0, upper 1.0; lower must be less"),
        ((math.nan, 1.0, 1.0, 1.0, 1.0), "lower is nan"),
        ((0.0, 1.0, 0.0, 1.0, 1.0), "speed is 0.0; it must be greater than 0"),
        ((0.0, 1.0, 1.0, math.nan, 1.0), "current is nan"),
        ((0.0, 1.0, 1.0, 1.0, -0.1), "following_error is -0.1"),
    ],
)
def test_bad_limits_are_named(numbers: tuple[float, ...], named: str) -> None:
    with pytest.raises(OutOfLimits, match=named):
        AxisLimits(*numbers)
