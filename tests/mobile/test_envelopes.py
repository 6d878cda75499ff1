"""Envelopes against linear programs, published effective motors, what binds, laws of limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from omni_bases import scattered, soccer, symmetric
from scipy.optimize import linprog

from holonom.devices import DcMotor, Gear
from holonom.errors import InputError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile import arrangements
from holonom.mobile.drive.coupling import Coupling, base_acceleration, omni_coupling, rim_speeds
from holonom.mobile.drive.envelopes import (
    Limit,
    acceleration_envelope,
    critical_force,
    effective_motors,
    force_envelope,
    speed_envelope,
)
from holonom.mobile.drive.limits import DriveLimits, drive_limits
from holonom.mobile.stability import Stance

MOTOR = DcMotor(1.2, 0.56e-3, 0.0255, 0.0255, 92.5e-7, 24.0, 4.0, 0.1)
GEAR = Gear(4.5, 0.9)
GRAVITY = 9.81
AROUND = np.linspace(0.0, 2.0 * np.pi, 37)


def limits(friction: float = np.inf, loads: float = 5.0, n: int = 4, **other: object) -> DriveLimits:
    return DriveLimits(MOTOR, GEAR, 0.027, 2.5, friction, np.full(n, loads), **other)


def program(D: np.ndarray, phi: float, low: np.ndarray, high: np.ndarray, turn: float = 0.0) -> float | None:
    """The envelope as the linear program of its definition."""
    n = len(D)
    A = np.column_stack([D.T, [-np.cos(phi), -np.sin(phi), 0.0]])
    found = linprog(
        np.append(np.zeros(n), -1.0), A_eq=A, b_eq=[0, 0, turn], bounds=[*np.column_stack([low, high]), (0, None)]
    )
    return found.x[-1] if found.status == 0 else None


def test_effective_motors_as_published():
    # specification 06.2: four wheels at 37.5 deg: 3.17 forward, 2.44 sideways, 1.95 at 45 deg
    forward, sideways, diagonal = effective_motors(symmetric(37.5), np.deg2rad([90.0, 0.0, 45.0]))
    assert round(forward, 2) == 3.17
    assert round(sideways, 2) == 2.44
    assert round(diagonal, 2) == 1.95
    a = np.deg2rad(37.5)
    np.testing.assert_allclose([forward, sideways], [4 * np.cos(a), 4 * np.sin(a)])


@given(st.integers(0, 10**6), st.integers(2, 7), st.booleans(), st.booleans())
def test_envelope_is_the_linear_program(seed, n, dead, turning):
    rng = np.random.default_rng(seed)
    D = omni_coupling(rng.uniform(0, 6.3, n), levers=rng.uniform(-0.5, 1.5, n)).velocity
    low, high, out = -rng.uniform(0, 1, n), rng.uniform(0, 1, n), [int(rng.integers(n))] if dead else []
    turn, phi = float(rng.uniform(-1.5, 1.5)) * turning, rng.uniform(0, 6.3, 3)
    found = force_envelope(D, phi, limits=high, lower=low, torque=turn, out=out)
    low[out] = high[out] = 0.0
    for k in range(3):
        want = program(D, phi[k], low, high, turn)
        assert found.reachable[k] == (want is not None)
        assert found.value[k] == pytest.approx(0.0 if want is None else want, abs=1e-7)


@given(st.integers(0, 10**6), st.integers(3, 8))
def test_wheels_at_their_limits_make_the_force(seed, n):
    rng = np.random.default_rng(seed)
    base = scattered(rng, n)
    phi = rng.uniform(0, 6.3, 5)
    found = force_envelope(base, phi)
    for k in range(5):  # with one per cent less on the wheels that are held, it is out of reach; on the others, not
        weak = np.where(found.limits[k] > 0, 0.99, 1.0)
        assert force_envelope(base, phi[k], limits=weak).value[0] < found.value[k] - 1e-6
        easy = np.where(found.limits[k] > 0, 1.0, 1.01)
        assert force_envelope(base, phi[k], limits=easy).value[0] == pytest.approx(found.value[k], abs=1e-9)


def test_envelope_has_the_symmetry_of_the_base():
    np.testing.assert_allclose(effective_motors(symmetric(), AROUND), effective_motors(symmetric(), np.pi - AROUND))
    np.testing.assert_allclose(effective_motors(symmetric(), AROUND), effective_motors(symmetric(), AROUND + np.pi))
    five = omni_coupling(2 * np.pi * np.arange(5) / 5)
    np.testing.assert_allclose(effective_motors(five, AROUND), effective_motors(five, AROUND + 2 * np.pi / 5))
    # without one motor half of the effective motors are left forwards: its opposite would turn the base
    intact, dead = (effective_motors(symmetric(), np.pi / 2, out=o)[0] for o in ((), (0,)))
    assert dead == pytest.approx(intact / 2)


def test_few_wheels_left_push_along_a_line():
    assert (effective_motors(soccer(), AROUND, out=range(4)) == 0.0).all()
    two = effective_motors(symmetric(), [0.0, np.pi / 2, 1.0], out=(0, 1))
    np.testing.assert_allclose(two, [0.0, 2.0 * np.cos(np.deg2rad(37.5)), 0.0], atol=1e-12)


def test_motor_line():
    drive = limits()
    stall = 4.5 * 0.9 * 0.0255 * (4.0 - 0.1) / 0.027  # the power stage allows 4 A of the 20 A
    low, high = drive.motor_limits([0.0, 1.0, drive.rim_speed, -1.0])
    assert high[0] == pytest.approx(stall)
    assert high[1] == pytest.approx(stall)
    assert high[2] == pytest.approx(0.0, abs=1e-9)  # no force is left at free speed
    assert high[3] == pytest.approx(4.5 / 0.9 * 0.0255 * 4.1 / 0.027)  # braking: friction and gear help
    np.testing.assert_allclose(low, -drive.motor_limits([0.0, -1.0, -drive.rim_speed, 1.0])[1])
    assert drive.rim_speed == pytest.approx((24.0 - 0.12) / 0.0255 / 4.5 * 0.027)


@pytest.mark.parametrize("friction", [0.2, 0.75, np.inf])
def test_what_binds_is_the_weaker_of_motor_and_floor(friction):
    base, drive = soccer(radius=0.09, alpha=0.6), limits(friction, 2.5 * GRAVITY / 4)
    found = acceleration_envelope(base, AROUND, drive)
    stall = drive.motor_limits(np.zeros(4))[1]
    bound = min(stall[0], friction * 2.5 * GRAVITY / 4)
    np.testing.assert_allclose(found.value, bound * effective_motors(base, AROUND) / 2.5)
    expected = Limit.MOTOR if stall[0] <= bound else Limit.FRICTION
    assert set(found.limits.ravel()) <= {Limit.NONE, expected}
    assert (found.limits > 0).any(axis=1).all()
    if np.isfinite(friction):
        np.testing.assert_allclose(
            critical_force(base, AROUND, drive).value, friction * 2.5 * GRAVITY / 4 * effective_motors(base, AROUND)
        )


def test_no_acceleration_is_left_at_top_speed_but_to_brake():
    base, drive = symmetric(radius=0.09, alpha=0.6), limits()
    top = speed_envelope(base, [np.pi / 2], drive).value[0]
    twist = np.array([0.0, top, 0.0])
    assert np.abs(rim_speeds(base, twist)).max() == pytest.approx(drive.rim_speed)
    ahead, back = acceleration_envelope(base, [np.pi / 2, -np.pi / 2], drive, twist=twist).value
    assert ahead == pytest.approx(0.0, abs=1e-9)
    assert back > 3.0
    assert speed_envelope(base, [np.pi / 2], drive, turning=3.0).value[0] < top
    assert not speed_envelope(base, [0.0], drive, turning=1e4).reachable[0]


def test_turning_takes_from_the_rest():
    base, drive = soccer(radius=0.09, alpha=0.6), limits()
    quiet = acceleration_envelope(base, AROUND, drive)
    turning = acceleration_envelope(base, AROUND, drive, angular_acceleration=40.0)
    assert turning.reachable.all()
    other_way = acceleration_envelope(base, AROUND, drive, angular_acceleration=-40.0)
    assert (turning.value + other_way.value < 2.0 * quiet.value - 1e-3).any()  # one of both may even be helped
    assert (turning.value + other_way.value <= 2.0 * quiet.value + 1e-9).all()
    assert not acceleration_envelope(base, AROUND, drive, angular_acceleration=1e4).reachable.any()
    torque = 0.6 * 2.5 * 0.09**2 * 40.0
    same = force_envelope(base, AROUND, limits=drive.motor_limits(np.zeros(4))[1], torque=torque)
    np.testing.assert_allclose(turning.value, same.value / 2.5)


def test_load_moves_back_with_the_acceleration():
    phi = np.deg2rad([33, 147, 225, 315])
    base = arrangements.omni(phi, radius=0.09, wheel_radius=0.027, mass=2.5, com=(0.005, -0.01), com_height=0.06)
    high = drive_limits(base, MOTOR, GEAR, 0.3)
    places = 0.09 * np.column_stack([np.cos(phi), np.sin(phi)])
    assert high.loads.sum() == pytest.approx(2.5 * GRAVITY)
    np.testing.assert_allclose(high.loads @ places, 2.5 * GRAVITY * np.array([0.005, -0.01]), atol=1e-12)
    assert high.stance is not None
    moved = np.array([high.stance.loads(a)[0] - high.loads for a in np.eye(2)])
    np.testing.assert_allclose(moved.sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(moved @ places, -2.5 * 0.06 * np.eye(2), atol=1e-12)
    phi = AROUND
    flat = acceleration_envelope(base, phi, DriveLimits(MOTOR, GEAR, 0.027, 2.5, 0.3, high.loads))
    tall = acceleration_envelope(base, phi, high)
    assert (np.abs(tall.value - flat.value) > 1e-3).any()
    for k in range(0, 37, 6):  # at the edge its own loads allow just that much
        own = high.grip(tall.value[k] * np.array([np.cos(phi[k]), np.sin(phi[k])]))
        assert force_envelope(base, phi[k], limits=own).value[0] / 2.5 == pytest.approx(tall.value[k], rel=1e-9)


def test_limits_of_a_base():
    base = arrangements.omni(n=4, radius=0.09, wheel_radius=0.027, mass=2.5, com_height=0.05)
    drive = drive_limits(base, MOTOR, GEAR, 0.6)
    np.testing.assert_allclose(drive.loads, 2.5 * GRAVITY / 4)
    assert acceleration_envelope(base, [0.3], drive).value[0] > 0.0
    with pytest.raises(InputError, match="states no mass"):
        drive_limits(arrangements.omni(n=4, radius=0.09, wheel_radius=0.027), MOTOR, GEAR, 0.6)
    with pytest.raises(OutOfLimits, match="tips over"):
        drive_limits(
            arrangements.omni(n=4, radius=0.09, wheel_radius=0.027, mass=2.5, com=(0.2, 0.0)), MOTOR, GEAR, 0.6
        )


def test_forces_on_the_edge_push_where_they_should():
    base = soccer(radius=0.09)
    a = base_acceleration(base, [-1.0, -1.0, 1.0, 1.0], 1.0)
    np.testing.assert_allclose(a[1:], 0.0, atol=1e-12)
    assert effective_motors(base, 0.0)[0] == pytest.approx(a[0])


def test_errors_name_the_cause():
    with pytest.raises(ShapeError, match="directions"):
        effective_motors(soccer(), [[0.0]])
    with pytest.raises(ShapeError, match="limits"):
        force_envelope(soccer(), [0.0], limits=np.ones(3))
    with pytest.raises(OutOfLimits, match="lower limit"):
        force_envelope(soccer(), [0.0], limits=1.0, lower=2.0)
    with pytest.raises(OutOfLimits, match="wheels 0 to 3"):
        effective_motors(soccer(), [0.0], out=(4,))
    with pytest.raises(UnknownName, match="no driven wheel 'wheel 5'; there is wheel 1"):
        effective_motors(soccer(), [0.0], out=["wheel 5"])
    with pytest.raises(ShapeError, match="directions holds"):
        effective_motors(soccer(), ["a"])
    with pytest.raises(ShapeError, match=r"twist\[0\] is nan"):
        acceleration_envelope(soccer(), [0.0], limits(0.5), twist=[np.nan, 0.0, 0.0])
    with pytest.raises(OutOfLimits, match=r"friction is '0.5'"):
        limits("0.5")
    with pytest.raises(OutOfLimits, match="friction"):
        limits(-0.1)
    with pytest.raises(ShapeError, match="loads"):
        limits(0.5, -1.0)
    with pytest.raises(ShapeError, match="roller_angles"):
        limits(0.5, roller_angles=np.zeros(3))
    with pytest.raises(ShapeError, match="stance has 3 driven wheels"):
        limits(0.5, stance=Stance(np.eye(4, 2), 20.0, 0.0, (0, 1, 2)))
    assert effective_motors(Coupling(np.eye(3)), [0.0])[0] == pytest.approx(1.0)


def test_dead_motors_go_by_name():
    base, drive = soccer(), limits(0.5)
    for envelope in (critical_force, acceleration_envelope, speed_envelope):
        by_name, by_number = (envelope(base, AROUND, drive, out=o) for o in (["wheel 2"], [1]))
        np.testing.assert_array_equal(by_name.value, by_number.value)
    np.testing.assert_array_equal(
        effective_motors(base, AROUND, out="wheel 1"), effective_motors(base, AROUND, out=[0])
    )
