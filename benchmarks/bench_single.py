"""One configuration per call from Python: every public verb, and the documented fast path beside Pinocchio's binding.

Verbs that evaluate or decompose a matrix aim at 2 us; the latter stand beside NumPy's LAPACK on Pinocchio's Jacobian,
too. Those that search have no such aim.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from peers import peer, pinocchio_model
from robots import ROBOTS, median

from holonom import Arm, load_arm
from holonom.app.about.bench import Figure, Setting, seconds
from holonom.mechanics import analysis, dynamics, identification, jacobians, velocity
from holonom.mechanics.numerical_inverse import inverse_solver, solve_inverse

CALLS = 2000
GOAL = 2000.0
Call = Callable[[], Any]
Verbs = Mapping[str, Call | None]


def measure(setting: Setting) -> list[Figure]:
    arms = [load_arm(name) for name in ROBOTS]
    return (
        _figures([_evaluating(arm, setting) for arm in arms], setting, GOAL)
        + [f for name in DECOMPOSED for f in _decomposing(name, arms, setting)]
        + _figures([_searching(arm, setting) for arm in arms], setting, None)
        + _beside_pinocchio(setting)
    )


def _figures(tables: Sequence[Verbs], setting: Setting, goal: float | None) -> list[Figure]:
    figures = []
    for name in tables[0]:
        calls = [call for table in tables if (call := table[name]) is not None]
        time = median([_nanoseconds(call, setting) for call in calls])
        assert time is not None
        figures.append(Figure(f"one call, {name}", time, "ns", goal=goal))
    return figures


def _nanoseconds(call: Callable[[], Any], setting: Setting, calls: int = CALLS) -> float:
    return 1e9 * seconds(call, setting, calls=calls, rounds=7)


def _state(arm: Arm, setting: Setting) -> tuple[np.ndarray, ...]:
    low, high = np.clip(arm.limits.lower, -2.0, None), np.clip(arm.limits.upper, None, 2.0)
    return 0.5 * (low + high) + 0.3 * setting.rng.uniform(-1.0, 1.0, arm.n) * (high - low), *setting.rng.uniform(
        -1.0, 1.0, (2, arm.n)
    )


def _evaluating(arm: Arm, setting: Setting) -> Verbs:
    q, qd, x = _state(arm, setting)
    T, h, closed = arm.fk(q), setting.rng.uniform(-1.0, 1.0, 6), arm.closed_form is not None
    return {
        "arm.fk": lambda: arm.fk(q),
        "arm.frames": lambda: arm.frames(q),
        "arm.jacobian": lambda: arm.jacobian(q),
        "arm.ik": (lambda: arm.ik(T)) if closed else None,
        "arm.ik_nearest, closed form": (lambda: arm.ik_nearest(T, q)) if closed else None,
        "arm.inverse_dynamics": lambda: arm.inverse_dynamics(q, qd, x),
        "arm.inverse_dynamics, wrench": lambda: arm.inverse_dynamics(q, qd, x, wrench=h, wrench_frame="tool"),
        "arm.forward_dynamics": lambda: arm.forward_dynamics(q, qd, x),
        "arm.mass_matrix": lambda: arm.mass_matrix(q),
        "arm.coriolis_matrix": lambda: arm.coriolis_matrix(q, qd),
        "arm.gravity": lambda: arm.gravity(q),
        "inverse_dynamics_derivatives": lambda: dynamics.inverse_dynamics_derivatives(arm, q, qd, x),
        "forward_dynamics_derivatives": lambda: dynamics.forward_dynamics_derivatives(arm, q, qd, x),
        "christoffel": lambda: dynamics.christoffel(arm, q),
        "coupling_table": lambda: dynamics.coupling_table(arm, q),
        "bias": lambda: dynamics.bias(arm, q, qd),
        "energy": lambda: dynamics.energy(arm, q, qd),
        "momentum": lambda: dynamics.momentum(arm, q, qd),
        "centroidal_momentum": lambda: dynamics.centroidal_momentum(arm, q, qd),
        "centre_of_mass": lambda: dynamics.centre_of_mass(arm, q),
        "regressor": lambda: identification.regressor(arm, q, qd, x),
        "jacobian_rate": lambda: jacobians.jacobian_rate(arm, q, qd),
        "acceleration_bias": lambda: jacobians.acceleration_bias(arm, q, qd),
        "jacobian_hessian": lambda: jacobians.jacobian_hessian(arm, q),
        "analytic_jacobian": lambda: jacobians.analytic_jacobian(arm, q, angles="rpy"),
        "manipulability": lambda: analysis.manipulability(arm, q),
        "joint_torques": lambda: analysis.joint_torques(arm, q, h),
        "transform_wrench": lambda: analysis.transform_wrench(T, h),
    }


def _searching(arm: Arm, setting: Setting) -> Verbs:
    q = _state(arm, setting)[0]
    T, start, solver = arm.fk(q), q - 0.02 * np.sign(q), inverse_solver(arm)
    nearest = arm.closed_form is None
    return {
        "solve_inverse, from 0.02 rad away": lambda: solve_inverse(arm, T, start),
        "inverse_solver(arm)(...), the same": lambda: solver(T, start),
        "arm.ik_nearest, by search": (lambda: arm.ik_nearest(T, start)) if nearest else None,
    }


def _rates(J: np.ndarray, twist: np.ndarray) -> np.ndarray:
    return J.T @ np.linalg.solve(J @ J.T + 1e-6 * np.eye(6), twist)


DECOMPOSED: Mapping[str, tuple[Callable[[Arm, Any, Any], Any], Callable[[Any, Any], Any]]] = {
    "singular_values": (
        lambda arm, q, h: analysis.singular_values(arm, q),
        lambda J, h: np.linalg.svd(J, compute_uv=False),
    ),
    "velocity_ellipsoid": (lambda arm, q, h: analysis.velocity_ellipsoid(arm, q), lambda J, h: np.linalg.svd(J[:3])),
    "force_ellipsoid": (lambda arm, q, h: analysis.force_ellipsoid(arm, q), lambda J, h: np.linalg.svd(J[:3])),
    "lost_directions": (lambda arm, q, h: analysis.lost_directions(arm, q), lambda J, h: np.linalg.svd(J)),
    "nullspace": (lambda arm, q, h: analysis.nullspace(arm, q), lambda J, h: np.linalg.svd(J)),
    "singularities": (lambda arm, q, h: analysis.singularities(arm, q), lambda J, h: np.linalg.svd(J)),
    "joint_rates": (lambda arm, q, h: velocity.joint_rates(arm, q, h), _rates),
}
"""Verb -> ours of arm, q and a twist, and what NumPy makes of the Jacobian and the twist."""


def _decomposing(name: str, arms: Sequence[Arm], setting: Setting) -> list[Figure]:
    """One verb, and beside it Pinocchio's Jacobian and NumPy, all from q."""
    pin, (verb, decomposed) = peer("pinocchio"), DECOMPOSED[name]
    ours, theirs = [], []
    for arm in arms:
        q, h = _state(arm, setting)[0], setting.rng.uniform(-1.0, 1.0, 6)
        ours.append(_nanoseconds(lambda arm=arm, q=q, h=h: verb(arm, q, h), setting))
        if pin is not None:
            jacobian = _pinocchio_jacobian(pin, arm)
            theirs.append(_nanoseconds(lambda j=jacobian, q=q, h=h: decomposed(j(q), h), setting))
    time, title = median(ours) or 0.0, "Pinocchio and NumPy"
    return [
        Figure(f"one call, {name}", time, "ns", goal=GOAL),
        Figure(f"one call, {name}, the same", time, "ns", title, median(theirs) if theirs else None, 1.0),
    ]


def _pinocchio_jacobian(pin: Any, arm: Arm) -> Callable[[Any], Any]:
    model = pinocchio_model(pin, arm)
    data, tool, axes = model.createData(), model.getFrameId("tool"), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    return lambda q: pin.computeFrameJacobian(model, data, q, tool, axes)


def _beside_pinocchio(setting: Setting) -> list[Figure]:
    """The Puma; Pinocchio's data made before."""
    arm, pin = load_arm("puma560"), peer("pinocchio")
    q, qd, x = _state(arm, setting)
    tau = np.empty(6)
    peers = _pinocchio_calls(pin, arm, q, qd, x) if pin is not None else {}
    ways: dict[str, tuple[Call, str]] = {
        "arm.jacobian": (lambda: arm.jacobian(q), "jacobian"),
        "arm.mass_matrix": (lambda: arm.mass_matrix(q), "mass_matrix"),
        "inverse_dynamics_derivatives": (
            lambda: dynamics.inverse_dynamics_derivatives(arm, q, qd, x),
            "inverse_dynamics_derivatives",
        ),
        "forward_dynamics_derivatives": (
            lambda: dynamics.forward_dynamics_derivatives(arm, q, qd, x),
            "forward_dynamics_derivatives",
        ),
    }
    for name in ("inverse_dynamics", "forward_dynamics"):
        kernel, public = arm.kernel(name), getattr(arm, name)
        ways |= {
            f"kernel.single, {name}": (lambda kernel=kernel: kernel.single(q, qd, x, tau), name),
            f"kernel(out=), {name}": (lambda kernel=kernel: kernel(q, qd, x, out=tau), name),
            f"arm.{name}": (lambda public=public: public(q, qd, x), name),
        }
    times = {name: _nanoseconds(call, setting, 5000) for name, call in peers.items()}
    return [
        Figure(
            f"one call, Puma, {way}",
            _nanoseconds(call, setting, 5000),
            "ns",
            "Pinocchio binding",
            times.get(name),
            1.0,
        )
        for way, (call, name) in ways.items()
    ]


def _pinocchio_calls(pin: Any, arm: Arm, q: Any, qd: Any, x: Any) -> Mapping[str, Call]:
    model, jacobian = pinocchio_model(pin, arm), _pinocchio_jacobian(pin, arm)
    data = model.createData()
    return {
        "jacobian": lambda: jacobian(q),
        "mass_matrix": lambda: pin.crba(model, data, q),
        "inverse_dynamics": lambda: pin.rnea(model, data, q, qd, x),
        "forward_dynamics": lambda: pin.aba(model, data, q, qd, x),
        "inverse_dynamics_derivatives": lambda: pin.computeRNEADerivatives(model, data, q, qd, x),
        "forward_dynamics_derivatives": lambda: pin.computeABADerivatives(model, data, q, qd, x),
    }
