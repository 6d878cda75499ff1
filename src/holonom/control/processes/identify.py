"""Processes from records: of a step, or of any input that is held between its changes; of a relay experiment."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from holonom.arrays import Array, finite_array
from holonom.control.processes.loop import ultimate_gain
from holonom.control.processes.process import IntegratingLag, LagDeadTime, Process, TwoLags, kind_of, make_process
from holonom.control.processes.relay import describing_gain
from holonom.errors import CalibrationError, OutOfLimits, UnknownName

__all__ = ["MODELS", "Fit", "RelayFit", "identify_relay", "identify_step"]

LEAST = 8  # samples after the step
COARSE = 300  # samples that the search for a start looks at
FLOOR = 1e-5  # misfit over the change of the output, below which a model counts as exact


@dataclass(frozen=True, slots=True)
class Fit:
    """A process fitted to a record.

    Attributes
    ----------
    process
        Its kind and numbers are in `process.given`.
    misfit
        Root mean square of what it does not explain, in units of the output.
    misfit_percent
        The same over the range of the output, %.
    compared
        Of every kind that was tried: its misfit in %.
    """

    process: Process
    misfit: float
    misfit_percent: float
    compared: dict[str, float]


@dataclass(frozen=True, slots=True)
class RelayFit:
    """What a relay experiment tells.

    Attributes
    ----------
    fit
        The process fitted to the whole record.
    relay, amplitude, period
        Of the input, and of the output without its noise: half of what they swing; s.
    Ku_describing_function
        Ultimate gain as if the output were a sine.
    Ku_exact, Tu_exact
        Of the fitted process; s. Infinite and NaN where no gain makes that swing.
    describing_function_error_percent
        Of the first against the second: negative where it is too low.
    """

    fit: Fit
    relay: float
    amplitude: float
    period: float
    Ku_describing_function: float
    Ku_exact: float
    Tu_exact: float
    describing_function_error_percent: float


def identify_step(t: Any, u: Any, y: Any, *, kind: str | None = None) -> Fit:
    """Fit a process to the record of a step, or of several.

    Parameters
    ----------
    t, u, y
        (N,), s, input and output; the input is held between its changes, the output may be noisy. The record begins at
        rest.
    kind
        Of `MODELS`; None: the one that explains it best, a simpler one unless another is clearly better (Schwarz).

    Raises
    ------
    UnknownName
        No such kind.
    CalibrationError
        No step, one too near to the end, an output that does not answer.
    ShapeError, OutOfLimits
        Arrays of other shapes, not finite; times that do not grow.
    """
    t, u, y = _record(t, u, y)
    edges = np.flatnonzero(np.diff(u) != 0.0) + 1
    if not len(edges):
        raise CalibrationError("the input never changes; record a step of it")
    if len(edges) > 400:
        raise CalibrationError(
            f"the input changes {len(edges)} times; it must be held between a few steps, as commanded"
        )
    if len(t) - edges[0] < LEAST:
        raise CalibrationError(
            f"{len(t) - edges[0]} samples follow the step; {LEAST} at least are needed: record longer"
        )
    return _best(t, y, t[edges], np.diff(u)[edges - 1], kind, False)[0]


def identify_relay(t: Any, u: Any, y: Any, *, hysteresis: float = 0.0, kind: str | None = None) -> RelayFit:
    """Fit a process to the record of a relay experiment, and say what the describing function makes of it.

    Parameters
    ----------
    t, u, y
        (N,), s, input that switches between two values, and output; at least two whole periods.
    hysteresis
        The relay switches where the error crosses +-hysteresis, in units of the output.
    kind
        Of `MODELS`; None: the one that explains it best.

    Raises
    ------
    UnknownName
        No such kind.
    CalibrationError
        An input that does not switch for two periods; a hysteresis above the amplitude.
    ShapeError, OutOfLimits
        Arrays of other shapes, not finite; times that do not grow.
    """
    t, u, y = _record(t, u, y)
    if not 0.0 <= hysteresis < math.inf:
        raise OutOfLimits(f"hysteresis is {hysteresis!r}; it must be finite and at least 0")
    edges = np.flatnonzero(np.diff(u) != 0.0) + 1
    middle = 0.5 * (u.max() + u.min())
    ups = [k for k in edges if u[k] > middle >= u[k - 1]]
    if len(ups) < 3:
        raise CalibrationError(f"the relay switches up {len(ups)} times; two whole periods, 3 times, are needed")
    period = float(t[ups[-1]] - t[ups[-3]]) / 2.0
    later = t >= t[0] + period  # what came in before the record has passed the dead time by then
    fit, left = _best(t[later], y[later], t[edges], np.diff(u)[edges - 1], kind, True)
    last = t[later] >= t[ups[-3]]
    smooth = (y[later] - left)[last]
    relay, amplitude = 0.5 * float(u.max() - u.min()), 0.5 * float(smooth.max() - smooth.min())
    if amplitude <= hysteresis:
        raise CalibrationError(f"the output swings by {amplitude:g}, the hysteresis is {hysteresis:g}; it must be less")
    simple = describing_gain(relay, amplitude, hysteresis)
    try:
        Ku, Tu = ultimate_gain(fit.process)
    except OutOfLimits:
        Ku, Tu = math.inf, math.nan
    return RelayFit(fit, relay, amplitude, period, simple, Ku, Tu, 100.0 * (simple / Ku - 1.0))


def _record(t: Any, u: Any, y: Any) -> tuple[Array, Array, Array]:
    t = finite_array("t", t, ("N",))
    u, y = finite_array("u", u, (len(t),)), finite_array("y", y, (len(t),))
    if len(t) < LEAST or np.any(np.diff(t) <= 0.0):
        raise OutOfLimits(f"t holds {len(t)} times; {LEAST} at least are needed, and each after the one before")
    return t, u, y


def _best(t: Array, y: Array, at: Array, jumps: Array, kind: str | None, moving: bool) -> tuple[Fit, Array]:
    if kind is not None and kind not in MODELS:
        raise UnknownName("kind of model", kind, MODELS)
    span = float(y.max() - y.min())
    if span == 0.0:
        raise CalibrationError("the output does not move; is it the one that the input drives?")
    found: dict[str, tuple[Process, Array, float, float]] = {}
    for name in MODELS if kind is None else [kind]:
        try:
            process, left = _fit(name, t, y, at, jumps, moving)
        except CalibrationError:
            if kind is not None:
                raise
            continue
        misfit = float(np.sqrt(np.mean(left**2)))
        floor = max(misfit, FLOOR * span)
        found[name] = process, left, misfit, 2.0 * len(t) * math.log(floor) + MODELS[name].numbers * math.log(len(t))
    if not found:
        raise CalibrationError("no model explains the output: does it answer in the direction of the input?")
    process, left, misfit, _ = min(found.values(), key=lambda each: each[3])
    compared = {name: 100.0 * each[2] / span for name, each in found.items()}
    return Fit(process, misfit, 100.0 * misfit / span, compared), left


def _fit(kind: str, t: Array, y: Array, at: Array, jumps: Array, moving: bool) -> tuple[Process, Array]:
    """Process, and what is left (N,): times by search, then least squares; what is linear (gain, offset) is solved."""
    from scipy.optimize import least_squares  # heavy: on first use

    gap = float(np.diff(at).min()) if len(at) > 1 else math.inf
    end = 10.0 * gap if moving else float(t[-1] - at[0])
    step = end / max(len(t), 100)
    count = MODELS[kind].lags

    def solved(p: Array, rows: slice) -> tuple[Array, Array]:
        """Factors of the columns, and what they leave."""
        X = _columns(kind, np.exp(p[:count]), p[count], t[rows], at, jumps, moving)
        scale = np.linalg.norm(X, axis=0) + 1e-300
        factors = np.linalg.lstsq(X / scale, y[rows], rcond=1e-10)[0] / scale
        return factors, y[rows] - X @ factors

    def residual(p: Array, rows: slice = slice(None)) -> Array:
        return solved(p, rows)[1]

    lags = np.geomspace(0.2 * step, 2.0 * end, 14)
    delays = np.linspace(0.0, 0.98 * gap if moving else 0.6 * end, 16)
    starts = [
        np.array([*np.log(pair), delay])
        for pair in itertools.combinations_with_replacement(lags, count)
        for delay in delays
    ]
    some = slice(None, None, max(len(t) // COARSE, 1))
    starts.sort(key=lambda p: float(np.sum(residual(p, some) ** 2)))
    low = np.array([*([math.log(1e-3 * step)] * count), 0.0])
    high = np.array([*([math.log(100.0 * end)] * count), gap if moving else end])
    options = {"bounds": (low, high), "x_scale": [1.0] * count + [end], "max_nfev": 200}
    options |= dict.fromkeys(("xtol", "ftol", "gtol"), 1e-14)
    tries = [
        least_squares(residual, np.clip(p, low + 1e-9 * abs(low), high - 1e-9 * abs(high)), **options)
        for p in starts[:3]
    ]
    best = min(tries, key=lambda found: float(found.cost))
    p = best.x
    gain = float(solved(p, slice(None))[0][0])
    if gain <= 0.0:
        raise CalibrationError(
            "the output goes against the input: this process has a negative gain; exchange the sign of one of them"
        )
    times = sorted(np.exp(p[:count]).tolist(), reverse=True)
    return _named(kind, gain, times, float(p[count])), best.fun


def _named(kind: str, gain: float, lags: Sequence[float], delay: float) -> Process:
    delay = delay if delay >= 1e-9 else 0.0  # what doubles leave of none
    return make_process({"kind": kind, "dead_time": delay, **MODELS[kind].keys(gain, lags)})


def _columns(kind: str, lags: Array, delay: float, t: Array, at: Array, jumps: Array, moving: bool) -> Array:
    """What the output is a sum of: the answer to the input at gain 1, a constant, and what fades from before."""
    late = np.maximum(t[:, None] - at[None, :] - delay, 0.0)
    parts = [MODELS[kind].step(late, lags) @ jumps, np.ones_like(t)]
    if moving:
        parts += [np.exp(-(t - t[0]) / lag) for lag in lags]
        if MODELS[kind].step is _ramp:
            parts.append(t - t[0])
    return np.column_stack(parts)


def _one(x: Array, lags: Array) -> Array:
    found: Array = -np.expm1(-x / lags[0])
    return found


def _two(x: Array, lags: Array) -> Array:
    a, b = float(lags.max()), float(lags.min())
    if a - b < 1e-5 * a:
        middle = 0.5 * (a + b)
        same: Array = 1.0 - (1.0 + x / middle) * np.exp(-x / middle)
        return same
    found: Array = 1.0 - (a * np.exp(-x / a) - b * np.exp(-x / b)) / (a - b)
    return found


def _ramp(x: Array, lags: Array) -> Array:
    found: Array = x + lags[0] * np.expm1(-x / lags[0])
    return found


class _Model(NamedTuple):
    """Lags, numbers that are fitted, step response at gain 1, keys of the kind."""

    lags: int
    numbers: int
    step: Callable[[Array, Array], Array]
    keys: Callable[[float, Sequence[float]], dict[str, Any]]


MODELS = {
    kind_of(LagDeadTime): _Model(1, 4, _one, lambda gain, lags: {"gain": gain, "lag": lags[0]}),
    kind_of(TwoLags): _Model(2, 5, _two, lambda gain, lags: {"gain": gain, "lags": list(lags)}),
    kind_of(IntegratingLag): _Model(1, 4, _ramp, lambda gain, lags: {"integral_time": 1.0 / gain, "lag": lags[0]}),
}
"""Kinds that are fitted; all with dead time."""
