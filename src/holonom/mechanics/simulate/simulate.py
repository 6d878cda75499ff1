"""Simulation of an arm alone: free, under a control law, or under torques from Python; one arm or many variations.

=====================  ======================================================================
`simulate`             one arm; fixed steps or adaptive
`simulate_ensemble`    K variations of payload, masses, friction, start, in lanes and threads
`PDGravity`            gravity compensation with PD
`ComputedTorque`       inverse dynamics with PD inside
`METHODS`              the fixed-step integrators, as data
=====================  ======================================================================
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, real_array
from holonom.errors import InputError, RunError, ShapeError, UnknownName
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.simulate.setup import (
    ComputedTorque,
    Grid,
    Law,
    Loop,
    PDGravity,
    TorqueFunction,
    closed_loop_of,
    count_of,
    reference_of,
    rows_of,
    time_grid,
    vector_of,
)
from holonom.trace import check_threads, share

__all__ = [
    "METHODS",
    "ComputedTorque",
    "Ensemble",
    "PDGravity",
    "Simulation",
    "Tableau",
    "simulate",
    "simulate_ensemble",
]


@dataclass(frozen=True, slots=True)
class Tableau:
    """An explicit method whose stages each use only the one before; `nodes` are multiples of 1/2."""

    nodes: tuple[float, ...]
    weights: tuple[float, ...]
    semi_implicit: bool = False


METHODS: Final[Mapping[str, Tableau]] = {
    "rk4": Tableau((0.0, 0.5, 0.5, 1.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6)),
    "semi_implicit": Tableau((0.0,), (1.0,), semi_implicit=True),
}
"""Integrators of a fixed step, by name; "dop853" is adaptive."""
ADAPTIVE = "dop853"


@dataclass(frozen=True, slots=True)
class Simulation:
    """Samples of a motion: t (M,) s; q (M, n) rad or m, qd, and the controller's torques tau, N m or N."""

    t: Array
    q: Array
    qd: Array
    tau: Array


@dataclass(frozen=True, slots=True)
class Ensemble:
    """Samples of K motions: t (M,); q, qd, tau (K, M, n); diverged (K,): left finite numbers, NaN from there on."""

    t: Array
    q: Array
    qd: Array
    tau: Array
    diverged: NDArray[np.bool_]


def simulate(
    arm: Arm,
    controller: Law | TorqueFunction | None,
    q0: ArrayLike,
    qd0: ArrayLike,
    duration: float,
    *,
    dt: float = 1e-3,
    method: str = "rk4",
    every: int = 1,
    friction: bool | None = None,
    payload: ArrayLike | None = None,
    wrench: ArrayLike | None = None,
    wrench_frame: str | None = None,
    tolerance: float = 1e-9,
) -> Simulation:
    """Integrate B(q) qdd + C(q, qd) qd + friction + g(q) = tau - J^T h from a state (specification 2.3).

    Parameters
    ----------
    arm
        An arm with inertia.
    controller
        None: no torques. `PDGravity` or `ComputedTorque`: compiled, the loop too. A function tau(t, q, qd) -> (n,):
        called at every stage. All act continuously in time.
    q0, qd0
        Start, (n,) each; rad and rad/s (m, m/s).
    duration
        s, positive.
    dt
        Longest step of the fixed-step methods (shortened so that whole samples fill `duration`), and, times `every`,
        the time between samples.
    method
        "rk4" (error ~ dt^4), "semi_implicit" (Euler; error ~ dt, energy stays bounded), or "dop853": adaptive,
        SciPy's Dormand-Prince 8(5,3), where accuracy matters more than speed.
    every
        Steps per stored sample.
    friction
        Whether joint friction is in; by default where the model has any. With the fixed-step methods a joint that
        stands keeps standing while what drives it stays below its Coulomb torque, and friction never gives energy; a
        step in which a joint stops or turns back is of first order. The adaptive method knows no stiction: friction
        has the sign of the speed, and steps become short where a joint comes to rest.
    payload
        Mass at the tool point (kg), or (4,): mass and its place in the tool frame (m). The controller does not know it.
    wrench, wrench_frame
        (6,) [f; m] that the arm exerts on its environment throughout, "world" or "tool"; as in `inverse_dynamics`.
    tolerance
        Relative and absolute tolerance of the adaptive method.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName, InputError, MissingInertia
        Bad arguments.
    RunError
        The state grew beyond finite numbers; the message says when.
    """
    if method != ADAPTIVE and method not in METHODS:
        raise UnknownName("integration method", method, (*METHODS, ADAPTIVE))
    start, speed = vector_of("q0", q0, arm.n), vector_of("qd0", qd0, arm.n)
    loop = closed_loop_of(arm, controller, friction, {"payload": _payload(payload, ())}, wrench, wrench_frame)
    if loop.parameters.shape[0] != 1:
        raise ShapeError("simulate takes one variation; simulate_ensemble takes many")
    grid = time_grid(duration, dt, every)
    found = Simulation(grid.samples, *np.empty((3, grid.samples.shape[0], arm.n)))
    found.q[0], found.qd[0] = start, speed
    if method == ADAPTIVE:
        _adaptive(loop, controller, found, tolerance)
    elif controller is None or isinstance(controller, Law):
        _compiled(loop, controller, grid, METHODS[method], found)
    else:
        _interpreted(loop, controller, grid, METHODS[method], found)
    return found


def simulate_ensemble(
    arm: Arm,
    controller: Law | None,
    q0: ArrayLike,
    qd0: ArrayLike,
    duration: float,
    *,
    dt: float = 1e-3,
    method: str = "rk4",
    every: int = 1,
    friction: bool | None = None,
    payload: ArrayLike | None = None,
    masses: ArrayLike | None = None,
    friction_scale: ArrayLike | None = None,
    wrench: ArrayLike | None = None,
    wrench_frame: str | None = None,
    threads: int = 1,
) -> Ensemble:
    """Simulate K variations of an arm at once, 64 to a block of SIMD lanes, blocks shared among threads.

    The controller knows the nominal arm; the plants vary. Whatever varies has K rows, the rest is shared.

    Parameters
    ----------
    arm, controller, duration, dt, every, friction, wrench_frame
        As in `simulate`; the controller is None or a record, with one reference for all.
    q0, qd0
        (n,) or (K, n).
    method
        A name in `METHODS`.
    payload
        (K,) masses at the tool point, or (K, 4).
    masses, friction_scale
        (K, joints): factors on each link's mass and inertia, on each joint's friction.
    wrench
        (6,) or (K, 6).
    threads
        Threads that share the variations.

    Returns
    -------
    Ensemble
        Each variation equals its own `simulate` to rounding; one that diverges leaves the others alone.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName, InputError, MissingInertia
        Bad arguments.
    """
    if method not in METHODS:
        raise UnknownName("integration method of ensembles", method, METHODS)
    if controller is not None and not isinstance(controller, Law):
        raise InputError("an ensemble runs in compiled code: give PDGravity, ComputedTorque or None, no function")
    varied = {"payload": _payload(payload, (-1,)), "masses": masses, "friction": friction_scale}
    loop = closed_loop_of(arm, controller, friction, varied, wrench, wrench_frame)
    starts, speeds = rows_of("q0", q0, arm.n), rows_of("qd0", qd0, arm.n)
    count = count_of({"parameters": loop.parameters, "q0": starts, "qd0": speeds})
    grid = time_grid(duration, dt, every)
    samples = np.empty((3, count, grid.samples.shape[0], arm.n))
    samples[0, :, 0], samples[1, :, 0] = starts, speeds
    if isinstance(controller, Law) and controller.reference is None and starts.shape[0] > 1:
        raise InputError("the starts q0 differ, so there is no one reference to hold; give the controller's reference=")
    reference = reference_of(arm, controller, starts[0])(grid.halves)
    parameters = np.broadcast_to(loop.parameters, (count, loop.parameters.shape[1])).copy()
    _lanes(loop, METHODS[method], grid, (reference, parameters), samples, check_threads(threads))
    q, qd, tau = samples
    diverged = ~np.isfinite(q[:, -1] + qd[:, -1]).all(axis=1)
    return Ensemble(grid.samples, q, qd, tau, np.asarray(diverged))


def _payload(value: ArrayLike | None, masses: tuple[int, ...]) -> Array | None:
    """Rows (K, 4) from masses of the shape `masses` at the tool point, or the payloads as they are."""
    if value is None:
        return None
    table = real_array("payload", value)
    if table.ndim != len(masses):
        return table
    return np.stack([table.reshape(-1), *np.zeros((3, table.size))], axis=-1)


def _compiled(loop: Loop, controller: Law | None, grid: Grid, tableau: Tableau, found: Simulation) -> None:
    from holonom.mechanics.loops.simulate import advance_one

    steps = advance_one(
        loop.kernel.address,
        loop.stiction.address if loop.stiction else 0,
        grid.dt,
        np.array(tableau.nodes),
        np.array(tableau.weights),
        tableau.semi_implicit,
        grid.every,
        reference_of(loop.arm, controller, found.q[0])(grid.halves),
        loop.parameters[0],
        found.q,
        found.qd,
        found.tau,
    )
    _check_finite(steps * grid.dt, found)


def _interpreted(loop: Loop, controller: TorqueFunction, grid: Grid, tableau: Tableau, found: Simulation) -> None:
    """The same steps as `advance_one`, around a controller in Python."""
    from holonom.mechanics.loops.simulate import settle, turns_back

    rates = _rates(loop, lambda t, q, qd: _given_torque(controller, t, q, qd))
    x, v = found.q[0].copy(), found.qd[0].copy()
    kx = kv = np.zeros_like(x)
    for step in range((found.t.shape[0] - 1) * grid.every + 1):
        dx, dv, slip = np.zeros_like(x), np.zeros_like(x), np.sign(v)
        for node, weight in zip(tableau.nodes, tableau.weights, strict=True):
            h = node * grid.dt
            kx, (kv, torque) = v + h * kv, rates(step * grid.dt + h, x + h * kx, v + h * kv, slip)
            if node == 0.0 and step % grid.every == 0:
                row = step // grid.every
                found.q[row], found.qd[row], found.tau[row] = x, v, torque
            dx, dv = dx + weight * kx, dv + weight * kv
        x0, v0 = x, v
        v = v + grid.dt * dv
        x = x + grid.dt * (v if tableau.semi_implicit else dx)
        if loop.stiction is not None and turns_back(v0, v):
            B, breakaway = loop.stiction(x0, v0, loop.parameters[0])
            settle(grid.dt, tableau.semi_implicit, B.reshape(-1), breakaway, x0, v0, x, v)


def _adaptive(loop: Loop, controller: Law | TorqueFunction | None, found: Simulation, tolerance: float) -> None:
    from scipy.integrate import solve_ivp

    n = loop.arm.n
    if controller is None or isinstance(controller, Law):
        at = reference_of(loop.arm, controller, found.q[0])
        rates = _rates(loop, lambda t, q, qd: at(np.array([t]))[0])
    else:
        rates = _rates(loop, lambda t, q, qd: _given_torque(controller, t, q, qd))

    def derivative(t: float, y: Array) -> Array:
        return np.concatenate([y[n:], rates(t, y[:n].copy(), y[n:].copy(), np.sign(y[n:]))[0]])

    start = np.concatenate([found.q[0], found.qd[0]])
    done = solve_ivp(derivative, (0.0, found.t[-1]), start, "DOP853", found.t, rtol=tolerance, atol=tolerance)
    if not done.success:
        raise RunError(
            f"the adaptive integration stopped at t = {done.t[-1]:.6g} s, where no step is small enough for its "
            'tolerance; give a larger one, or method="rk4" with a dt'
        )
    found.q[:], found.qd[:] = done.y.T[:, :n], done.y.T[:, n:]
    for k, t in enumerate(found.t):
        found.tau[k] = rates(float(t), found.q[k], found.qd[k], np.sign(found.qd[k]))[1]


def _rates(
    loop: Loop, reference: Callable[[float, Array, Array], Array]
) -> Callable[[float, Array, Array, Array], tuple[Array, Array]]:
    """Accelerations and torques at a state and a direction of slip, from the one-sample form."""
    parameters, n = loop.parameters[0], loop.arm.n
    single = loop.kernel.single

    def rates(t: float, q: Array, qd: Array, slip: Array) -> tuple[Array, Array]:
        qdd, tau = np.empty(n), np.empty(n)
        finite = bool(np.isfinite(q + qd).all())
        if not finite or single(q, qd, slip, reference(t, q, qd), parameters, qdd, tau) != 0:
            raise RunError(f"the state is no longer finite at t = {t:.6g} s; take a smaller dt or softer gains")
        return qdd, tau

    return rates


def _given_torque(controller: TorqueFunction, t: float, q: Array, qd: Array) -> Array:
    return vector_of(f"the controller's torque at t = {t:.6g} s", controller(t, q, qd), q.shape[0])


def _lanes(loop: Loop, tableau: Tableau, grid: Grid, inputs: tuple[Array, Array], samples: Array, threads: int) -> None:
    from holonom.mechanics.loops.simulate import LANES, advance_lanes

    rows, count = loop.kernel.rows, samples.shape[1]
    stiction = loop.stiction.address if loop.stiction else 0
    nodes, weights = np.array(tableau.nodes), np.array(tableau.weights)
    q, qd, tau = samples
    blocks = -(-count // LANES)
    parts = max(1, min(threads, blocks))
    edges = [min(count, LANES * (blocks * k // parts)) for k in range(parts + 1)]

    def part(k: int) -> None:
        advance_lanes(
            rows,
            stiction,
            grid.dt,
            nodes,
            weights,
            tableau.semi_implicit,
            grid.every,
            inputs[0],
            inputs[1],
            q,
            qd,
            tau,
            edges[k],
            edges[k + 1],
        )

    share(part, parts)


def _check_finite(end: float, found: Simulation) -> None:
    if end < found.t[-1] * (1.0 - 1e-12):
        raise RunError(f"the state is no longer finite at t = {end:.6g} s; take a smaller dt or softer gains")
