"""Fixed-step integration of a closed loop, compiled once for every arm: an arm comes in as its compiled equation.

`advance_one` calls the equation's C form for one arm; `advance_lanes` its block form for 64 variations at a time.
Both take a tableau in which each stage uses the one before it only (Euler, midpoint, classical Runge-Kutta).

Coulomb friction keeps its direction over a step, that of the speed at its start; a joint at rest has none. `settle`
puts right the steps in which a joint stands, stops or turns back; in all others the method keeps its order.
"""

from __future__ import annotations

import numpy as np
from numba import types

from holonom.arrays import Array
from holonom.trace.call.pointer import call_kernel, call_rows
from holonom.trace.code.loops import loop

__all__ = ["advance_lanes", "advance_one", "settle", "turns_back"]

LANES = 64
"""Variations that are advanced together."""
SWEEPS, SETTLED = 100, 1e-12
"""Most sweeps over the joints in `settle`, and the change of the speeds, as a share of the largest, that ends them."""


@loop(error_model="numpy")
def turns_back(before: Array, after: Array) -> bool:
    """Whether a joint stands, stops or turns back between two speeds (n,)."""
    least = np.inf
    for i in range(before.shape[0]):
        least = min(least, before[i] * after[i])
    return least <= 0.0


@loop(error_model="numpy")
def settle(dt: float, semi_implicit: bool, B: Array, breakaway: Array, x0: Array, v0: Array, x: Array,
           v: Array) -> None:  # fmt: skip
    """Correct a step's end x, v (n,) for joints that stand, stop or turn back in it.

    Friction impulses p are sought with B (w - v) = p - p0, where p0 is what the step took, -dt F sgn(v0): each joint
    either moves on against its full impulse, or stands and the impulse is what holds it, at most dt F (Moreau's time
    stepping). That is the least of 1/2 |w - u|_B^2 + dt sum F |w| from the speeds u without friction, which a sweep
    over the joints finds; so friction never gives energy. x follows: what stood is where it was, what stopped is where
    its speed ended.

    Parameters
    ----------
    B, breakaway
        Mass matrix (n n,) row by row, and Coulomb torques (2 n,) against either direction.
    x0, v0
        Start of the step (n,).
    """
    n = v.shape[0]
    w, taken = v.copy(), np.zeros(n)
    for i in range(n):
        if v0[i] != 0.0:
            taken[i] = -dt * breakaway[i] if v0[i] > 0.0 else dt * breakaway[n + i]
    for _ in range(SWEEPS):
        change, largest = 0.0, 0.0
        for i in range(n):
            rest = taken[i] - B[n * i + i] * v[i]
            for j in range(n):
                if j != i:
                    rest += B[n * i + j] * (w[j] - v[j])
            forward = (-dt * breakaway[i] - rest) / B[n * i + i]
            backward = (dt * breakaway[n + i] - rest) / B[n * i + i]
            value = forward if forward > 0.0 else (backward if backward < 0.0 else 0.0)
            change, largest = max(change, abs(value - w[i])), max(largest, abs(value))
            w[i] = value
        if change <= SETTLED * largest:
            break
    for i in range(n):
        if semi_implicit:
            x[i] = x0[i] + dt * w[i]
        elif w[i] != 0.0 or v0[i] * v[i] > 0.0:
            x[i] += 0.5 * dt * (w[i] - v[i])
        elif v0[i] == 0.0:
            x[i] = x0[i]
        else:
            x[i] = x0[i] + 0.5 * dt * v0[i] * v0[i] / (v0[i] - v[i])
        v[i] = w[i]


@loop(nogil=True, error_model="numpy")
def advance_one(
    address: int,
    stiction: int,
    dt: float,
    nodes: Array,
    weights: Array,
    semi_implicit: bool,
    every: int,
    reference: Array,
    parameters: Array,
    q: Array,
    qd: Array,
    tau: Array,
) -> int:
    """Integrate one arm.

    Parameters
    ----------
    address, stiction
        Of the C forms of the closed loop, and of what decides whether joints stick (0: there is no Coulomb friction).
    dt
        Step, s.
    nodes, weights
        (s,) of the tableau; nodes are multiples of 1/2.
    semi_implicit
        Whether positions advance with the new speeds.
    every
        Steps per stored sample.
    reference
        (2 N + 1, r), every half step.
    parameters
        (p,).
    q, qd, tau
        (M, n) samples, written; row 0 of `q` and `qd` is the start.

    Returns
    -------
    Steps done before a state was no longer finite; N if none was.
    """
    n, r = q.shape[1], reference.shape[1]
    source, target = np.empty(3 * n + r + parameters.shape[0]), np.empty(2 * n)
    source[3 * n + r :] = parameters
    state, sticking = np.empty(2 * n + parameters.shape[0]), np.empty(n * n + 2 * n)
    state[2 * n :] = parameters
    x, v = q[0].copy(), qd[0].copy()
    kx, kv, sx, sv = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    steps = (reference.shape[0] - 1) // 2
    for step in range(steps + 1):
        sx[:], sv[:] = 0.0, 0.0
        for i in range(n):
            state[i], state[n + i], source[2 * n + i] = x[i], v[i], np.sign(v[i])
        for stage in range(nodes.shape[0]):
            h = dt * nodes[stage]
            for i in range(n):
                source[i], source[n + i] = x[i] + h * kx[i], v[i] + h * kv[i]
            source[3 * n : 3 * n + r] = reference[min(2 * step + int(2.0 * nodes[stage]), 2 * steps)]
            call_kernel(address, source, target)
            if stage == 0 and step % every == 0:
                q[step // every], qd[step // every], tau[step // every] = x, v, target[n:]
            for i in range(n):
                kx[i], kv[i] = source[n + i], target[i]
                sx[i] += weights[stage] * kx[i]
                sv[i] += weights[stage] * kv[i]
        for i in range(n):
            v[i] += dt * sv[i]
            x[i] += dt * (v[i] if semi_implicit else sx[i])
        if stiction != 0 and turns_back(state[n : 2 * n], v):
            call_kernel(stiction, state, sticking)
            settle(dt, semi_implicit, sticking[: n * n], sticking[n * n :], state[:n], state[n : 2 * n], x, v)
        total = 0.0
        for i in range(n):
            total += x[i] + v[i]
        if not np.isfinite(total):
            return step
    return steps


_TABLE, _LIST = types.float64[:, ::1], types.float64[::1]
_SAMPLES = types.float64[:, :, ::1]


@loop(
    types.void(types.int64, types.int64, types.float64, _LIST, _LIST, types.boolean, types.int64, _TABLE, _TABLE,
               _SAMPLES, _SAMPLES, _SAMPLES, types.int64, types.int64),
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def advance_lanes(
    rows: int,
    stiction: int,
    dt: float,
    nodes: Array,
    weights: Array,
    semi_implicit: bool,
    every: int,
    reference: Array,
    parameters: Array,
    q: Array,
    qd: Array,
    tau: Array,
    first: int,
    last: int,
) -> None:
    """Integrate the variations `first` to `last`, blocks of lanes one after the other over the whole time.

    As `advance_one`, but `rows` is the address of the batch form, parameters are (K, p) and samples (K, M, n). A
    variation that diverges goes on as NaN and leaves the others alone.
    """
    n, r = q.shape[2], reference.shape[1]
    steps = (reference.shape[0] - 1) // 2
    x, v, xs, vs = np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n))
    kx, kv, sx, sv = np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n))
    x0, v0, slip = np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n))
    state, sticking = np.empty(2 * n + parameters.shape[1]), np.empty(n * n + 2 * n)
    given, torque, wanted = np.zeros((LANES, parameters.shape[1])), np.zeros((LANES, n)), np.zeros((LANES, r))
    places = np.array([a.ctypes.data for a in (xs, vs, slip, wanted, given, kv, torque)])
    for start in range(first, last, LANES):
        count = min(LANES, last - start)
        given[:count] = parameters[start : start + count]
        kx[:], kv[:] = 0.0, 0.0  # a stage before may have left NaN, and 0 * NaN is NaN
        x[:count], v[:count] = q[start : start + count, 0], qd[start : start + count, 0]
        for step in range(steps + 1):
            sx[:], sv[:] = 0.0, 0.0
            if stiction != 0:
                for lane in range(count):
                    for i in range(n):
                        x0[lane, i], v0[lane, i], slip[lane, i] = x[lane, i], v[lane, i], np.sign(v[lane, i])
            for stage in range(nodes.shape[0]):
                h = dt * nodes[stage]
                row = reference[min(2 * step + int(2.0 * nodes[stage]), 2 * steps)]
                for lane in range(count):
                    for i in range(n):
                        xs[lane, i], vs[lane, i] = x[lane, i] + h * kx[lane, i], v[lane, i] + h * kv[lane, i]
                    for i in range(r):
                        wanted[lane, i] = row[i]
                call_rows(rows, places.ctypes.data, 0, count)
                if stage == 0 and step % every == 0:
                    for lane in range(count):
                        for i in range(n):
                            q[start + lane, step // every, i] = x[lane, i]
                            qd[start + lane, step // every, i] = v[lane, i]
                            tau[start + lane, step // every, i] = torque[lane, i]
                for lane in range(count):
                    for i in range(n):
                        kx[lane, i] = vs[lane, i]
                        sx[lane, i] += weights[stage] * kx[lane, i]
                        sv[lane, i] += weights[stage] * kv[lane, i]
            for lane in range(count):
                for i in range(n):
                    v[lane, i] += dt * sv[lane, i]
                    x[lane, i] += dt * (v[lane, i] if semi_implicit else sx[lane, i])
            if stiction == 0:
                continue
            for lane in range(count):
                if turns_back(v0[lane], v[lane]):
                    state[:n], state[n : 2 * n], state[2 * n :] = x0[lane], v0[lane], given[lane]
                    call_kernel(stiction, state, sticking)
                    settle(
                        dt, semi_implicit, sticking[: n * n], sticking[n * n :], x0[lane], v0[lane], x[lane], v[lane]
                    )
