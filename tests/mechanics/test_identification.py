"""Identification: laws of the regressor, known numbers of base parameters, recovered arms, confidence that holds."""

import dataclasses
import functools

import numpy as np
import pytest
from arms import random_body, random_model, random_tree
from identified_arms import planar, torques, with_drives

from holonom.errors import InputError, OutOfLimits, ShapeError
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.equations.dynamics.inertia import from_body
from holonom.mechanics.equations.dynamics.regressor import to_parameters
from holonom.mechanics.identification import (
    base_parameters,
    column_names,
    excitation,
    identify,
    is_consistent,
    parameters,
    regressor,
)
from holonom.mechanics.identification.columns import regressor_of_rows
from holonom.model import Body


def full_rotors(model):
    return dataclasses.replace(
        with_drives(model, 1), name=f"{model.name}_full", rotors="full", links_include_rotors=False
    )


MODELS = [load_arm("puma560").model, random_model(1, 2), with_drives(random_model(4, 5), 0)]
MODELS += [with_drives(random_tree(5, 4), 2), random_tree(6, 5), full_rotors(random_model(3, 4))]


@pytest.mark.parametrize("model", MODELS, ids=[m.name for m in MODELS])
def test_torque_is_linear_in_the_parameters(model):
    n = len(model.independent)
    q, qd, qdd = np.random.default_rng(0).uniform(-1.5, 1.5, (3, 5, n))
    tau = torques(model, q, qd, qdd)
    Y = regressor_of_rows(model)(q, qd, qdd)
    assert Y.shape == (5, n, len(column_names(model)))
    np.testing.assert_allclose(Y @ parameters(model), tau, atol=1e-11 * np.abs(tau).max())


def test_the_verb_equals_the_equation_and_inverse_dynamics():
    arm = Arm(random_model(1, 2))
    q, qd, qdd = np.random.default_rng(1).uniform(-1.5, 1.5, (3, 70, 2))
    Y = regressor(arm, q, qd, qdd)
    np.testing.assert_allclose(Y, regressor_of_rows(arm.model)(q, qd, qdd), atol=1e-12)
    np.testing.assert_allclose(regressor(arm, q[3], qd[3], qdd[3]), Y[3], atol=1e-12)
    np.testing.assert_allclose(Y @ parameters(arm.model), arm.inverse_dynamics(q, qd, qdd), atol=1e-10)
    with pytest.raises(ShapeError, match="qd has shape"):
        regressor(arm, q, qd[:, :1], qdd)


@pytest.mark.oracle
def test_against_pinocchio(pinocchio):
    from peers import pinocchio_model

    arm = load_arm("puma560")
    model = pinocchio_model(pinocchio, arm)
    data = model.createData()
    rng = np.random.default_rng(2)
    q, qd, qdd = rng.uniform(-2.0, 2.0, (3, 3, 6))
    Y = regressor_of_rows(arm.model)(q, qd, qdd)
    for k, i in np.ndindex(3, 6):
        theirs = pinocchio.computeJointTorqueRegressor(model, data, q[k], qd[k], qdd[k])[:, 10 * i : 10 * i + 10]
        link = pinocchio.SE3(np.array(arm.model.joints[i].after))  # theirs are stated in the joint's frame before it
        for body in (random_body(rng) for _ in range(12)):  # more than ten: all ten columns are compared
            xx, yy, zz, xy, yz, xz = body.inertia
            inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            there = link.act(pinocchio.Inertia(body.mass, np.array(body.com), inertia)).toDynamicParameters()
            here = np.array(to_parameters(from_body(body)), dtype=float)
            tau = theirs @ there
            np.testing.assert_allclose(Y[k, :, 10 * i : 10 * i + 10] @ here, tau, atol=1e-10 * np.abs(tau).max())


def without_motors(model):
    return dataclasses.replace(model, joints=tuple(dataclasses.replace(j, motor=None) for j in model.joints))


@pytest.mark.parametrize(
    ("model", "number"),
    [
        (without_motors(load_arm("puma560").model), 36),  # Mayeda, Yoshida, Osuka 1990
        (planar((0.0, -9.81, 0.0)), 6),  # I, m c_x, m c_y of either link
        (planar((0.0, 0.0, -9.81)), 4),  # horizontal: nothing holds link 1 but its inertia
    ],
    ids=["puma", "vertical", "horizontal"],
)
def test_known_numbers_of_base_parameters(model, number):
    assert base_parameters(Arm(model), friction=False).number == number


def test_planar_arm_groups_as_in_the_book():
    base = base_parameters(Arm(planar((0.0, -9.81, 0.0))), friction=False)
    assert base.formulas() == (
        "Izz1 - 0.25 m1 - 0.25 m2",  # about joint 1: I + m a^2 + 2 a h, with hx1 + a m1 + a m2 below
        "hx1 + 0.5 m1 + 0.5 m2",
        "hy1",
        "Izz2 - 0.16 m2",
        "hx2 + 0.4 m2",
        "hy2",
    )
    assert {"hz1", "Ixx1", "hz2", "Iyz2"} < set(base.without_effect)


@pytest.mark.parametrize("model", MODELS, ids=[m.name for m in MODELS])
def test_grouping_leaves_every_torque(model):
    base = base_parameters(Arm(model), seed=3)
    rng = np.random.default_rng(4)
    n = len(model.independent)
    Y = regressor_of_rows(model)(*rng.uniform(-2.0, 2.0, (3, 20, n)))
    pi = rng.standard_normal(Y.shape[-1]) * (np.abs(base.grouping).max(0) > 0)
    np.testing.assert_allclose(Y[..., base.columns] @ (base.grouping @ pi), Y @ pi, atol=1e-7 * np.abs(Y).max())
    assert base_parameters(Arm(model), seed=5).columns.tolist() == base.columns.tolist()


@functools.cache
def excited(seed=0, trials=15, duration=20.0):
    """An exciting motion of the Puma: time, q, qd, qdd."""
    T = excitation(load_arm("puma560"), trials=trials, duration=duration, dt=0.004, seed=seed).trajectory
    return np.arange(len(T.q)) * T.dt, T.q, T.qd, T.qdd


def test_excitation_keeps_the_limits_and_is_at_rest_at_both_ends():
    limits = load_arm("puma560").limits
    t, q, qd, qdd = excited()
    assert (q >= limits.lower).all()
    assert (q <= limits.upper).all()
    assert (np.abs(qd) <= limits.speed).all()
    assert (np.abs(qdd) <= limits.acceleration).all()
    assert (np.abs(qd) / limits.speed).max() > 0.9
    for ends in (qd[[0, -1]], qdd[[0, -1]]):
        np.testing.assert_allclose(ends, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.gradient(q, t, axis=0)[1:-1], qd[1:-1], atol=1e-3)
    np.testing.assert_allclose(np.gradient(qd, t, axis=0)[1:-1], qdd[1:-1], atol=1e-2)


def with_torques(share):
    """A Puma of weaker motors."""
    model = load_arm("puma560").model
    joints = tuple(
        dataclasses.replace(j, limits=dataclasses.replace(j.limits, torque=share * j.limits.torque))
        for j in model.joints
    )
    return Arm(dataclasses.replace(model, joints=joints))


def test_excitation_keeps_the_torque_limits():
    _, q, qd, qdd = excited()
    strong, weak = load_arm("puma560"), with_torques(0.45)
    assert (np.abs(strong.inverse_dynamics(q, qd, qdd)) <= strong.limits.torque).all()
    free = dataclasses.replace(
        weak.model,
        joints=tuple(
            dataclasses.replace(j, limits=dataclasses.replace(j.limits, torque=np.inf)) for j in weak.model.joints
        ),
    )
    unheeding, heeding = (excitation(arm, trials=8, dt=0.004, seed=3).trajectory for arm in (Arm(free), weak))
    peak = {
        name: (np.abs(strong.inverse_dynamics(m.q, m.qd, m.qdd)) / weak.limits.torque).max()
        for name, m in (("unheeding", unheeding), ("heeding", heeding))
    }
    assert peak["unheeding"] > 1.05
    assert 0.8 < peak["heeding"] <= 1.0
    half = excitation(weak, trials=8, dt=0.004, seed=3, use=0.9).trajectory
    assert (np.abs(weak.inverse_dynamics(half.q, half.qd, half.qdd)) <= 0.9 * weak.limits.torque).all()


def test_an_arm_that_cannot_hold_itself_is_not_excited():
    with pytest.raises(InputError, match="none of 5 motions keeps the torque limits of arm 'puma560'"):
        excitation(with_torques(1e-3), trials=5)


def test_excitation_improves_on_the_first_draw_and_repeats_itself():
    arm = Arm(with_drives(planar((0.0, -9.81, 0.0)), 3))
    first, best, again = (excitation(arm, trials=trials, dt=0.01) for trials in (1, 60, 60))
    assert best.condition < 0.8 * first.condition
    np.testing.assert_array_equal(best.trajectory.q, again.trajectory.q)


@functools.cache
def identified(seed=0, level=0.02, friction=True):
    """The Puma identified from noisy torques, with the true base parameters."""
    t, q, qd, qdd = excited()
    model = load_arm("puma560").model
    tau = regressor_of_rows(model)(q, qd, qdd) @ parameters(model)
    rng = np.random.default_rng(seed)
    measured = tau + level * np.abs(tau).max(0) * rng.standard_normal(tau.shape)
    # The start knows kinematics and motors, but wrong bodies and no friction.
    wrong = [
        Body(1.5 * b.mass + 0.1, b.com, tuple(2 * i + 1e-3 for i in b.inertia[:3]) + (0.0,) * 3) for b in model.bodies
    ]
    joints = tuple(dataclasses.replace(j, friction=None) for j in model.joints)
    start = Arm(dataclasses.replace(model, bodies=tuple(wrong), joints=joints))
    found = identify(start, t, q + 1e-5 * rng.standard_normal(q.shape), measured, friction=friction)
    return found, found.base.grouping @ parameters(model)


def test_an_identified_puma_predicts_another_motion():
    found, _ = identified()
    model = load_arm("puma560").model
    _, q, qd, qdd = excited(seed=7, trials=1, duration=10.0)
    tau = torques(model, q[::50], qd[::50], qdd[::50])
    error = torques(found.model, q[::50], qd[::50], qdd[::50]) - tau
    assert (np.sqrt(np.mean(error**2, 0)) < 0.005 * np.sqrt(np.mean(tau**2, 0))).all()


def test_stated_confidence_covers_the_truth():
    """Errors over standard deviations are as those of a normal distribution, over base parameters and repetitions."""
    errors = []
    for seed in range(4):
        found, truth = identified(seed)
        errors.append((found.values - truth) / found.deviations)
    z = np.concatenate(errors)
    assert 0.8 < np.sqrt(np.mean(z**2)) < 1.25
    assert 0.90 < np.mean(np.abs(z) < 1.96) < 0.99
    low, high = found.interval()
    np.testing.assert_allclose(0.5 * (low + high), found.values)


def test_all_parameters_can_exist_and_fit_as_well_as_the_base_parameters():
    found, truth = identified()
    for i, body in enumerate(found.model.bodies):
        assert body.mass > 0.0
        assert is_consistent(found.parameters[10 * i : 10 * i + 10])
        xx, yy, zz, xy, yz, xz = body.inertia
        moments = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert moments[0] > 0.0
        assert moments[2] < moments[:2].sum()
    assert (found.parameters >= 0.0)[60:].all()
    assert (found.misfit < 1.05 * found.noise).all()
    np.testing.assert_allclose(parameters(found.model), found.parameters, rtol=1e-9, atol=1e-12)
    grouped = found.base.grouping @ found.parameters
    assert (np.abs(grouped - truth) < 6 * found.deviations).all()


def test_what_the_motion_cannot_tell_is_said():
    found, _ = identified()
    assert {"m1", "hz1", "Ixx1"} <= set(found.without_effect)
    assert found.weak  # some inertias of the wrist are far below its noise
    strong = {found.base.names[k] for k in found.base.columns} - set(found.weak)
    assert {"hx2", "Fv1", "Fs+2"} <= strong


def test_friction_that_is_not_asked_for_stays_as_stated():
    found, _ = identified(friction=False)
    assert all(joint.friction is None for joint in found.model.joints)
    assert not any(name.startswith("F") for k in found.base.columns for name in [found.base.names[k]])


def test_a_clean_record_gives_the_truth():
    model = with_drives(planar((0.0, -9.81, 0.0), 3), 3)
    motion = excitation(Arm(model), trials=5, duration=20.0, dt=0.002).trajectory
    tau = regressor_of_rows(model)(motion.q, motion.qd, motion.qdd) @ parameters(model)
    for friction in (True, False):
        found = identify(Arm(model), np.arange(len(tau)) * motion.dt, motion.q, tau, friction=friction)
        truth = found.base.grouping @ parameters(model)
        np.testing.assert_allclose(found.values, truth, rtol=2e-3, atol=2e-3)
        assert friction or [j.friction for j in found.model.joints] == [j.friction for j in model.joints]


def test_bad_records_are_refused_by_name():
    arm = Arm(planar((0.0, -9.81, 0.0)))
    t = np.arange(4000) * 0.005
    q = np.column_stack([np.sin(2 * t), np.cos(3 * t)])
    with pytest.raises(ShapeError, match=r"tau\[0, 0\] is nan"):
        identify(arm, t, q, np.full_like(q, np.nan))
    with pytest.raises(ShapeError, match="of both is needed"):
        identify(arm, t, q, q[:, :1])
    with pytest.raises(ShapeError, match="the same number of both"):
        identify(arm, t[:-1], q, q)
    with pytest.raises(InputError, match="even steps"):
        identify(arm, t + (t > 5.0), q, q)
    with pytest.raises(InputError, match="quarter"):
        identify(arm, t, q, q, cutoff=80.0)
    with pytest.raises(InputError, match="record more"):
        identify(arm, t[:200], q[:200], q[:200], cutoff=1.0)
    with pytest.raises(InputError, match=r"equations are left|tells nothing"):
        identify(arm, t, 0.0 * q, 0.0 * q)
    with pytest.raises(InputError, match=r"tells nothing about \d+ of \d+ base parameters, among .*Fv2"):
        identify(arm, t, q * [1.0, 0.0], q)
    with pytest.raises(OutOfLimits, match=r"use = 1\.5"):
        excitation(arm, use=1.5)
    with pytest.raises(InputError, match="two harmonics"):
        excitation(arm, harmonics=1)
