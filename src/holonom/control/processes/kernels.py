"""Compiled responses of linear systems in state space."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.trace.code.loops import loop

__all__ = ["delayed_loop", "ramped_response"]


@loop
def ramped_response(A: Array, B0: Array, B1: Array, C: Array, D: float, x: Array, u: Array) -> Array:
    """Outputs (N,) of `x_(k+1) = A x_k + B0 u_k + B1 u_(k+1)`, `y = C x + D u`, from x (n,)."""
    n, N = x.shape[0], u.shape[0]
    x, after, y = x.copy(), np.empty(n), np.empty(N)
    for k in range(N):
        total = D * u[k]
        for i in range(n):
            total += C[i] * x[i]
        y[k] = total
        if k + 1 < N:
            for i in range(n):
                part = B0[i] * u[k] + B1[i] * u[k + 1]
                for j in range(n):
                    part += A[i, j] * x[j]
                after[i] = part
            x[:] = after
    return y


@loop
def delayed_loop(A: Array, B0: Array, B1: Array, C: Array, m: int, r: Array) -> Array:
    """Outputs (N,) of the closed loop around `x_(k+1) = A x_k + B0 e_(k-m) + B1 e_(k-m+1)`, `e = r - C x`, m >= 1.

    The method of steps: what goes in was known a dead time ago.
    """
    n, N = A.shape[0], r.shape[0]
    x, after, y, e = np.zeros(n), np.empty(n), np.empty(N), np.empty(N)
    for k in range(N):
        total = 0.0
        for i in range(n):
            total += C[i] * x[i]
        y[k], e[k] = total, r[k] - total
        now = e[k - m] if k >= m else 0.0
        later = e[k - m + 1] if k >= m else 0.0
        for i in range(n):
            part = B0[i] * now + B1[i] * later
            for j in range(n):
                part += A[i, j] * x[j]
            after[i] = part
        x[:] = after
    return y
