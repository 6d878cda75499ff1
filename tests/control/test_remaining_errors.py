"""Remaining errors by type number: a table of formulas against simulated loops, and the servo of an axis."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lsim, lti

from holonom.control.servo.remaining import remaining_errors
from holonom.errors import OutOfLimits

PAIRS = [(N, m) for N in range(4) for m in range(N + 1)]


def loop(N: int, m: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, float]:
    """Numerators of regulator and plant, the closed loop's denominator, K and K_R, of a stable loop.

    `R = K_R (1 + s)^(N - 1) / s^m`, `P = 2 / (s^(N - m) (1 + s/20))`.
    """
    zeros = np.array([1.0])
    for _ in range(max(N - 1, 0)):
        zeros = np.polymul(zeros, [1.0, 1.0])
    regulator, plant = 3.0 * zeros, np.array([2.0])
    denominator = np.polyadd(np.polymul([1.0] + [0.0] * N, [0.05, 1.0]), np.polymul(regulator, plant))
    assert (np.roots(denominator).real < -0.1).all()
    return regulator, plant, denominator, 6.0, 3.0


@pytest.mark.parametrize(("N", "m"), PAIRS)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_what_is_left_of_each_input(N: int, m: int, order: int) -> None:
    _, plant, denominator, K, K_R = loop(N, m)
    found = remaining_errors(N, gain=K, regulator_type=m, regulator_gain=K_R)
    t = np.linspace(0.0, 80.0, 4001)
    given = t**order / math.factorial(order)
    shapes = ("step", "ramp", "parabola")
    by_reference = np.polymul([1.0] + [0.0] * N, [0.05, 1.0])
    by_load = np.polymul(plant, [1.0] + [0.0] * m)
    for numerator, errors in ((by_reference, found.reference), (by_load, found.load)):
        error = lsim(lti(numerator, denominator), given, t)[1]
        wanted = getattr(errors, shapes[order])
        if math.isinf(wanted):
            assert abs(error[-1]) > 2.0
            assert abs(error[-1]) > 1.5 * abs(error[-2000])  # it grows
        else:
            assert error[-1] == pytest.approx(wanted, abs=2e-3)


def test_an_integrator_of_the_plant_does_not_help_against_the_load() -> None:
    """P or PD on an integrating process: no error of the reference, one of the load (errata of the specification)."""
    found = remaining_errors(1, gain=6.0, regulator_gain=3.0)
    assert (found.reference.step, found.load.step) == (0.0, 1.0 / 3.0)
    assert remaining_errors(2, regulator_type=1).load.step == 0.0


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"loop_type": 1, "regulator_type": 2}, "0 <= regulator_type <= loop_type"),
        ({"loop_type": -1}, "loop_type is -1"),
        ({"loop_type": 1, "gain": 0.0}, "gains are 0"),
        ({"loop_type": 1, "regulator_gain": math.nan}, "nan; they must be finite"),
    ],
)
def test_bad_types_are_named(given: dict[str, float], text: str) -> None:
    with pytest.raises(OutOfLimits, match=text):
        remaining_errors(**given)  # type: ignore[arg-type]
