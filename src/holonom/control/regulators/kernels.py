"""Compiled parts of regulators: the linear PID law, a derivative over four samples, a reference with limited rate."""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.control.regulators.contract import PidSettings
from holonom.errors import OutOfLimits
from holonom.trace.code.loops import loop

__all__ = [
    "PidParams",
    "PidState",
    "four_sample_rate",
    "pid_law",
    "pid_params",
    "pid_rest",
    "ramp_step",
]


class PidParams(NamedTuple):
    """Discrete PID: `P + I + D` with weights b, c of the reference.

    `P = gain (b r - y)`; `I += now e_k + before e_(k-1)`; `D = fade D + rate (w_k - w_(k-1))` with `w = c r - y`, where
    over four samples `(w_k + 3 w_(k-1) - 3 w_(k-2) - w_(k-3))/6` stands for the difference. `track`: of the integral.
    """

    gain: float
    now: float
    before: float
    rate: float
    fade: float
    b: float
    c: float
    four: bool
    track: float


class PidState(NamedTuple):
    """Integral, last error, derivative part, the last three of `w = c r - y`, last output."""

    integral: float
    error: float
    derivative: float
    w1: float
    w2: float
    w3: float
    output: float


class PidParts(NamedTuple):
    """What `pid_law` finds: what the integral takes, the derivative part, `w`, the output that is wanted."""

    growth: float
    derivative: float
    w: float
    wanted: float


def pid_params(
    settings: PidSettings,
    dt: float,
    gains: tuple[float, float, float],
    *,
    b: float = 1.0,
    c: float = 1.0,
    four: bool = False,
    track: float = 0.0,
) -> PidParams:
    """Discrete `k_p + k_i/s + k_d s/(1 + s T)` by the method of the settings; `gains` are k_p, k_i, k_d.

    Notes
    -----
    `s -> (1 - 1/z)/T_s` (backward), `2 (1 - 1/z)/(1 + 1/z)/T_s` (Tustin); zero-order hold: the step response is met at
    the samples. Franklin, Powell, Workman, Digital Control of Dynamic Systems, ch. 6.

    Raises
    ------
    OutOfLimits
        Tustin or zero-order hold of a derivative without a filter, which would ring or be infinite.
    """
    k_p, k_i, k_d = gains
    T, method = settings.T, settings.method
    if k_d != 0.0 and T == 0.0 and method != "backward":
        raise OutOfLimits(f"T is 0.0; {method!r} needs a filtered derivative: T > 0 s, or method='backward'")
    if four and method != "backward":
        raise OutOfLimits(f"a derivative over four samples with method={method!r}; it is made of backward differences")
    now, before = {"backward": (1.0, 0.0), "tustin": (0.5, 0.5), "zoh": (0.0, 1.0)}[method]
    if k_d == 0.0:
        rate, fade = 0.0, 0.0
    elif method == "backward":
        rate, fade = k_d / (T + dt), T / (T + dt)
    elif method == "tustin":
        rate, fade = 2.0 * k_d / (2.0 * T + dt), (2.0 * T - dt) / (2.0 * T + dt)
    else:
        rate, fade = k_d / T, math.exp(-dt / T)
    return PidParams(k_p, now * k_i * dt, before * k_i * dt, rate, fade, b, c, four, track)


@loop
def pid_law(params: PidParams, state: PidState, r: float, y: float) -> PidParts:
    """The linear law, before its output is limited."""
    error, w = r - y, params.c * r - y
    change = (w + 3.0 * (state.w1 - state.w2) - state.w3) / 6.0 if params.four else w - state.w1
    derivative = params.fade * state.derivative + params.rate * change
    growth = params.now * error + params.before * state.error
    wanted = params.gain * (params.b * r - y) + state.integral + growth + derivative
    return PidParts(growth, derivative, w, wanted)


@loop
def pid_rest(params: PidParams, u: float, r: float, y: float) -> PidState:
    """The state in which r and y have lasted, and the next output is u."""
    error, w = r - y, params.c * r - y
    integral = u - params.gain * (params.b * r - y) - (params.now + params.before) * error
    return PidState(integral, error, 0.0, w, w, w, u)


@loop
def four_sample_rate(x0: float, x1: float, x2: float, x3: float, dt: float) -> float:
    """Rate of change by four samples, the newest first: `(x0 + 3 x1 - 3 x2 - x3)/(6 T_s)`.

    It is exact for straight lines, 1.5 samples late, and white noise of deviation 1 leaves `sqrt(20)/6 = 0.745` of
    1/T_s in it; the difference of two samples has `sqrt 2`.
    """
    return (x0 + 3.0 * (x1 - x2) - x3) / (6.0 * dt)


@loop
def ramp_step(before: float, r: float, most: float) -> float:
    """The reference nearest to r that differs from the one before by at most `most`."""
    return min(max(r, before - most), before + most)
