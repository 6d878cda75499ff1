"""Fixed-step integration of a closed loop, compiled once for every arm: an arm comes in as its compiled equation.

`advance_one` calls the equation's C form for one arm; `advance_lanes` its block form for 64 variations at a time.
Both take a tableau in which each stage uses the one before it only (Euler, midpoint, classical Runge-Kutta).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from holonom.trace.emit import LANES
from holonom.trace.pointer import call_kernel

__all__ = ["advance_lanes", "advance_one"]

Floats = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def advance_one(
    address: int,
    dt: float,
    nodes: Floats,
    weights: Floats,
    semi_implicit: bool,
    every: int,
    reference: Floats,
    parameters: Floats,
    q: Floats,
    qd: Floats,
    tau: Floats,
) -> int:
    """Integrate one arm.

    Parameters
    ----------
    address
        Of the closed loop's C form.
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
    source, target = np.empty(2 * n + r + parameters.shape[0]), np.empty(2 * n)
    source[2 * n + r :] = parameters
    x, v = q[0].copy(), qd[0].copy()
    kx, kv, sx, sv = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    steps = (reference.shape[0] - 1) // 2
    for step in range(steps + 1):
        sx[:], sv[:] = 0.0, 0.0
        for stage in range(nodes.shape[0]):
            h = dt * nodes[stage]
            for i in range(n):
                source[i], source[n + i] = x[i] + h * kx[i], v[i] + h * kv[i]
            source[2 * n : 2 * n + r] = reference[min(2 * step + int(2.0 * nodes[stage]), 2 * steps)]
            call_kernel(address, source, target)
            if stage == 0 and step % every == 0:
                q[step // every], qd[step // every], tau[step // every] = x, v, target[n:]
            for i in range(n):
                kx[i], kv[i] = source[n + i], target[i]
                sx[i] += weights[stage] * kx[i]
                sv[i] += weights[stage] * kv[i]
        total = 0.0
        for i in range(n):
            v[i] += dt * sv[i]
            x[i] += dt * (v[i] if semi_implicit else sx[i])
            total += x[i] + v[i]
        if not np.isfinite(total):
            return step
    return steps


_ROWS = types.FunctionType(types.float64(*[types.float64[:, ::1]] * 6, types.int64, types.int64))
_TABLE, _LIST = types.float64[:, ::1], types.float64[::1]
_SAMPLES = types.float64[:, :, ::1]


@njit(
    types.void(_ROWS, types.float64, _LIST, _LIST, types.boolean, types.int64, _TABLE, _TABLE, _SAMPLES, _SAMPLES,
               _SAMPLES, types.int64, types.int64),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def advance_lanes(
    rows: Any,
    dt: float,
    nodes: Floats,
    weights: Floats,
    semi_implicit: bool,
    every: int,
    reference: Floats,
    parameters: Floats,
    q: Floats,
    qd: Floats,
    tau: Floats,
    first: int,
    last: int,
) -> None:
    """Integrate the variations `first` to `last`, blocks of lanes one after the other over the whole time.

    As `advance_one`, but `rows` is the block form, parameters are (K, p) and samples (K, M, n). A variation that
    diverges goes on as NaN and leaves the others alone.
    """
    n, r = q.shape[2], reference.shape[1]
    steps = (reference.shape[0] - 1) // 2
    x, v, xs, vs = np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n))
    kx, kv, sx, sv = np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n)), np.zeros((LANES, n))
    given, torque, wanted = np.zeros((LANES, parameters.shape[1])), np.zeros((LANES, n)), np.zeros((LANES, r))
    for start in range(first, last, LANES):
        count = min(LANES, last - start)
        given[:count] = parameters[start : start + count]
        kx[:], kv[:] = 0.0, 0.0  # a stage before may have left NaN, and 0 * NaN is NaN
        x[:count], v[:count] = q[start : start + count, 0], qd[start : start + count, 0]
        for step in range(steps + 1):
            sx[:], sv[:] = 0.0, 0.0
            for stage in range(nodes.shape[0]):
                h = dt * nodes[stage]
                row = reference[min(2 * step + int(2.0 * nodes[stage]), 2 * steps)]
                for lane in range(count):
                    for i in range(n):
                        xs[lane, i], vs[lane, i] = x[lane, i] + h * kx[lane, i], v[lane, i] + h * kv[lane, i]
                    for i in range(r):
                        wanted[lane, i] = row[i]
                rows(xs, vs, wanted, given, kv, torque, 0, count)
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
