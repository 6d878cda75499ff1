"""Step responses of closed loops: exact steps without dead time, the method of steps with it."""

from __future__ import annotations

import math

import numpy as np

from holonom.arrays import Array
from holonom.control.processes.kernels import delayed_loop, ramped_response
from holonom.control.processes.linear import ramp_matrices
from holonom.control.processes.loop import LoopFigures, OpenLoop, loop_figures
from holonom.errors import OutOfLimits

__all__ = ["closed_step", "overshoot_percent", "vertex"]

STEPS = 400  # a radian of the crossover, and at least in a dead time
MOST = 400_000  # samples of a response


def closed_step(
    loop: OpenLoop, *, prefilter: float = 0.0, end: float | None = None, figures: LoopFigures | None = None
) -> tuple[Array, Array]:
    """Times (N,), s, and output (N,) of the closed loop after a step of the reference.

    Parameters
    ----------
    loop
        Its closed loop is stable.
    prefilter
        Lag of the reference, `1/(1 + s prefilter)`, s.
    end
        s; None: 40 radians of the crossover and 12 dead times, at least 8 prefilters.
    figures
        Of the loop, where they are known already.

    Notes
    -----
    Without dead time each step is the matrix exponential, exact. With it, the error of a dead time ago goes in straight
    from sample to sample (method of steps; Bellman, Cooke, Differential-Difference Equations, 1963), which misses
    `(w h)^2/12 < 1e-6` at a crossover w.

    Raises
    ------
    OutOfLimits
        The closed loop is unstable, or its proportional part meets no lag.
    """
    figures = loop_figures(loop) if figures is None else figures
    if not figures.stable:
        raise OutOfLimits("the closed loop is unstable; lower the gain")
    if len(loop.num) == len(loop.den):
        raise OutOfLimits(
            "a proportional part on a process without a lag has no smooth response; take an integral alone"
        )
    w = figures.crossover if math.isfinite(figures.crossover) else _bandwidth(loop)
    span = 40.0 / w + 12.0 * loop.dead_time if end is None else end
    span = max(span, 8.0 * prefilter) if end is None else span
    h = 1.0 / (STEPS * w)
    m = math.ceil(loop.dead_time / h)
    if loop.dead_time > 0.0:
        m = max(m, 50)
        h = loop.dead_time / m
    count = min(math.ceil(span / h), MOST) + 1
    t = np.asarray(h * np.arange(count), dtype=np.float64)
    r = np.ones(count) if prefilter == 0.0 else -np.expm1(-t / prefilter)
    A, B, C = _scaled(loop, w)
    if m == 0:
        Ad, B0, B1 = ramp_matrices(A - np.outer(B, C), B, w * h)
        return t, ramped_response(Ad, B0, B1, C, 0.0, np.zeros(len(A)), r)
    Ad, B0, B1 = ramp_matrices(A, B, w * h)
    return t, delayed_loop(Ad, B0, B1, C, m, r)


def overshoot_percent(loop: OpenLoop, *, prefilter: float = 0.0, figures: LoopFigures | None = None) -> float:
    """How far the step response of the closed loop goes beyond its final value, %; errors as `closed_step`."""
    _, y = closed_step(loop, prefilter=prefilter, figures=figures)
    top = int(np.argmax(y))
    return max(100.0 * (vertex(y, top) / _final(loop) - 1.0), 0.0)


def vertex(y: Array, top: int) -> float:
    """Return the top of the parabola through the largest sample and its neighbours."""
    if not 0 < top < len(y) - 1:
        return float(y[top])
    a, b, c = y[top - 1 : top + 2]
    bend = a - 2.0 * b + c
    return float(b - (c - a) ** 2 / (8.0 * bend)) if bend < 0.0 else float(b)


def _final(loop: OpenLoop) -> float:
    if loop.den[-1] == 0.0:
        return 1.0
    L = float(loop.num[-1] / loop.den[-1])
    return L / (1.0 + L)


def _bandwidth(loop: OpenLoop) -> float:
    """Of a loop whose size never reaches 1: its slowest corner, rad/s."""
    return float(np.abs(np.roots(loop.den)).min())


def _scaled(loop: OpenLoop, w: float) -> tuple[Array, Array, Array]:
    """State space (A, B, C) of the rational part in the time w t, in which its numbers are near 1."""
    from scipy import signal  # heavy: on first use

    num = loop.num * w ** np.arange(len(loop.num))[::-1].astype(float)
    den = loop.den * w ** np.arange(len(loop.den))[::-1].astype(float)
    A, B, C, _ = signal.tf2ss(num, den)
    return A, np.ascontiguousarray(B[:, 0]), np.ascontiguousarray(C[0])
