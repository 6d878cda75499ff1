"""What rules read off a process: its reaction curve, and models of one or two lags with dead time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from holonom.control.processes.linear import linear_system, step_response
from holonom.control.processes.process import Parts, Process, parts_of
from holonom.errors import ModelError

__all__ = ["Curve", "half_rule", "reaction_curve"]


@dataclass(frozen=True, slots=True)
class Curve:
    """A process as its step response shows it, or as a rule takes it.

    Attributes
    ----------
    slope
        Greatest rate of the output per input, 1/s; gain over lag.
    gain, lag
        Final change per input, and time constant, s; both infinite of an integrating process.
    dead_time
        s.
    second
        Second time constant, s; 0 without one.
    """

    slope: float
    gain: float
    lag: float
    dead_time: float
    second: float = 0.0


def reaction_curve(process: Process) -> Curve:
    """The tangent at the steepest point of the step response: dead time where it leaves 0, lag until the final value.

    One lag with dead time is taken as it is. Ziegler, Nichols, Trans. ASME 64, 1942.

    Raises
    ------
    ModelError
        A process without dead time and with a lag at most: its response is steepest at once, any gain would do; dead
        time alone; more than one integrator.
    """
    parts = parts_of(process)
    if parts.integrators > 1 or (not parts.lags and not parts.integrators and not parts.swings):
        raise ModelError("a reaction curve needs lags, or one integrator; take another rule")
    order = len(process.den) - 1
    if order == 1:
        slope, delay = process.num[0] / process.den[0], 0.0
    else:
        slope, delay = _steepest(process, parts)
    total = process.dead_time + delay
    if total <= 0.0:
        raise ModelError("the reaction curve has no dead time: rules of it allow any gain; place it by Bode, or lambda")
    if parts.integrators:
        return Curve(slope, math.inf, math.inf, total)
    return Curve(slope, parts.gain, parts.gain / slope, total)


def _steepest(process: Process, parts: Parts) -> tuple[float, float]:
    """Greatest slope, and where its tangent meets 0, s, without the dead time: of the impulse response's first peak."""
    num, den = np.array(process.num), np.array(process.den)
    if parts.integrators:  # it comes to a straight line, late by what is linear in s
        earlier = num[-2] / num[-1] if len(num) > 1 else 0.0
        return float(num[-1] / den[-2]), float(den[-3] / den[-2] - earlier)
    scale = 1.0 / max(parts.lags) if parts.lags else float(np.abs(np.roots(den)).max())
    slow = num * scale ** np.arange(len(num))[::-1], den * scale ** np.arange(len(den))[::-1]
    end = 1.5 * len(den) if parts.lags and not parts.swings else 12.0
    t = np.linspace(0.0, end, 40_001)
    rate = step_response(linear_system(num=np.polymul(slow[0], [1.0, 0.0]), den=slow[1]), t)[1]
    y = step_response(linear_system(num=slow[0], den=slow[1]), t)[1]
    k = int(np.argmax(rate))
    return float(rate[k]) * scale, float(t[k] - y[k] / rate[k]) / scale


def half_rule(process: Process, lags: int) -> Curve:
    """The process as one lag or two and dead time: half of the next lag goes to either, the rest is dead time.

    Parameters
    ----------
    process
        Of real lags; zeros on the right only, which count as dead time.
    lags
        How many of its lags, the integrator included, are kept: 1 or 2.

    Notes
    -----
    Skogestad, J. Process Control 13, 2003, 291.

    Raises
    ------
    ModelError
        Complex poles, zeros on the left, two integrators.
    """
    parts = parts_of(process)
    if parts.swings or any(lead > 0.0 for lead in parts.leads) or parts.integrators > 1:
        raise ModelError(
            "the half rule takes real lags, zeros on the right, and one integrator; this process has others"
        )
    chain = [*([math.inf] * parts.integrators), *parts.lags, 0.0, 0.0, 0.0]
    kept, left, rest = chain[:lags], chain[lags], sum(chain[lags + 1 :])
    kept[-1] += 0.5 * left
    dead_time = parts.dead_time + 0.5 * left + rest - sum(parts.leads)
    first, second = kept[0], kept[1] if lags == 2 else 0.0
    if parts.integrators:
        return Curve(parts.gain, math.inf, math.inf, dead_time, second)
    if first == 0.0:
        return Curve(math.inf, parts.gain, 0.0, dead_time, 0.0)
    return Curve(parts.gain / first, parts.gain, first, dead_time, second)
