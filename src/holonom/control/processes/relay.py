"""A relay around a process: its exact limit cycle, and what the describing function makes of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.control.processes.closed import vertex
from holonom.control.processes.loop import ultimate_gain
from holonom.control.processes.process import Process, make_process
from holonom.errors import ModelError, OutOfLimits

__all__ = ["RelayCycle", "describing_gain", "relay_cycle"]


@dataclass(frozen=True, slots=True)
class RelayCycle:
    """A limit cycle under a relay.

    Attributes
    ----------
    amplitude, period
        Of the output; s.
    Ku_describing_function
        `4 d/(pi sqrt(a^2 - h^2))`: the ultimate gain if the output were a sine; the period stands for Tu.
    Ku_exact, Tu_exact
        Of the process; s. Infinite and NaN where no gain makes it swing.
    describing_function_error_percent
        By how much the describing function misses Ku: negative below it.
    """

    amplitude: float
    period: float
    Ku_describing_function: float
    Ku_exact: float
    Tu_exact: float

    @property
    def describing_function_error_percent(self) -> float:
        """In % of the exact one."""
        return 100.0 * (self.Ku_describing_function / self.Ku_exact - 1.0)


def describing_gain(relay: float, amplitude: float, hysteresis: float) -> float:
    """Gain of a relay of +-`relay` and +-`hysteresis` for a sine (Astrom, Hagglund, Automatica 20, 1984)."""
    return 4.0 * relay / (math.pi * math.sqrt(amplitude**2 - hysteresis**2))


def relay_cycle(process: Process | Mapping[str, Any], relay: float, hysteresis: float = 0.0) -> RelayCycle:
    """The symmetric limit cycle of a process under a relay, exactly.

    Parameters
    ----------
    process
        Stable, or with one integrator.
    relay
        The relay gives +-relay.
    hysteresis
        It switches where the error crosses +-hysteresis, in units of the output.

    Notes
    -----
    Half a period h satisfies `y(h) = -hysteresis` where the state has changed its sign (Tsypkin; Astrom 1995).

    Raises
    ------
    OutOfLimits
        A relay that is not positive, a negative hysteresis.
    ModelError
        There is no limit cycle: no dead time, no hysteresis and too few lags.
    """
    from scipy import signal  # heavy: on first use
    from scipy.optimize import brentq  # heavy: on first use

    process = make_process(process)
    if not (relay > 0.0 and math.isfinite(relay) and 0.0 <= hysteresis < math.inf):
        raise OutOfLimits(f"relay is {relay!r}, hysteresis {hysteresis!r}; they must be positive, and not negative")
    if len(process.den) == 1:
        raise ModelError(
            "dead time alone under a relay jumps to its limits: no lag, nothing to measure but the dead time"
        )
    A, B, C, _ = signal.tf2ss(process.num, process.den)
    rates = np.abs(np.roots(process.den))
    scale = 1.0 / float(rates[rates > 0.0].min()) if (rates > 0.0).any() else 1.0
    L = process.dead_time
    scale = max(scale, L)

    def state(h: float) -> Any:
        """State when the relay switches up, half a period h after it switched down."""
        Phi, whole = _stepped(A, B, h)
        _, late = _stepped(A, B, h - L)
        return -np.linalg.solve(np.eye(len(A)) + Phi, relay * (2.0 * late - whole))

    def gap(h: float) -> float:
        return float((C @ state(h))[0]) + hysteresis

    grid = L + scale * np.geomspace(1e-4, 60.0, 300)
    values = np.array([gap(h) for h in grid])
    crossing = np.flatnonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))
    if not len(crossing):
        raise ModelError(
            "no limit cycle under this relay: the process needs dead time, three lags, or the relay hysteresis"
        )
    k = int(crossing[0])
    h = float(brentq(gap, grid[k], grid[k + 1], xtol=1e-14 * grid[k], rtol=1e-13))
    amplitude = _amplitude(A, B, C, state(h), h, L, relay)
    try:
        Ku, Tu = ultimate_gain(process)
    except OutOfLimits:  # two lags swing by the hysteresis only
        Ku, Tu = math.inf, math.nan
    return RelayCycle(amplitude, 2.0 * h, describing_gain(relay, amplitude, hysteresis), Ku, Tu)


def _amplitude(A: Array, B: Array, C: Array, x0: Any, h: float, L: float, relay: float) -> float:
    """Largest output of half a period, in which the input that arrives is -relay until L, then +relay."""
    largest, x, n = 0.0, x0, 500
    for span, u in ((L, -relay), (h - L, relay)):
        Phi, Gamma = _stepped(A, B, span / n)
        y = [float((C @ x)[0])]
        for _ in range(n):
            x = Phi @ x + u * Gamma
            y.append(float((C @ x)[0]))
        size = np.abs(y)
        largest = max(largest, vertex(size, int(np.argmax(size))))
    return largest


def _stepped(A: Array, B: Array, h: float) -> tuple[Array, Array]:
    from scipy import linalg  # heavy: on first use

    n = len(A)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n:] = A * h, B * h
    whole = linalg.expm(block)
    return whole[:n, :n], whole[:n, n]
