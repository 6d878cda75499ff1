from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motion_arms import Limits, limits_of
from scipy.interpolate import PPoly

from holonom.errors import MotionError, OutOfLimits, ShapeError
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.motion import JointPath, Trajectory, joint_spline, retime, sample, time_law

MIDDLE = np.array([0.1, 0.7, -2.0, 0.2, 0.5, 0.1])


@pytest.fixture(scope="module")
def puma() -> Arm:
    return load_arm("puma560")


def winding(seed: int, degree: int = 3, n: int = 6) -> JointPath:
    rng = np.random.default_rng(seed)
    return joint_spline(MIDDLE[:n] + rng.uniform(-0.6, 0.6, (6, n)), degree=degree)


def straight(q0: list[float], q1: list[float]) -> JointPath:
    return joint_spline([q0, q1])


def use(motion: Trajectory, limits: Limits) -> np.ndarray:
    return np.maximum(np.abs(motion.qd) / limits.speed, np.abs(motion.qdd) / limits.acceleration).max(axis=1)


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.sampled_from([3, 5]), st.floats(0.3, 4.0), st.floats(1.0, 30.0))
def test_limits_hold_at_and_between_samples_and_one_is_touched(
    seed: int, degree: int, speed: float, acceleration: float
) -> None:
    path, limits = winding(seed, degree, 4), limits_of(4, speed=speed, acceleration=acceleration)
    motion = retime(path, limits)
    assert use(motion, limits).max() <= 1.0 + 1e-6
    assert np.mean(use(motion, limits) > 0.95) > 0.95
    ends = path(path.x[[0, -1]])
    np.testing.assert_array_equal(motion.q[[0, -1]], ends)
    assert not motion.qd[[0, -1]].any()
    # between samples: mean speed and mean acceleration of every step
    assert (np.abs(np.diff(motion.q, axis=0)) / motion.dt <= speed * (1 + 1e-6)).all()
    assert (np.abs(np.diff(motion.qd, axis=0)) / motion.dt <= acceleration * (1 + 1e-6)).all()
    step = 0.5 * (motion.qd[1:] + motion.qd[:-1]) * motion.dt
    np.testing.assert_allclose(np.diff(motion.q, axis=0), step, atol=2 * acceleration * motion.dt**2)


@given(st.floats(0.3, 4.0), st.floats(1.0, 30.0), st.floats(0.1, 3.0))
def test_a_straight_path_takes_the_time_of_the_trapezoid(speed: float, acceleration: float, way: float) -> None:
    """Its closed form: way / v + v / a, or 2 sqrt(way / a) where the full speed is not reached."""
    limits = limits_of(2, speed=speed, acceleration=acceleration)
    motion = retime(straight([0.0, 0.0], [way, -0.3 * way]), limits)
    top = min(speed, np.sqrt(way * acceleration))
    assert motion.duration == pytest.approx(way / top + top / acceleration, abs=2e-3, rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_it_is_faster_than_the_best_trapezoid_along_the_same_path(puma: Arm, seed: int) -> None:
    path, limits = winding(seed), puma.limits
    way = path.x[-1] - path.x[0]

    def trapezoid(rate: float, ramp: float) -> tuple[float, float]:
        """Its duration once it is slowed until it keeps all limits, by how much it passes them."""
        law = time_law(way, rate, ramp, profile="trapezoid")
        s = sample(law, np.linspace(0.0, law.duration, 2000))
        at = s.s * 1.0 / s.s[-1] * way + path.x[0]
        qd = path(at, 1) * (way * s.ds / s.s[-1])[:, None]
        qdd = path(at, 1) * (way * s.dds)[:, None] + path(at, 2) * (way * s.ds)[:, None] ** 2
        slow = max((np.abs(qd) / limits.speed).max(), np.sqrt((np.abs(qdd) / limits.acceleration).max()))
        return law.duration * slow, slow

    best = min(trapezoid(way, ramp * way)[0] for ramp in np.geomspace(0.5, 50.0, 15))
    assert retime(path, limits).duration < 0.9 * best


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("part", [1.0, 0.5])
def test_torques_stay_within_their_limits(puma: Arm, seed: int, part: float) -> None:
    path, limits = winding(seed), replace(puma.limits, acceleration=np.full(6, np.inf))
    torque = part * puma.limits.torque
    motion = retime(path, limits, arm=puma, torque=torque)
    load = np.abs(puma.inverse_dynamics(motion.q, motion.qd, motion.qdd)) / torque
    speed = np.abs(motion.qd) / limits.speed
    assert load.max() <= 1.0 + 1e-6
    assert speed.max() <= 1.0 + 1e-6
    assert np.mean(np.maximum(load, speed).max(axis=1) > 0.97) > 0.95
    half = 0.5 * (motion.q[1:] + motion.q[:-1]), 0.5 * (motion.qd[1:] + motion.qd[:-1])
    between = np.abs(puma.inverse_dynamics(*half, np.diff(motion.qd, axis=0) / motion.dt)) / torque
    same_way = motion.qd[1:] * motion.qd[:-1] > 0.0  # friction jumps where a joint turns back
    assert between[same_way].max() <= 1.0 + 2e-3


def test_less_torque_takes_longer(puma: Arm) -> None:
    path, limits = winding(1), replace(puma.limits, acceleration=np.full(6, np.inf))
    times = [retime(path, limits, arm=puma, torque=k * puma.limits.torque).duration for k in (0.4, 0.5, 0.7, 1.0, 2.0)]
    assert (np.diff(times) < 0.0).all()


def test_the_way_back_takes_as_long_with_kinematic_limits() -> None:
    points = np.random.default_rng(3).uniform(-1, 1, (5, 3))
    there = retime(joint_spline(points), limits_of(3))
    back = retime(joint_spline(points[::-1]), limits_of(3))
    assert back.duration == pytest.approx(there.duration, abs=2e-3)


@pytest.mark.parametrize("degree", [3, 5])
def test_a_spline_meets_its_points_and_is_smooth(degree: int) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (6, 3))
    path = joint_spline(points, degree=degree)
    np.testing.assert_allclose(path(path.x), points, atol=1e-12)
    inner = path.x[1:-1]
    for nu in range(degree):
        np.testing.assert_allclose(path(inner - 1e-9, nu), path(inner, nu), atol=1e-3)
    assert np.abs(path(inner - 1e-9, degree) - path(inner, degree)).max() > 0.1


def test_bad_limits_name_the_joint() -> None:
    path = straight([0.0, 0.0], [1.0, 1.0])
    for name in ("speed", "acceleration"):
        limits = replace(limits_of(2), **{name: np.array([1.0, 0.0])})
        with pytest.raises(OutOfLimits, match=f"{name} limit of joint 2 is 0; retiming needs a positive one"):
            retime(path, limits)
    with pytest.raises(OutOfLimits, match="joint 1 has speed limit inf"):
        retime(path, replace(limits_of(2), speed=np.array([np.inf, 1.0])))
    with pytest.raises(OutOfLimits, match="finite acceleration or torque"):
        retime(path, replace(limits_of(2), acceleration=np.array([1.0, np.inf])))
    with pytest.raises(ShapeError, match=r"speed limits have shape \(3,\); the path has 2 joints"):
        retime(path, limits_of(3))
    with pytest.raises(OutOfLimits, match="go together"):
        retime(path, limits_of(2), torque=[1.0, 1.0])


def test_a_corner_is_refused_with_its_place() -> None:
    zigzag = PPoly(np.array([[[1.0, 0.5], [1.0, -1.0]], [[0.0, 0.0], [1.0, 0.5]]]), [0.0, 1.0, 2.0])
    with pytest.raises(MotionError, match=r"at 50\.0 % of the path, .* joint 2 turns a corner"):
        retime(zigzag, limits_of(2))


def test_a_path_that_stands_still_is_refused() -> None:
    steep = PPoly(np.array([[[1.0]], [[0.0]], [[0.0]], [[-1.0]]]), [-1.0, 1.0])  # (s + 1)^3 - 1: an inflection at rest
    with pytest.raises(MotionError, match=r"at 0\.0 % .* stands still .* a parameter that runs on"):
        retime(steep, limits_of(1))


@pytest.mark.parametrize("way", [0.4, 3.0])
def test_a_path_that_turns_back_takes_the_time_of_two_trapezoids(way: float) -> None:
    """The joint rests where the path turns, dq/ds = 0; the path itself runs on there."""
    speed, acceleration = 0.5, 0.2
    ramp = speed**2 / acceleration
    once = 2.0 * np.sqrt(way / acceleration) if way < ramp else way / speed + speed / acceleration
    for n in (1, 3):
        done = retime(joint_spline(np.outer([0.0, way, 0.0], np.ones(n))), limits_of(n, speed=speed, acceleration=0.2))
        assert done.duration == pytest.approx(2.0 * once, abs=4e-3)
        middle = len(done.q) // 2
        np.testing.assert_allclose(done.q[middle], way, atol=1e-5)
        np.testing.assert_allclose(done.qd[middle], 0.0, atol=1e-3)
        assert np.abs(done.qdd).max() <= acceleration * (1.0 + 1e-6)


def test_a_parabola_turns_back_between_breakpoints() -> None:
    there_and_back = PPoly(np.array([[[-1.0]], [[2.0]], [[0.0]]]), [0.0, 2.0])  # 2 s - s^2: to 1 and back
    duration = retime(there_and_back, limits_of(1, speed=0.5, acceleration=0.2)).duration
    assert duration == pytest.approx(2.0 * 2.0 * np.sqrt(1.0 / 0.2), abs=6e-3)


def test_an_arm_turns_back_within_its_torques(puma: Arm) -> None:
    """All joints rest at once in the middle; there and back take the time of there and of back."""
    ends = np.array([[0.1, 1.5, -2.8, 0.2, 0.5, 0.1], [0.4, 1.2, -2.5, 0.0, 0.9, 0.3]])
    strength = 0.6 * puma.limits.torque
    both = retime(joint_spline(ends[[0, 1, 0]]), puma.limits, arm=puma, torque=strength)
    tau = puma.inverse_dynamics(both.q, both.qd, both.qdd)
    assert (np.abs(tau) / strength).max() <= 1.0 + 1e-5
    parts = [
        retime(joint_spline(ends[pair]), puma.limits, arm=puma, torque=strength).duration for pair in ([0, 1], [1, 0])
    ]
    assert both.duration == pytest.approx(sum(parts), abs=0.01)


def test_a_motion_of_more_samples_than_can_be_held_is_refused() -> None:
    with pytest.raises(
        MotionError, match=r"lasts 1.001e\+06 s, more than 20000000 samples of 0.001 s; give a longer dt="
    ):
        retime(straight([0.0], [1.0]), limits_of(1, speed=1e-6, acceleration=1.0))


def test_a_path_outside_the_limits_names_joint_and_place() -> None:
    with pytest.raises(MotionError, match=r"at 60\.\d % .* joint 2 is outside its limits -10 to 10"):
        retime(straight([0.0, 4.0], [0.0, 14.0]), limits_of(2))


def test_torques_too_weak_to_hold_the_arm_name_joint_and_place(puma: Arm) -> None:
    path = straight([0.1, 1.5, -2.8, 0.2, 0.5, 0.1], [0.1, 0.2, -2.8, 0.2, 0.5, 0.1])
    weak = puma.limits.torque * [1.0, 0.1, 1.0, 1.0, 1.0, 1.0]
    with pytest.raises(
        MotionError, match=r"% of the path, q = .* joint 2 needs .* against gravity; its torque limit is 18"
    ):
        retime(path, puma.limits, arm=puma, torque=weak)


def test_spline_points() -> None:
    with pytest.raises(ShapeError, match="points 1 and 2 are the same"):
        joint_spline([[0.0], [1.0], [1.0]])
    with pytest.raises(ShapeError, match=r"points have shape \(1, 1\)"):
        joint_spline([[0.0]])
    for wrong in ([0.0, np.inf], [1.0, 0.0], [0.0, np.nan]):
        with pytest.raises(ShapeError, match="give one finite, rising number per point"):
            joint_spline([[0.0], [1.0]], s=wrong)
    with pytest.raises(ShapeError, match="no slope can be that steep"):
        joint_spline([[0.0], [1.0]], s=[0.0, 1e-320])
    for uneven in ([[0.0], [1e100], [1e101]], [[0.0], [1e-100], [1.0]]):
        with pytest.raises(ShapeError, match="too uneven for a spline of degree 5"):
            joint_spline(uneven, degree=5)
    with pytest.raises(OutOfLimits, match="degree 4"):
        joint_spline([[0.0], [1.0]], degree=4)


def peers_time(path, points, limits) -> float:
    """TOPP-RA's, on the same spline."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the peer's own
        ta = pytest.importorskip("toppra", reason="peer toppra is not installed; pip install -e '.[oracle]'")
        from toppra import algorithm, constraint
    theirs = ta.SplineInterpolator(path.x, points, bc_type="natural")
    bounds = [np.stack([-x, x], axis=-1) for x in (limits.speed, limits.acceleration)]
    rules = [constraint.JointVelocityConstraint(bounds[0]), constraint.JointAccelerationConstraint(bounds[1])]
    grid = np.linspace(path.x[0], path.x[-1], 2001)
    peer = algorithm.TOPPRA(rules, theirs, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    return float(peer.compute_trajectory(0, 0).duration)


@pytest.mark.oracle
@pytest.mark.parametrize("seed", range(4))
def test_times_agree_with_toppra(seed: int) -> None:
    points, limits = np.random.default_rng(seed).uniform(-1, 1, (6, 4)), limits_of(4, speed=1.5, acceleration=6.0)
    path = joint_spline(points)
    assert retime(path, limits).duration == pytest.approx(peers_time(path, points, limits), abs=3e-3)


@pytest.mark.oracle
@pytest.mark.parametrize(
    "points",
    [
        [[0.0], [0.4], [0.0]],  # 5.659 s
        [[0.0], [0.4], [0.0], [0.3], [-0.2], [0.1]],
        [[0.0, 0.2], [0.4, -0.5], [0.0, 0.2]],
    ],
)
def test_paths_that_turn_back_take_the_time_of_toppra(points: list[list[float]]) -> None:
    limits, path = limits_of(len(points[0]), speed=0.5, acceleration=0.2), joint_spline(points)
    assert retime(path, limits).duration == pytest.approx(peers_time(path, np.array(points), limits), abs=4e-3)
