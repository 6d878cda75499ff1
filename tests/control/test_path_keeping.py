"""Path keeping, velocity estimate, allocation: laws of their steps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.control.base.force_kernels import Body, allocation, feasible_rate, force_part, wrench_of
from holonom.control.base.kernels import (
    Planar,
    estimate_step,
    ground_speed,
    keeping_step,
    pose_step,
    reference_at,
    wanted_acceleration,
)
from holonom.control.base.path_keeping import EstimateSettings, KeepingSettings
from holonom.errors import OutOfLimits

PARAMS = KeepingSettings().params(1e-3)
NOTHING = Planar(0.0, 0.0, 0.0)
R = 0.08
ANGLES = np.deg2rad([57.0, 135.0, 225.0, 303.0])
ROWS = np.column_stack([-np.sin(ANGLES), np.cos(ANGLES), np.full(4, R)])
small = st.floats(-1.0, 1.0)


def ideal(reference: np.ndarray, pose: Planar, steps: int, dt: float = 1e-3) -> Planar:
    """Path keeping of a base that does what it is told at once."""
    command, integral = Planar(*reference[3:6]), NOTHING
    for _ in range(steps):
        command, _, integral = keeping_step(PARAMS, reference, pose, command.turn, integral, command)
        pose = pose_step(pose, command, dt)
    return pose


@settings(max_examples=8)
@given(small, small, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_it_comes_to_a_pose_that_stands(x: float, y: float, turn: float, there: float) -> None:
    pose = ideal(np.array([0.3, -0.2, there, 0, 0, 0, 0, 0, 0]), Planar(x, y, turn), 8000)
    assert math.hypot(pose.x - 0.3, pose.y + 0.2) < 5e-3
    assert abs(math.remainder(pose.turn - there, 2.0 * math.pi)) < 5e-3


@given(small, small, small, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_feed_forward_is_the_same_velocity_in_the_world(
    vx: float, vy: float, w: float, heading: float, error: float
) -> None:
    """Without position error the command is the reference's world velocity, whatever the heading error."""
    reference = np.array([0.0, 0.0, heading, vx, vy, w, 0.0, 0.0, 0.0])
    c, s = math.cos(error), math.sin(error)
    before = Planar(c * vx + s * vy, c * vy - s * vx, w)
    command, _, _ = keeping_step(PARAMS, reference, Planar(0.0, 0.0, heading + error), 0.0, NOTHING, before)
    np.testing.assert_allclose([command.x, command.y], [before.x, before.y], atol=1e-9)


@given(small, small, small, small, small, small)
def test_acceleration_is_limited(x: float, y: float, turn: float, vx: float, vy: float, w: float) -> None:
    reference = np.array([0, 0, 0, 5.0, 5.0, 50.0, 0, 0, 0])
    before = Planar(vx, vy, w)
    command, ahead, _ = keeping_step(PARAMS, reference, Planar(x, y, turn), 0.0, NOTHING, before)
    assert math.hypot(command.x - vx, command.y - vy) <= PARAMS.max_acceleration * 1e-3 * (1 + 1e-9)
    assert abs(command.turn - w) <= PARAMS.max_turn_acceleration * 1e-3 * (1 + 1e-9)
    wanted = wanted_acceleration(PARAMS, command, Planar(-9.0, 9.0, 90.0), ahead)
    assert math.hypot(wanted.x, wanted.y) <= PARAMS.max_acceleration * (1 + 1e-9)
    assert abs(wanted.turn) <= PARAMS.max_turn_acceleration


def test_a_steady_command_turns_with_the_base() -> None:
    """A velocity that is constant in the world is no acceleration, however fast the base turns."""
    turn, v = 0.0, 2.0
    before = Planar(v, 0.0, 10.0)
    for _ in range(200):
        turn += 1e-2
        reference = np.array([0, 0, turn, v * math.cos(turn), -v * math.sin(turn), 10.0, 0, 0, 0])
        before, _, _ = keeping_step(PARAMS, reference, Planar(0, 0, turn), 10.0, NOTHING, before)
        assert math.hypot(before.x - reference[3], before.y - reference[4]) < 2e-2


@given(small, small, small, st.lists(st.floats(0.2, 1.0), min_size=4, max_size=4))
def test_allocated_forces_make_the_force_and_weigh_least(fx: float, fy: float, mz: float, w: list[float]) -> None:
    share, weights = np.zeros((4, 3)), np.array(w)
    allocation(ROWS, weights, share)
    force = share @ [fx, fy, R * mz]
    np.testing.assert_allclose(ROWS.T @ force, [fx, fy, R * mz], atol=1e-5)
    null = np.linalg.svd(ROWS.T)[2][-1]
    assert abs((force / weights) @ null) < 1e-4  # the weighted square sum has no slope along what does nothing


@pytest.mark.parametrize("gone", range(4))
def test_three_of_four_wheels_still_make_any_force(gone: int) -> None:
    share, weights = np.zeros((4, 3)), np.ones(4)
    weights[gone] = 0.0
    allocation(ROWS, weights, share)
    assert (share[gone] == 0.0).all()
    np.testing.assert_allclose(ROWS.T @ share, np.eye(3), atol=1e-4)


def test_two_wheels_make_what_they_can() -> None:
    share = np.zeros((4, 3))
    allocation(ROWS, np.array([1.0, 0.0, 0.0, 1.0]), share)
    wanted = ROWS.T @ [2.0, 0.0, 0.0, -1.0]
    np.testing.assert_allclose(ROWS.T @ share @ wanted, wanted, atol=1e-3)


@settings(max_examples=8)
@given(small, small, st.floats(-5.0, 5.0), st.integers(0, 3))
def test_estimate_settles_on_the_true_twist_without_the_wheel_left_out(
    vx: float, vy: float, w: float, out: int
) -> None:
    params = EstimateSettings(max_pull=20.0, bias_time=1.0).params(1e-3)
    rims = ROWS @ [vx, vy, w]
    rims[out] += 3.0
    weights = np.ones(4)
    weights[out] = 0.0
    twist, bias = NOTHING, 0.0
    carried = Planar(-w * vy, w * vx, 0.0)  # what accelerometers on a base feel that drives a circle
    for _ in range(6000):
        twist, bias = estimate_step(params, ROWS, weights, rims, twist, bias, w + 0.05, carried)
    np.testing.assert_allclose([twist.x, twist.y], [vx, vy], atol=0.02)
    assert twist.turn == pytest.approx(w, abs=0.02)
    assert bias == pytest.approx(0.05, abs=0.02)


def test_spinning_wheels_do_not_run_away_with_the_estimate() -> None:
    params = EstimateSettings(max_pull=0.2).params(1e-3)
    twist = NOTHING
    for _ in range(1000):
        twist, _ = estimate_step(params, ROWS, np.ones(4), ROWS @ [5.0, 0.0, 0.0], twist, 0.0, 0.0, NOTHING)
    assert twist.x == pytest.approx(0.2, rel=1e-6)


@given(small, small, st.floats(-3.0, 3.0))
def test_dead_reckoning_along_an_arc(vx: float, vy: float, w: float) -> None:
    pose = NOTHING
    for _ in range(1000):
        pose = pose_step(pose, Planar(vx, vy, w), 1e-3)
    a = math.sin(w) / w if abs(w) > 1e-9 else 1.0
    b = (1.0 - math.cos(w)) / w if abs(w) > 1e-9 else 0.0
    np.testing.assert_allclose([pose.x, pose.y, pose.turn], [a * vx - b * vy, b * vx + a * vy, w], atol=1e-8)


def test_a_slower_reference_needs_its_rate_squared() -> None:
    t = np.arange(200) * 1e-3
    reference = np.zeros((200, 9))
    reference[:, 0], reference[:, 3], reference[:, 6] = t**2, 2 * t, 2.0
    now = np.zeros(9)
    reference_at(reference, 50.5, 0.5, 0.0, now)
    np.testing.assert_allclose(now[[3, 6]], [0.5 * 2 * 0.0505, 0.25 * 2.0])
    assert now[0] == pytest.approx(0.0505**2, abs=1e-6)
    reference_at(reference, 50.0, 1.0, -1.0, now)
    assert now[6] == pytest.approx(2.0 - 2 * 0.05)
    share = np.zeros((4, 3))
    allocation(ROWS, np.ones(4), share)
    worst = max(abs(ground_speed(share, i, Planar(2.0 * 5.0, 0.0, 0.0))) for i in range(4))
    assert feasible_rate(share, reference, 0, Body(5.0, 0.1, 0.0, 0.0), np.full(4, 0.25 * worst)) == pytest.approx(0.5)
    assert feasible_rate(share, reference, 0, Body(5.0, 0.1, 0.0, 0.0), np.full(4, 2.0 * worst)) == 1.0
    assert force_part(share, Planar(10.0, 0.0, 0.0), np.full(4, 0.5 * worst)) == pytest.approx(0.5)


def test_bad_settings() -> None:
    with pytest.raises(OutOfLimits, match="bandwidth"):
        KeepingSettings(bandwidth=0.0)
    with pytest.raises(OutOfLimits, match="max_pull"):
        EstimateSettings(max_pull=-1.0)


@given(small, small, small, small, small, small)
def test_a_wrench_is_newtons_and_eulers(ax: float, ay: float, wd: float, w: float, x: float, y: float) -> None:
    """By d/dt of momentum and of angular momentum about a fixed point, in complex numbers."""
    mass, inertia, c = 3.0, 0.05, complex(x, y)
    a = complex(ax, ay) + 1j * wd * c - w * w * c  # of the centre of mass
    found = wrench_of(Body(mass, inertia, x, y), Planar(ax, ay, wd), w)
    assert complex(found.x, found.y) == pytest.approx(mass * a)
    assert found.turn == pytest.approx(inertia * wd + mass * (c.conjugate() * a).imag)
