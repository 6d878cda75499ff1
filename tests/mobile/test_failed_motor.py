"""Laws of a dead motor: met where it can be, the least that is missed, what a blocked wheel allows."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from omni_bases import scattered, soccer, symmetric
from scipy import optimize

from holonom.errors import OutOfLimits, ShapeError, UnknownName
from holonom.mobile.drive.coupling import base_acceleration, rim_speeds, wheel_forces
from holonom.mobile.drive.envelopes import force_envelope
from holonom.mobile.drive.failed_motor import (
    Reach,
    actuation,
    allocation,
    feasible_twist,
    possible_twists,
    redistribute,
)

SEEDS = st.integers(0, 10**6)
MASS = 2.5


@given(SEEDS, st.integers(4, 8), st.sampled_from(["norm", "peak"]))
def test_every_acceleration_is_met_without_one_motor(seed, n, least):
    rng = np.random.default_rng(seed)
    base, a, out = scattered(rng, n), rng.normal(size=3) * [3, 3, 30], int(rng.integers(n))
    found = redistribute(base, a, MASS, out=[out], least=least)
    assert found.status == Reach.MET
    assert found.forces[out] == 0.0
    np.testing.assert_allclose(found.acceleration, a, atol=1e-6)
    np.testing.assert_allclose(base_acceleration(base, found.forces, MASS), a, atol=1e-6)
    demand = MASS * a * [1.0, 1.0, base.alpha * base.radius]
    by_matrix = allocation(base, out=[out]) @ demand
    np.testing.assert_allclose(base_acceleration(base, by_matrix, MASS), a, atol=1e-7)
    assert (found.forces**2).sum() >= (by_matrix**2).sum() - 1e-9
    if least == "peak":
        assert np.abs(found.forces).max() <= np.abs(by_matrix).max() + 1e-9


@given(SEEDS, st.integers(5, 8))
def test_least_forces_within_limits(seed, n):
    rng = np.random.default_rng(seed)
    base, a = scattered(rng, n), rng.normal(size=3) * [3, 3, 30]
    free = wheel_forces(base, a, MASS)
    high = rng.uniform(0.6, 1.0) * np.abs(free).max()
    found = redistribute(base, a, MASS, limits=high)
    peak = redistribute(base, a, MASS, limits=high, least="peak")
    assert np.abs(found.forces).max() <= high * (1 + 1e-12)
    if found.status != Reach.MET:
        assert peak.status == found.status
        return
    C, target = base.force / MASS, a * [1, 1, base.radius]
    other = optimize.minimize(
        lambda f: f @ f, peak.forces, jac=lambda f: 2 * f, method="SLSQP", bounds=[(-high, high)] * n,
        constraints={"type": "eq", "fun": lambda f: C @ f - target, "jac": lambda f: C}, options={"ftol": 1e-13},
    )  # fmt: skip
    assert found.forces @ found.forces <= other.fun + 1e-6 * (1 + other.fun)
    assert np.abs(peak.forces).max() <= np.abs(found.forces).max() + 1e-9


@given(SEEDS, st.integers(3, 6), st.sampled_from(["rotation", "translation", "together"]))
def test_what_is_missed_is_the_least(seed, n, give_up):
    rng = np.random.default_rng(seed)
    base, a = scattered(rng, n), rng.normal(size=3) * [6, 6, 60]
    high = np.full(n, 3.0)
    found = redistribute(base, a, MASS, out=[0], limits=high, give_up=give_up)
    assert found.forces[0] == 0.0
    assert (np.abs(found.forces) <= high + 1e-12).all()
    np.testing.assert_allclose(found.acceleration + found.missed, a, atol=1e-12)
    np.testing.assert_allclose(base_acceleration(base, found.forces, MASS), found.acceleration, atol=1e-9)
    rows = {"rotation": [0, 1], "translation": [2], "together": [0, 1, 2]}[give_up]
    C, target = base.force / MASS, a * [1, 1, base.radius]
    best = optimize.lsq_linear(C[rows][:, 1:], target[rows], (-3.0, 3.0), tol=1e-13)
    missed = found.missed[rows] * np.array([1, 1, base.radius])[rows]
    assert np.linalg.norm(missed) <= np.sqrt(2 * best.cost) + 1e-5


def test_what_is_given_up_can_be_chosen():
    base, a = symmetric(radius=0.09, alpha=0.5), [0.0, 4.0, 0.0]
    turned = redistribute(base, a, 2.0, out=[1], limits=3.0, give_up="rotation")
    straight = redistribute(base, a, 2.0, out=[1], limits=3.0, give_up="translation")
    assert turned.status == straight.status == Reach.LIMITED
    assert np.hypot(*turned.missed[:2]) < np.hypot(*straight.missed[:2]) - 0.3
    assert abs(turned.missed[2]) > 10.0
    np.testing.assert_allclose(straight.missed[[0, 2]], 0.0, atol=1e-5)
    # without turning or leaving the line, the rest of the motors are worth what the envelope says
    most = force_envelope(base, [np.pi / 2], limits=3.0, out=[1]).value[0] / 2.0
    np.testing.assert_allclose(straight.acceleration[1], most)


def test_two_motors_left_reach_a_plane():
    base = symmetric(radius=0.09, alpha=0.5)
    left = actuation(base, out=[0, 1])
    assert left.rank == 2
    np.testing.assert_allclose(np.abs(left.lost.T @ left.reachable), 0.0, atol=1e-12)
    np.testing.assert_allclose(left.lost.T @ base.force[:, 2:], 0.0, atol=1e-12)
    found = redistribute(base, [1.0, 0.0, 0.0], 2.0, out=[0, 1], give_up="together")
    assert found.status == Reach.UNREACHABLE
    demand = np.array([1.0, 0.0, 0.0])
    np.testing.assert_allclose(found.acceleration * [1, 1, 0.09], left.reachable @ left.reachable.T @ demand, atol=1e-9)
    assert redistribute(base, [0.0, 1.0, 0.0], 2.0, out=[0, 1]).status == Reach.MET
    assert actuation(base).rank == actuation(base, out=[3]).rank == 3
    assert actuation(base, out=range(4)).rank == 0
    none = redistribute(base, [1.0, 0.0, 0.0], 2.0, out=range(4))
    assert none.status == Reach.UNREACHABLE
    np.testing.assert_array_equal(none.missed, [1.0, 0.0, 0.0])


@given(SEEDS, st.integers(3, 7), st.integers(0, 4))
def test_a_blocked_wheel_takes_one_direction(seed, n, blocked):
    rng = np.random.default_rng(seed)
    base = scattered(rng, n)
    stuck = [int(i) for i in rng.choice(n, min(blocked, n), replace=False)]
    free = possible_twists(base, blocked=stuck)
    assert free.shape == (3, max(3 - len(stuck), 0))
    np.testing.assert_allclose(rim_speeds(base, free.T)[:, stuck], 0.0, atol=1e-12)
    twist = rng.normal(size=(4, 3))
    nearest = feasible_twist(base, twist, blocked=stuck)
    np.testing.assert_allclose(rim_speeds(base, nearest)[:, stuck], 0.0, atol=1e-12)
    np.testing.assert_allclose(feasible_twist(base, nearest, blocked=stuck), nearest, atol=1e-12)
    scale = np.array([1.0, 1.0, base.radius**2])
    np.testing.assert_allclose((twist - nearest) * scale @ free, 0.0, atol=1e-12)


def test_errors_name_the_cause():
    base = soccer()
    with pytest.raises(UnknownName, match="rotation"):
        redistribute(base, np.zeros(3), MASS, give_up="rotatoin")
    with pytest.raises(UnknownName, match="peak"):
        redistribute(base, np.zeros(3), MASS, least="peek")
    with pytest.raises(ShapeError, match="acceleration"):
        redistribute(base, np.zeros(2), MASS)
    with pytest.raises(ShapeError, match="force limits"):
        redistribute(base, np.zeros(3), MASS, limits=-1.0)
    with pytest.raises(OutOfLimits, match="mass"):
        redistribute(base, np.zeros(3), 0.0)
    with pytest.raises(OutOfLimits, match="wheels 0 to 3"):
        redistribute(base, np.zeros(3), MASS, out=[-1])
    with pytest.raises(ShapeError, match="twist"):
        feasible_twist(base, np.zeros(2))
    with pytest.raises(ShapeError, match=r"twist\[1\] is nan"):
        feasible_twist(base, [0.0, np.nan, 0.0], blocked=[0])
    with pytest.raises(ShapeError, match="force limits holds something"):
        redistribute(base, np.zeros(3), MASS, limits="a")


def test_wheels_out_and_blocked_go_by_name():
    base, a = soccer(), [1.0, 2.0, 3.0]
    by_name, by_number = (redistribute(base, a, MASS, out=o) for o in (["wheel 2"], [1]))
    np.testing.assert_array_equal(by_name.forces, by_number.forces)
    np.testing.assert_array_equal(allocation(base, out="wheel 3"), allocation(base, out=[2]))
    assert actuation(base, out=["wheel 1", "wheel 2"]).rank == actuation(base, out=[0, 1]).rank
    np.testing.assert_array_equal(possible_twists(base, blocked=["wheel 4"]), possible_twists(base, blocked=[3]))
    np.testing.assert_array_equal(feasible_twist(base, a, blocked=["wheel 4"]), feasible_twist(base, a, blocked=[3]))
    for call in (lambda: redistribute(base, a, MASS, out=["left"]), lambda: possible_twists(base, blocked=["left"])):
        with pytest.raises(UnknownName, match="no driven wheel 'left'; there is wheel 1, wheel 2"):
            call()
