"""Wheels whose measurements disagree: what holds them aside holds exactly, how far they roll is fitted."""

import numpy as np
import pytest
from bases import presets, twists
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space

from holonom.mobile import arrangements
from holonom.mobile.base import WheelBase
from holonom.mobile.base.wheel import Wheel

BASES = presets()

CARS = {
    "ackermann": BASES["ackermann"],
    "tricycle": BASES["tricycle"],
    "forklift": WheelBase([
        Wheel.at("steered", -1.2, 0.0, radius=0.15, driven=True, name="drive"),
        Wheel.at("fixed", 0.0, 0.4, radius=0.08, driven=True, name="left"),
        Wheel.at("fixed", 0.0, -0.4, radius=0.08, driven=True, name="right"),
        Wheel.at("steered", -1.0, 0.5, radius=0.08, name="guide"),
    ]),
    "differential": BASES["differential"],
    "aside": WheelBase([Wheel.at("fixed", -0.2, y, 0.3, radius=0.05, driven=True) for y in (0.2, 0.138)]),
}  # fmt: skip


@pytest.mark.parametrize("name", CARS)
@given(twist=twists, seed=st.integers(0, 1000))
def test_constraints_hold_exactly_and_rolling_is_fitted(name, twist, seed):
    """Wheels that disagree slide nowhere: least squares of the rolling rows over the null space of all sliding rows."""
    base, rng = CARS[name], np.random.default_rng(seed)
    v = base.feasible([1.0 + abs(twist[0]), twist[1], 0.5 * twist[2]])
    steering = base.steering(v)
    speeds = base.wheel_speeds(v, steering) * (1.0 + 0.02 * rng.standard_normal(len(base.driven)))
    C, scale = base.sliding_matrix(steering), np.array([1.0, 1.0, 1.0 / base.radius])
    S = scale[:, None] * null_space(C * scale, rcond=1e-7)
    D = base.rolling_matrix(steering)[[n in base.driven for n in base.rolling_names]]
    found = base.twist(speeds, steering)
    np.testing.assert_allclose(base.sliding(found, steering), 0.0, atol=1e-7)
    if name == "forklift":  # its module measures across too, which makes its twist a little longer or shorter
        np.testing.assert_allclose(np.cross(found, v), 0.0, atol=1e-6)
        return
    fitted = S @ np.linalg.lstsq(D @ S, speeds * base.wheel_radii, rcond=None)[0]
    np.testing.assert_allclose(found, fitted, atol=1e-7)


def test_a_car_whose_rear_encoders_disagree_does_not_slide_sideways():
    """2 % between the rear wheels, straight ahead: 1 m is 1 m along the heading, where 2.9 mm went aside before."""
    car = arrangements.ackermann(0.3, 0.2, 0.03)
    v = car.twist(np.array([1.01, 0.99]) / 0.03, car.steering([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(v, [1.0, 0.0, 0.0], atol=1e-9)
