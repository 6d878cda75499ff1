"""Rates of wheels against finite differences along a motion, of every arrangement."""

from __future__ import annotations

import numpy as np
import pytest
from bases import presets

import holonom as hm
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile import WheelBase, wheel_rates

STEP = 1e-5


def motion(base: WheelBase, t: np.ndarray) -> np.ndarray:
    """A twist (..., 3) that the base can drive at every time, none of whose contacts stands."""
    asked = np.stack([1.0 + 0.2 * np.sin(t), 0.3 * np.cos(1.3 * t), 0.35 + 0.1 * np.sin(0.7 * t)], axis=-1)
    near = base.feasible(asked)
    if np.abs(near[..., 2]).max() > 1e-6 and np.abs(near - asked).max() > 1e-9:  # cars: v and w, nothing across
        asked[..., 1] = 0.0
        near = base.feasible(asked)
    return near


@pytest.mark.parametrize("name", presets())
def test_they_are_the_derivatives_of_angles_and_speeds(name: str) -> None:
    base = presets()[name]
    t = np.linspace(0.0, 3.0, 7)
    before, now, after = (motion(base, t + s) for s in (-STEP, 0.0, STEP))
    xi, rate = now, (after - before) / (2.0 * STEP)
    w = xi[:, 2]
    a = np.column_stack([rate[:, 0] - w * xi[:, 1], rate[:, 1] + w * xi[:, 0], rate[:, 2]])
    found = wheel_rates(base, xi, a)
    first, last = (base.steering(v) for v in (before, after))
    turned = np.angle(np.exp(1j * (last - first))) / (2.0 * STEP)
    np.testing.assert_allclose(found.steering, base.steering(xi))
    np.testing.assert_allclose(found.steering_rates, turned, atol=1e-6)
    speeds = (base.wheel_speeds(after) - base.wheel_speeds(before)) / (2.0 * STEP)
    np.testing.assert_allclose(found.accelerations, speeds, atol=1e-5)
    np.testing.assert_allclose(found.speeds, base.wheel_speeds(xi))


def test_a_car_on_a_spiral_by_hand() -> None:
    """`tan(delta) = L kappa`, so `delta' = L kappa' cos^2(delta)`; rear wheels in proportion to their radii."""
    car = hm.mobile.bicycle(0.5, 0.1)
    v, k, dk = 1.2, 0.8, 0.3
    found = wheel_rates(car, (v, 0.0, v * k), (0.0, v * v * k, v * dk))
    assert found.steering_rates[0] == pytest.approx(0.5 * dk / (1.0 + (0.5 * k) ** 2))
    np.testing.assert_allclose(found.accelerations, 0.0, atol=1e-12)


def test_wrong_input() -> None:
    car = hm.mobile.bicycle(0.5, 0.1)
    with pytest.raises(OutOfLimits, match="front stands"):
        wheel_rates(car, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    with pytest.raises(ShapeError, match="they must be the same"):
        wheel_rates(car, np.ones((2, 3)), (1.0, 0.0, 0.0))
    with pytest.raises(OutOfLimits, match="sideways"):
        wheel_rates(car, (1.0, 0.5, 0.0), (0.0, 0.0, 0.0))
