"""Laws of balance: stable about upright on random bodies, gains by other ways, the estimate of pitch."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.control import BALANCE_LAWS, Pendulum
from holonom.control.balance.contract import TiltSettings
from holonom.control.balance.kernels import Tilt, Upright, balance_step, tilt_ahead, tilt_step, trim_step
from holonom.control.balance.lqr import LqrBalance
from holonom.errors import ModelError, OutOfLimits

G = 9.81


def body(mass: float, rise: float, radius: float, own: float = 0.1, wheels: float = 0.5) -> Pendulum:
    """A body of a mass whose centre lies over its axle; `own` its pitch inertia over m l^2, `wheels` kg that roll."""
    return Pendulum(
        rolling=mass + wheels, coupling=mass * rise, pitching=(1.0 + own) * mass * rise**2,
        stiffness=mass * G * rise, radius=radius, rest=0.0, max_force=1e9,
    )  # fmt: skip


BODIES = st.builds(body, st.floats(1.0, 80.0), st.floats(0.05, 1.0), st.floats(0.03, 0.3), st.floats(0.05, 1.0))


def feedback(law: str, pendulum: Pendulum) -> np.ndarray:
    """K (4,) of `F = K x`, by the law's own step, one state at a time."""
    gains = BALANCE_LAWS.make(law).gains(pendulum)
    still = Upright(0.0, 0.0, 0.0, 0.0)
    small = 1e-6 * np.eye(4)
    return np.array([balance_step(gains, Upright(*row), still, 0.0) for row in small]) * 1e6


@settings(deadline=None, max_examples=40)
@given(BODIES)
@pytest.mark.parametrize("law", list(BALANCE_LAWS))
def test_upright_is_stable(law: str, pendulum: Pendulum) -> None:
    A, B = pendulum.matrices
    closed = np.linalg.eigvals(A + B @ feedback(law, pendulum)[None, :])
    assert closed.real.max() < -0.02 / pendulum.time
    assert np.linalg.eigvals(A).real.max() > 0.0


@settings(deadline=None, max_examples=20)
@given(BODIES)
def test_lqr_by_the_stable_half_of_the_hamiltonian(pendulum: Pendulum) -> None:
    law = LqrBalance()
    A, B = pendulum.matrices
    Q = np.diag([law.error_pitch**-2, law.error_rate**-2, law.error_speed**-2, law.error_place**-2])
    force = law.effort * pendulum.rolling * G
    values, vectors = np.linalg.eig(np.block([[A, -B @ B.T * force**2], [-Q, -A.T]]))
    stable = vectors[:, values.real < 0.0]
    P = np.real(stable[4:] @ np.linalg.inv(stable[:4]))
    assert feedback("lqr", pendulum) == pytest.approx(-(B.T @ P)[0] * force**2, rel=1e-4)


def test_the_inner_loop_of_the_cascade_turns_the_body_as_it_says() -> None:
    """`phi'' = -w^2 phi - 2 z w phi'` once its force is on the body, whatever the body is."""
    pendulum = body(10.0, 0.3, 0.1)
    law = BALANCE_LAWS.make("cascade", {"pitch_bandwidth": 3.0, "pitch_damping": 1.2})
    A, B = pendulum.matrices
    w = 3.0 / pendulum.time
    still = Upright(0.0, 0.0, 0.0, 0.0)
    for x, expected in (((1e-3, 0.0), -(w**2) * 1e-3), ((0.0, 1e-3), -2.4 * w * 1e-3)):
        push = balance_step(law.gains(pendulum), Upright(*x, 0.0, 0.0), still, 0.0)
        assert (A @ [*x, 0.0, 0.0] + B[:, 0] * push)[1] == pytest.approx(expected)


@pytest.mark.parametrize("law", list(BALANCE_LAWS))
def test_it_asks_for_no_more_than_it_may(law: str) -> None:
    pendulum = body(10.0, 0.3, 0.1)
    gains = BALANCE_LAWS.make(law, {"max_lean": 0.2, "max_place": 0.5}).gains(pendulum)
    still = Upright(0.0, 0.0, 0.0, 0.0)
    far = balance_step(gains, Upright(0.0, 0.0, 0.0, 0.5), still, 0.0)
    assert far == balance_step(gains, Upright(0.0, 0.0, 0.0, 50.0), still, 0.0)
    fast = balance_step(gains, Upright(0.0, 0.0, 1e3, 0.0), still, 0.0)
    assert fast == pytest.approx((gains.pitch - gains.carry) * 0.2)
    assert balance_step(gains._replace(max_force=3.0), Upright(1.0, 0.0, 0.0, 0.0), still, 0.0) == 3.0


def test_what_is_asked_again_and_again_becomes_its_rest() -> None:
    """Slowly, up to 0.1 rad, and not while something holds it."""
    gains = BALANCE_LAWS.make("lqr", {"max_lean": 0.2}).gains(body(10.0, 0.3, 0.1))
    trim = 0.0
    for _ in range(1000):
        trim = trim_step(gains, 1e-3, trim, 0.05)
    assert trim == pytest.approx(0.05 / gains.trim_time)
    assert trim_step(gains, 1e9, trim, 0.05) == 0.1
    assert trim_step(gains, 1e-3, trim, 0.2) == trim


def test_pitch_and_gyro_zero_are_found_while_it_speeds_up_and_brakes() -> None:
    """A body that swings and accelerates, its IMU by its true motion; wheels and gyro with noise, and a gyro zero."""
    dt, zero, rng = 1e-3, 0.02, np.random.default_rng(3)
    params = TiltSettings().params(dt, G)
    t = dt * np.arange(20_000)
    pitch, rate = 0.2 * np.sin(2.0 * t), 0.4 * np.cos(2.0 * t)
    speed, acceleration = np.sin(1.3 * t), 1.3 * np.cos(1.3 * t)
    ahead = acceleration * np.cos(pitch) - G * np.sin(pitch) + rng.normal(0.0, 0.05, len(t))
    up = acceleration * np.sin(pitch) + G * np.cos(pitch)
    tilt, off = Tilt(0.0, 0.1, 0.0), np.zeros(len(t))
    for k in range(len(t)):
        gyro = rate[k] + zero + rng.normal(0.0, 2e-3)
        tilt = tilt_step(params, tilt_ahead(params, tilt, gyro, ahead[k], up[k]), speed[k] + rng.normal(0.0, 0.01))
        off[k] = tilt.pitch - pitch[k]
    assert np.sqrt(np.mean(off[10_000:] ** 2)) < math.radians(0.3)
    assert tilt.bias == pytest.approx(zero, abs=2e-3)


def test_what_does_not_balance() -> None:
    with pytest.raises(ModelError, match="has it above its axle"):
        body(10.0, -0.1, 0.1)
    with pytest.raises(ModelError, match="are no body's"):
        Pendulum(rolling=1.0, coupling=2.0, pitching=1.0, stiffness=1.0, radius=0.1, rest=0.0, max_force=1.0)
    with pytest.raises(OutOfLimits, match="error_pitch"):
        LqrBalance(error_pitch=0.0)
    with pytest.raises(OutOfLimits, match="speed_noise"):
        TiltSettings(speed_noise=-1.0)
