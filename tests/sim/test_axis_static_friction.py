"""Static friction of one simulated axis: breakaway, and what is left once it slides."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import DcMotor, Encoder, Friction
from holonom.sim.axis.axis import Axis, Load
from holonom.sim.axis.kernels import axis_step

MOTOR = DcMotor(0.3, 8.2e-5, 0.03, 0.03, 1.4e-5, 24.0, 30.0)
FRICTION = Friction(0.0, 0.02, 0.015, static_ratio=1.6, stribeck_speed=3.0)


@pytest.mark.parametrize("stiffness", [math.inf, 50.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_breakaway_is_the_static_friction(side: float, stiffness: float) -> None:
    axis = Axis(MOTOR, Load(1e-6), Encoder(2000), friction=FRICTION, stiffness=stiffness)
    params = axis.plant(1e-4)
    least = 1.6 * (0.02 if side > 0.0 else 0.015)
    for part, moves in ((0.98, False), (1.02, True)):
        state = axis.at()
        for _ in range(2000):
            state = axis_step(params, state, side * 0.3 * part * least / 0.03, 0.0)  # R i, at standstill
        assert (abs(state.angle) > 0.01) == moves


@given(own=st.floats(0.0, 0.1), other=st.floats(0.0, 0.1), load=st.floats(0.0, 0.1), rise=st.floats(0.0, 2.0))
def test_what_a_controller_knows_has_the_friction_at_rest_of_both(
    own: float, other: float, load: float, rise: float
) -> None:
    friction = Friction(0.0, own, other, 1.0 + rise, 5.0)
    known = Axis(MOTOR, Load(1e-6, coulomb=load), Encoder(2000), friction=friction).known_friction
    at_rest = known.static_ratio * (known.coulomb_positive + known.coulomb_negative)
    assert at_rest == pytest.approx((1.0 + rise) * (own + other) + 2.0 * load, abs=1e-12)
