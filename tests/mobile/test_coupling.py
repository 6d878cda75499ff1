"""Laws of the couplings: inverses, power balance, duality; published matrices."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from omni_bases import scattered, soccer, symmetric

from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile import arrangements
from holonom.mobile.drive.coupling import (
    Coupling,
    base_acceleration,
    base_force,
    base_twist,
    coupling_of,
    live_wheels,
    omni_coupling,
    rim_speeds,
    wheel_forces,
)

SEEDS = st.integers(0, 10**6)


@given(SEEDS, st.integers(3, 9))
def test_inverse_after_forward_is_the_identity(seed, n):
    rng = np.random.default_rng(seed)
    base, twist = scattered(rng, n), rng.normal(size=(5, 3))
    np.testing.assert_allclose(base_twist(base, rim_speeds(base, twist)), twist, atol=1e-9)
    acceleration = rng.normal(size=(5, 3)) * [3.0, 3.0, 30.0]
    forces = wheel_forces(base, acceleration, 2.5)
    np.testing.assert_allclose(base_acceleration(base, forces, 2.5), acceleration, atol=1e-8)
    others = forces + rng.normal(size=(5, n)) @ (np.eye(n) - np.linalg.pinv(base.force) @ base.force)
    np.testing.assert_allclose(base_acceleration(base, others, 2.5), acceleration, atol=1e-8)
    assert ((forces**2).sum(1) <= (others**2).sum(1) + 1e-12).all()


@given(SEEDS, st.integers(1, 8))
def test_power_of_the_wheels_is_power_of_the_base(seed, n):
    rng = np.random.default_rng(seed)
    base = omni_coupling(rng.uniform(0, 6, n), radius=0.2, alpha=0.7, levers=rng.uniform(-0.3, 0.3, n))
    f, v = rng.normal(size=(4, n)), rng.normal(size=(4, 3))
    wheels = (f * rim_speeds(base, v)).sum(1)
    np.testing.assert_allclose(wheels, (base_force(base, f) * v).sum(1), atol=1e-12)
    # ... and gives kinetic energy M (vx^2 + vy^2 + alpha R^2 w^2) / 2
    inertia = 3.0 * np.array([1.0, 1.0, 0.7 * 0.2**2])
    np.testing.assert_allclose(wheels, (base_acceleration(base, f, 3.0) * inertia * v).sum(1), atol=1e-12)


def test_rows_follow_the_formula_and_a_wheel_base():
    phi = np.deg2rad([20.0, 100.0, 190.0, 250.0, 330.0])
    base = omni_coupling(phi, radius=0.1, alpha=0.5)
    np.testing.assert_array_equal(base.velocity, np.column_stack([-np.sin(phi), np.cos(phi), np.ones(5)]))
    np.testing.assert_array_equal(base.force, np.vstack([-np.sin(phi), np.cos(phi), np.full(5, 2.0)]))
    wheels = arrangements.omni(phi, radius=0.1, wheel_radius=0.03, alpha=0.5)
    same = coupling_of(wheels)
    np.testing.assert_allclose(same.velocity, base.velocity, atol=1e-12)
    np.testing.assert_allclose(same.force, wheels.force_coupling, atol=1e-12)
    twist = [0.3, -0.8, 2.0]
    np.testing.assert_allclose(rim_speeds(wheels, twist), 0.03 * wheels.wheel_speeds(twist), atol=1e-12)
    assert coupling_of(base) is base
    np.testing.assert_array_equal(coupling_of(base.velocity).velocity, base.velocity)


@pytest.mark.parametrize("alpha", [0.5, 0.8, 1.0])
def test_a_disc_turns_faster_than_a_ring(alpha):
    forces = np.ones(4)
    np.testing.assert_allclose(
        base_acceleration(symmetric(radius=0.1, alpha=alpha), forces, 2.0), [0, 0, 4 / (alpha * 2.0 * 0.1)], atol=1e-12
    )


def test_published_matrices(data_folder):
    case = json.loads((data_folder / "omni" / "omni_cases.json").read_text())["ssl_coupling"]
    example = case["example_33_45"]
    front, rear = example["phi_deg"], example["theta_deg"]
    base = omni_coupling(np.deg2rad([front, 180 - front, 180 + rear, -rear]), radius=0.085)
    np.testing.assert_allclose(base.velocity, example["D"], atol=1e-14)
    np.testing.assert_allclose(np.linalg.pinv(base.velocity), example["pinv"], atol=1e-14)
    # x is right, y forward there; the published tests of signs
    right, forward, turn = rim_speeds(base, np.eye(3))
    assert (right[:2] < 0).all()
    assert (right[2:] > 0).all()
    assert (forward[[0, 3]] > 0).all()
    assert (forward[[1, 2]] < 0).all()
    np.testing.assert_allclose(np.abs(forward[[0, 3]]), np.abs(forward[[1, 2]]))
    np.testing.assert_allclose(turn, 0.085)
    np.testing.assert_allclose(base_twist(base, rim_speeds(base, [3, 1, 5])), [3, 1, 5], atol=1e-12)


def test_errors_name_the_cause():
    with pytest.raises(ShapeError, match=r"\(n, 3\)"):
        Coupling(np.zeros((4, 2)))
    with pytest.raises(ShapeError, match="coupling D holds nan; finite"):
        Coupling(np.full((4, 3), np.nan))
    with pytest.raises(ModelError, match="no row"):
        Coupling(np.zeros((0, 3)))
    for bad in ({"alpha": 0.0}, {"radius": -1.0}, {"alpha": np.inf}):
        with pytest.raises(OutOfLimits, match=next(iter(bad))):
            omni_coupling([0.0, 2.0, 4.0], **bad)
    with pytest.raises(ShapeError, match="levers"):
        omni_coupling([0.0, 2.0], levers=[1.0])
    with pytest.raises(ShapeError, match="last axis must be 4"):
        base_twist(soccer(), np.zeros(3))
    with pytest.raises(OutOfLimits, match="mass"):
        wheel_forces(soccer(), np.zeros(3), 0.0)
    with pytest.raises(InputError, match="steers"):
        coupling_of(arrangements.swerve(wheelbase=0.4, track=0.4, wheel_radius=0.05))


NOT_NUMBERS = [([np.nan, 0.0, 0.0], "nan"), ([0.0, np.inf, 0.0], "inf"), (["a", 0.0, 0.0], "not a number")]


@pytest.mark.parametrize(("three", "words"), NOT_NUMBERS)
def test_what_is_no_number_is_refused_as_by_the_base(three, words):
    base, four = soccer(), [*three, 0.0]
    for call in (
        lambda: rim_speeds(base, three),
        lambda: base_twist(base, four),
        lambda: base_force(base, four),
        lambda: base_acceleration(base, four, 2.0),
        lambda: wheel_forces(base, three, 2.0),
        lambda: coupling_of([three]),
        lambda: omni_coupling(three),
        lambda: omni_coupling([0.0, 2.0, 4.0], levers=three),
    ):
        with pytest.raises(ShapeError, match=words):
            call()
    for mass in ("2", True, np.nan):
        with pytest.raises(OutOfLimits, match="mass is"):
            wheel_forces(base, np.zeros(3), mass)
    for radius in ("1", True):
        with pytest.raises(OutOfLimits, match="radius is"):
            omni_coupling([0.0, 2.0, 4.0], radius=radius)


def test_wheels_go_by_name_or_number():
    base = arrangements.mecanum(0.4, 0.3, 0.05)
    coupling = coupling_of(base)
    assert coupling.names == base.driven
    np.testing.assert_array_equal(live_wheels(coupling, ["front right", 3]), [True, False, True, False])
    np.testing.assert_array_equal(live_wheels(coupling, "rear left"), [True, True, False, True])
    np.testing.assert_array_equal(live_wheels(coupling, np.int64(0)), [False, True, True, True])
    np.testing.assert_array_equal(live_wheels(omni_coupling([0.0, 2.0, 4.0]), ["wheel 1"]), [False, True, True])
    with pytest.raises(UnknownName, match=r"no driven wheel 'front rigth'.*did you mean 'front right'"):
        live_wheels(coupling, ["front rigth"])
    for wheel in (4, -1, 1.0, True, None):
        with pytest.raises(OutOfLimits, match=r"is out, but there are wheels 0 to 3: front left, front right"):
            live_wheels(coupling, [wheel])
    with pytest.raises(ModelError, match="one of its own for each"):
        Coupling(np.eye(3), names=("a", "b", "b"))
