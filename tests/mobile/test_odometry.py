"""Odometry: laws of the integration rules, of covariance and of flags; every drive by its own forward model."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.errors import LogError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile import arrangements, poses
from holonom.mobile.odometry import (
    RULES,
    angle_per_tick,
    count_differences,
    find_gaps,
    flag,
    increment_noise,
    integrate,
    integrate_with_covariance,
    metres_per_tick,
    steering_jacobians,
)
from holonom.mobile.odometry.kernels import sensitivities_into, step_jacobians

seeds = st.integers(0, 2**32 - 1)


def arc(twist: np.ndarray, t: float) -> np.ndarray:
    """Pose after a constant twist, in closed form: the exponential of SE(2), written out."""
    vx, vy, w = twist
    a = w * t
    s, c = (np.sin(a) / w, (1.0 - np.cos(a)) / w) if w else (t, 0.0)
    return np.array([s * vx - c * vy, c * vx + s * vy, a])


def plain(increments: np.ndarray, rule: str) -> np.ndarray:
    """The rules once more, with cumulative sums."""
    turn = increments[:, 2]
    theta = np.cumsum(turn) - turn
    angle = theta + (turn if rule == "turn_then_drive" else 0.5 * turn)
    step = (increments[:, 0] + 1j * increments[:, 1]) * np.exp(1j * angle)
    if rule == "exact":
        step = step * np.sinc(turn / (2.0 * np.pi))
    place = np.cumsum(step)
    return np.stack([place.real, place.imag, np.cumsum(turn)], axis=1)


@given(seeds, st.sampled_from(sorted(RULES)))
def test_rules_agree_with_cumulative_sums(seed: int, rule: str) -> None:
    increments = np.random.default_rng(seed).normal(size=(50, 3))
    assert np.allclose(integrate(increments, rule=rule), plain(increments, rule), atol=1e-12)


@given(seeds)
def test_constant_twists_are_exact_on_arcs(seed: int) -> None:
    twist = np.random.default_rng(seed).normal(size=3)
    for w in (twist[2], 0.0, 1e-6):
        steps = np.tile(0.1 * np.array([*twist[:2], w]), (20, 1))
        assert np.allclose(integrate(steps, rule="exact")[-1], arc(np.array([*twist[:2], w]), 2.0), atol=1e-12)


@given(seeds, st.integers(0, 200))
def test_exact_arcs_agree_with_the_exponential(seed: int, count: int) -> None:
    """Blocks of any length, against `poses.integrated`, which knows no blocks."""
    rng = np.random.default_rng(seed)
    twists, start = rng.normal(size=(count, 3)), rng.normal(size=3)
    expected = poses.integrated(start, twists, np.full(count, 0.1))[1:]
    assert np.allclose(integrate(0.1 * twists, start=start, rule="exact"), expected, atol=1e-10)


@given(seeds, st.integers(1, 5))
def test_wheels_are_turned_into_increments_on_the_way(seed: int, wheels: int) -> None:
    rng = np.random.default_rng(seed)
    turns, M, out = rng.normal(size=(70, wheels)), rng.normal(size=(3, wheels)), np.empty((70, 3))
    assert integrate(turns, matrix=M, out=out) is out
    assert np.allclose(out, integrate(turns @ M.T), atol=1e-10)


def test_orders_of_the_rules() -> None:
    """Halving the step halves the error of turn-then-drive and quarters that of the midpoint."""
    twist, end = np.array([1.0, 0.3, 0.8]), arc(np.array([1.0, 0.3, 0.8]), 1.0)

    def error(rule: str, n: int) -> float:
        return float(np.linalg.norm(integrate(np.tile(twist / n, (n, 1)), rule=rule)[-1] - end))

    assert error("turn_then_drive", 100) / error("turn_then_drive", 200) == pytest.approx(2.0, abs=0.05)
    assert error("midpoint", 100) / error("midpoint", 200) == pytest.approx(4.0, abs=0.05)


@given(seeds, st.sampled_from(sorted(RULES)))
def test_the_frame_does_not_matter(seed: int, rule: str) -> None:
    rng = np.random.default_rng(seed)
    increments, start = rng.normal(size=(10, 3)), rng.normal(size=3)
    from_zero, moved = integrate(increments, rule=rule), integrate(increments, start=start, rule=rule)
    turned = (from_zero[:, 0] + 1j * from_zero[:, 1]) * np.exp(1j * start[2]) + start[0] + 1j * start[1]
    assert np.allclose(moved, np.stack([turned.real, turned.imag, from_zero[:, 2] + start[2]], axis=1))


BASES = [
    (arrangements.differential(0.3, 0.05), [0.4, 0.0, 0.9]),
    (arrangements.omni(n=3, radius=0.2, wheel_radius=0.05), [0.4, -0.2, 0.9]),
    (arrangements.omni(n=5, radius=0.2, wheel_radius=0.05), [0.4, -0.2, 0.9]),
    (arrangements.mecanum(0.3, 0.2, 0.05), [0.4, -0.2, 0.9]),
    (arrangements.tricycle(0.4, 0.3, 0.05), [0.4, 0.0, 0.5]),
    (arrangements.ackermann(0.4, 0.3, 0.05), [0.4, 0.0, 0.5]),
    (arrangements.swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05), [0.4, -0.2, 0.9]),
]


@pytest.mark.parametrize(("base", "twist"), BASES, ids=lambda x: x.name if hasattr(x, "name") else "")
def test_every_drive_goes_round_its_arc(base, twist) -> None:
    """Wheel angles of a constant twist, through the base's own forward model, make the arc."""
    twist = np.array(twist)
    steering = base.steering(twist) if base.steered else None
    turns = 0.01 * np.tile(base.wheel_speeds(twist, steering), (300, 1))
    angles = None if steering is None else np.tile(steering, (300, 1))
    path = integrate(base.twist(turns, angles), rule="exact")
    assert np.allclose(path[-1], arc(twist, 3.0), atol=1e-9)


def test_ticks_and_counters() -> None:
    assert metres_per_tick(0.084, 64, 43.7) == pytest.approx(np.pi * 0.084 / (43.7 * 64))
    assert angle_per_tick(1600) == pytest.approx(2.0 * np.pi / 1600)
    counts = np.array([[250.0, 3.0], [2.0, 250.0], [10.0, 240.0]])
    assert np.array_equal(count_differences(counts, bits=8), [[0, 0], [8, -9], [8, -10]])
    assert np.array_equal(count_differences(counts), [[0, 0], [-248, 247], [8, -10]])
    for call, problem in (
        (lambda: metres_per_tick(0.0, 64), OutOfLimits),
        (lambda: angle_per_tick(64, np.nan), OutOfLimits),
        (lambda: count_differences([1.0, 2.0]), ShapeError),
        (lambda: count_differences([[np.nan]]), ShapeError),
        (lambda: count_differences(counts, bits=7), OutOfLimits),
        (lambda: count_differences(counts, bits=0), OutOfLimits),
        (lambda: integrate([[1.0, 2.0]]), ShapeError),
        (lambda: integrate([[1.0, 2.0, np.inf]]), ShapeError),
        (lambda: integrate([["a", "b", "c"]]), ShapeError),
        (lambda: integrate(np.zeros((2, 3)), start=(0, 0)), ShapeError),
        (lambda: integrate(np.zeros((2, 3)), rule="eaxct"), UnknownName),
        (lambda: integrate(np.zeros((2, 3)), matrix=np.zeros((3, 2))), ShapeError),
        (lambda: integrate(np.zeros((2, 2)), matrix=np.zeros((2, 2))), ShapeError),
        (lambda: integrate(np.zeros((2, 3)), out=np.empty((3, 3))), ShapeError),
    ):
        with pytest.raises(problem):
            call()


def test_the_row_that_is_no_number_is_named() -> None:
    rows = np.zeros((9, 3))
    rows[4, 2] = np.nan
    with pytest.raises(ShapeError, match=r"increments: row 4, column 2 holds nan"):
        integrate(rows)
    with pytest.raises(ShapeError, match="increments are no numbers"):
        integrate([["a", "b", "c"]])


@given(seeds, st.sampled_from(sorted(RULES)))
def test_jacobians_of_a_step_by_finite_differences(seed: int, rule: str) -> None:
    rng = np.random.default_rng(seed)
    share, exact = RULES.make(rule)
    pose, increment = rng.normal(size=3), rng.normal(size=3) * 10.0 ** rng.integers(-5, 1)
    F, G = np.empty((3, 3)), np.empty((3, 3))
    step_jacobians(pose[2], increment, share, exact, F, G)
    h = 1e-6
    for k, d in enumerate(h * np.eye(3)):
        by_pose = [integrate(increment[None], start=pose + s * d, rule=rule)[0] for s in (1, -1)]
        by_step = [integrate((increment + s * d)[None], start=pose, rule=rule)[0] for s in (1, -1)]
        assert np.allclose(F[:, k], (by_pose[0] - by_pose[1]) / (2 * h), atol=1e-8)
        assert np.allclose(G[:, k], (by_step[0] - by_step[1]) / (2 * h), atol=1e-8)


@given(seeds, st.integers(1, 4), st.sampled_from(sorted(RULES)))
def test_sensitivities_by_finite_differences(seed: int, wheels: int, rule: str) -> None:
    rng = np.random.default_rng(seed)
    share, exact = RULES.make(rule)
    features, M, start = 0.3 * rng.normal(size=(20, wheels)), rng.normal(size=(3, wheels)), rng.normal(size=3)
    path, slopes = np.empty((20, 3)), np.empty((20, 3, 3 * wheels))
    by_M = np.zeros((20, 3, 3 * wheels))
    for k, (row, column) in enumerate(np.ndindex(M.shape)):
        by_M[:, row, k] = features[:, column]
    sensitivities_into(features @ M.T, by_M, start, share, exact, path, slopes)
    assert np.allclose(path, integrate(features @ M.T, start=start, rule=rule))
    for k, at in enumerate(np.ndindex(M.shape)):
        step = np.zeros_like(M)
        step[at] = 1e-6
        ahead, back = (integrate(features @ (M + s * step).T, start=start, rule=rule) for s in (1, -1))
        assert np.allclose(slopes[:, :, k], (ahead - back) / 2e-6, atol=1e-6)


def test_covariance_agrees_with_many_noisy_runs() -> None:
    """Siegwart's model: variance of each rim's way proportional to it; 4,000 paths against the propagated ellipse."""
    rng = np.random.default_rng(5)
    base = arrangements.differential(0.3, 0.05)
    A = base.twist(np.eye(2)).T / 0.05  # per way of the rims
    travel = np.tile([[0.01, 0.012]], (200, 1))
    factor = 4e-5
    told = integrate_with_covariance(travel @ A.T, increment_noise(A, travel, factor))
    noisy = travel + rng.normal(size=(4000, 200, 2)) * np.sqrt(factor * np.abs(travel))
    ends = np.stack([integrate(way @ A.T)[-1] for way in noisy])
    assert np.allclose(told.poses, integrate(travel @ A.T))
    spread, size = np.cov(ends.T), np.sqrt(np.diagonal(told.covariance[-1]))
    assert np.allclose(spread / np.outer(size, size), told.covariance[-1] / np.outer(size, size), atol=0.08)
    assert np.linalg.eigvalsh(told.covariance).min() > -1e-12


STEERED = [
    (arrangements.tricycle(0.4, 0.3, 0.05), [0.4, 0.0, 0.5]),
    (arrangements.ackermann(0.4, 0.3, 0.05), [0.4, 0.0, 0.5]),
    (arrangements.swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05), [0.4, -0.2, 0.5]),
]


@pytest.mark.parametrize(("base", "twist"), STEERED, ids=[base.name for base, _ in STEERED])
def test_covariance_of_steered_bases_agrees_with_many_noisy_runs(base, twist) -> None:
    """Noise of every rim's way and of every angle, through the base's own forward model, while the steering moves."""
    rng = np.random.default_rng(7)
    share = np.linspace(0.5, 1.5, 40)[:, None]
    steering = base.steering(np.array(twist) * np.hstack([np.ones((40, 2)), share]))
    turns = 0.05 * base.wheel_speeds(np.array(twist) * np.hstack([np.ones((40, 2)), share]), steering)
    travel, factor, deviation = turns * 0.05, 4e-5, 0.02
    by_way, by_angle = steering_jacobians(base, travel, steering)
    noise = increment_noise(by_way, travel, factor, steering_jacobian=by_angle, steering_deviation=deviation)
    told = integrate_with_covariance(base.twist(turns, steering), noise)
    count = 4000
    ways = travel + rng.normal(size=(count, *travel.shape)) * np.sqrt(factor * np.abs(travel))
    angles = steering + deviation * rng.normal(size=(count, *steering.shape))
    steps = base.twist((ways / 0.05).reshape(-1, travel.shape[1]), angles.reshape(-1, steering.shape[1]))
    ends = np.stack([integrate(rows)[-1] for rows in steps.reshape(count, 40, 3)])
    spread, size = np.cov(ends.T), np.sqrt(np.diagonal(told.covariance[-1]))
    assert np.allclose(spread / np.outer(size, size), told.covariance[-1] / np.outer(size, size), atol=0.1)
    without = increment_noise(by_way, travel, factor)
    assert np.all(np.linalg.eigvalsh(noise - without) > -1e-15)
    assert np.trace(noise.sum(0)) > 1.1 * np.trace(without.sum(0))


@pytest.mark.parametrize(("base", "twist"), STEERED, ids=[base.name for base, _ in STEERED])
def test_increments_are_linear_in_the_ways_of_the_rims(base, twist) -> None:
    steering = np.tile(base.steering(np.array(twist)), (3, 1))
    travel = np.random.default_rng(1).normal(size=(3, len(base.driven)))
    by_way, by_angle = steering_jacobians(base, travel, steering)
    assert np.allclose(np.einsum("nij,nj->ni", by_way, travel), base.twist(travel / 0.05, steering))
    assert by_angle.shape == (3, 3, len(base.steered))


@given(seeds)
def test_covariance_starts_where_it_is_told_and_turns_with_the_base(seed: int) -> None:
    rng = np.random.default_rng(seed)
    P = np.diag(rng.uniform(0.1, 1.0, 3))
    path = integrate_with_covariance(np.array([[1.0, 0.0, 0.0]]), np.zeros((3, 3)), covariance=P)
    assert path.covariance[0, 1, 1] == pytest.approx(P[1, 1] + P[2, 2])  # a metre on, heading swings sideways
    assert path.covariance[0, 0, 0] == pytest.approx(P[0, 0])


def test_bad_covariances_are_refused() -> None:
    with pytest.raises(ShapeError, match=r"give \(2, 3, 3\)"):
        integrate_with_covariance(np.zeros((2, 3)), np.zeros((3, 3, 3)))
    with pytest.raises(ShapeError, match="samples, wheels"):
        increment_noise(np.zeros((3, 2)), np.zeros((5, 3)), 0.1)
    with pytest.raises(OutOfLimits, match="from zero up"):
        increment_noise(np.zeros((3, 2)), np.zeros((5, 2)), -0.1)
    with pytest.raises(ShapeError, match=r"give \(3, wheels\) or \(samples, 3, wheels\)"):
        increment_noise(np.zeros((4, 3, 2)), np.zeros((5, 2)), 0.1)
    with pytest.raises(ShapeError, match="give one, or 2"):
        increment_noise(np.zeros((3, 2)), np.zeros((5, 2)), [0.1, 0.1, 0.1])
    with pytest.raises(ShapeError, match=r"give \(5, 3, steered wheels\)"):
        increment_noise(np.zeros((3, 2)), np.zeros((5, 2)), 0.1, steering_jacobian=np.zeros((4, 3, 1)))
    with pytest.raises(OutOfLimits, match=r"steering deviations .* rad"):
        increment_noise(
            np.zeros((3, 2)), np.zeros((5, 2)), 0.1, steering_jacobian=np.zeros((5, 3, 1)), steering_deviation=-1.0
        )
    with pytest.raises(ShapeError, match=r"give \(samples, 1\) and \(samples, 1\)"):
        steering_jacobians(arrangements.tricycle(0.4, 0.3, 0.05), np.zeros((5, 1)), np.zeros((4, 1)))


def test_gaps_slip_and_impossible_motion_are_flagged() -> None:
    base = arrangements.omni(n=4, radius=0.2, wheel_radius=0.05)
    time = np.arange(50) * 0.01
    time[30:] += 0.05
    turns = 0.01 * np.tile(base.wheel_speeds([0.5, 0.1, 0.2]), (50, 1))
    turns[30] *= 6.0  # went on during the gap
    turns[10, 2] += 0.05  # a wheel on ice
    turns[40] *= 9.0
    dt = np.diff(time, prepend=-0.01)
    residual = base.residual(turns / dt[:, None])
    found = flag(time, base.twist(turns), residual=residual, max_residual=0.01, max_speed=1.0, max_acceleration=80.0)
    assert np.flatnonzero(found.gap).tolist() == [30]
    assert np.flatnonzero(found.slip).tolist() == [10]
    assert np.flatnonzero(found.implausible).tolist() == [40, 41]
    assert np.flatnonzero(found.any).tolist() == [10, 30, 40, 41]
    assert not flag(time, base.twist(turns)).slip.any()
    with pytest.raises(LogError, match="sample 1"):
        find_gaps([0.0, 0.0, 1.0])
    with pytest.raises(OutOfLimits, match="above 1"):
        find_gaps([0.0, 1.0], factor=1.0)
    with pytest.raises(ShapeError, match="give one each"):
        flag(time, np.zeros((3, 3)))
    with pytest.raises(ShapeError, match="residuals"):
        flag(time, np.zeros((50, 3)), residual=np.zeros(50))
