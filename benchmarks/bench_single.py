"""One configuration per call from Python: every public verb, and the documented fast path beside Pinocchio's binding.

Verbs of straight-line algebra aim at 2 us. Those that decompose a matrix (LAPACK) or iterate have no such aim.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from peers import peer, pinocchio_model
from robots import ROBOTS, median

from holonom import Arm, load_arm
from holonom.app.bench import Figure, Setting, seconds
from holonom.mechanics import analysis, dynamics, identification, jacobians, velocity
from holonom.mechanics.numerical_inverse import inverse_solver, solve_inverse

CALLS = 2000
GOAL = 2000.0
Verbs = Mapping[str, Callable[[], Any] | None]


def measure(setting: Setting) -> list[Figure]:
    tables = [(_algebraic(arm, setting), _iterative(arm, setting)) for arm in map(load_arm, ROBOTS)]
    figures = []
    for kind, goal in ((0, GOAL), (1, None)):
        for name in tables[0][kind]:
            calls = [call for table in tables if (call := table[kind][name]) is not None]
            time = median([_nanoseconds(call, setting) for call in calls])
            assert time is not None
            figures.append(Figure(f"one call, {name}", time, "ns", goal=goal))
    return figures + _beside_pinocchio(setting)


def _nanoseconds(call: Callable[[], Any], setting: Setting, calls: int = CALLS) -> float:
    return 1e9 * seconds(call, setting, calls=calls, rounds=7)


def _state(arm: Arm, setting: Setting) -> tuple[np.ndarray, ...]:
    low, high = np.clip(arm.limits.lower, -2.0, None), np.clip(arm.limits.upper, None, 2.0)
    return 0.5 * (low + high) + 0.3 * setting.rng.uniform(-1.0, 1.0, arm.n) * (high - low), *setting.rng.uniform(
        -1.0, 1.0, (2, arm.n)
    )


def _algebraic(arm: Arm, setting: Setting) -> Verbs:
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
        "joint_torques": lambda: analysis.joint_torques(arm, q, h),
        "transform_wrench": lambda: analysis.transform_wrench(T, h),
    }


def _iterative(arm: Arm, setting: Setting) -> Verbs:
    q, h = _state(arm, setting)[0], setting.rng.uniform(-1.0, 1.0, 6)
    T, start, solver = arm.fk(q), q - 0.02 * np.sign(q), inverse_solver(arm)
    nearest = arm.closed_form is None
    return {
        "solve_inverse, from 0.02 rad away": lambda: solve_inverse(arm, T, start),
        "inverse_solver(arm)(...), the same": lambda: solver(T, start),
        "arm.ik_nearest, by search": (lambda: arm.ik_nearest(T, start)) if nearest else None,
        "singular_values": lambda: analysis.singular_values(arm, q),
        "manipulability": lambda: analysis.manipulability(arm, q),
        "velocity_ellipsoid": lambda: analysis.velocity_ellipsoid(arm, q),
        "force_ellipsoid": lambda: analysis.force_ellipsoid(arm, q),
        "lost_directions": lambda: analysis.lost_directions(arm, q),
        "nullspace": lambda: analysis.nullspace(arm, q),
        "singularities": lambda: analysis.singularities(arm, q),
        "joint_rates": lambda: velocity.joint_rates(arm, q, h),
    }


def _beside_pinocchio(setting: Setting) -> list[Figure]:
    """The Puma; Pinocchio's data made before."""
    arm, pin = load_arm("puma560"), peer("pinocchio")
    q, qd, x = _state(arm, setting)
    tau = np.empty(6)
    peers: dict[str, Callable[[], Any]] = {}
    if pin is not None:
        model = pinocchio_model(pin, arm)
        data = model.createData()
        peers = {
            "inverse_dynamics": lambda: pin.rnea(model, data, q, qd, x),
            "forward_dynamics": lambda: pin.aba(model, data, q, qd, x),
        }
    figures = []
    for name in ("inverse_dynamics", "forward_dynamics"):
        kernel, public = arm.kernel(name), getattr(arm, name)
        ways = {
            f"kernel.single, {name}": lambda kernel=kernel: kernel.single(q, qd, x, tau),
            f"kernel(out=), {name}": lambda kernel=kernel: kernel(q, qd, x, out=tau),
            f"arm.{name}": lambda public=public: public(q, qd, x),
        }
        theirs = _nanoseconds(peers[name], setting, 5000) if name in peers else None
        for way, call in ways.items():
            ours = _nanoseconds(call, setting, 5000)
            figures.append(Figure(f"one call, Puma, {way}", ours, "ns", "Pinocchio binding", theirs, 1.0))
    return figures
