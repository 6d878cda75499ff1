"""Loops of a sampled regulator and a process behind a zero-order hold, with computing delay; all exact."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from holonom.arrays import Array, whole_number
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process, make_process
from holonom.errors import ModelError, OutOfLimits

__all__ = [
    "SampledLimits",
    "SampledMargin",
    "largest_gain",
    "sampled_limits",
    "sampled_margin",
    "sampled_step",
    "too_short",
]

LEAST = 1e6 * float(np.finfo(float).eps)  # product of sample time over lags
CROSSINGS = 8  # the lowest ones, which are looked at; beyond, a loop is stable or not by its poles
LONGEST = 300  # dead time in samples, which are as many poles


@dataclass(frozen=True, slots=True)
class SampledMargin:
    """What a sampled loop keeps.

    Attributes
    ----------
    crossover
        rad/s; NaN without one.
    phase_margin_deg, gain_margin
        deg, factor; infinite where there is no crossing.
    stable
        Whether all closed-loop poles lie inside the unit circle.
    pole
        Size of the outermost one.
    Ms
        Largest sensitivity `|1/(1 + L)|`.
    """

    crossover: float
    phase_margin_deg: float
    gain_margin: float
    stable: bool
    pole: float
    Ms: float


class SampledLimits(NamedTuple):
    """Gains of a sampled P regulator: from which it is unstable, and up to which no pole swings."""

    largest_gain: float
    aperiodic_gain: float


class _Loop(NamedTuple):
    """`num(z)/den(z)`, falling powers."""

    num: Array
    den: Array


def sampled_margin(
    process: Process | Mapping[str, Any], gains: Gains, dt: float, *, delay_samples: int = 1
) -> SampledMargin:
    """Margins of a PID by backward differences on a process behind a hold.

    Parameters
    ----------
    process
        Its dead time may be any, whole samples or not.
    gains
        Kc, Ti, Td: `K_c (1 + T_s/T_i z/(z - 1) + T_d/T_s (z - 1)/z)`.
    dt
        Sample time, s.
    delay_samples
        Samples from the measurement until the output of it is held: 1 where computing takes up to one, 0 if none.

    Raises
    ------
    OutOfLimits
        A sample time that is not positive, below 1/300 of the dead time or vanishing beside the lags; a delay that is
        no whole number of samples.
    """
    return _margin(_loop(process, gains, dt, delay_samples), dt)


def largest_gain(
    process: Process | Mapping[str, Any], shape: Gains, dt: float, *, delay_samples: int = 1, margin_deg: float = 60.0
) -> float:
    """Largest Kc that keeps a phase margin, Ti and Td as given; arguments as `sampled_margin`.

    Raises
    ------
    ModelError
        There is none, at any gain: sample faster, or another Ti.
    OutOfLimits
        As `sampled_margin`.
    """
    loop = _loop(process, shape._replace(Kc=1.0), dt, delay_samples)
    w, L = _response(loop, dt)
    phase = _from_start(loop, L)
    k = np.flatnonzero((phase[:-1] > -math.pi + math.radians(margin_deg)) &
                       (phase[1:] <= -math.pi + math.radians(margin_deg)))  # fmt: skip
    sizes = [_size_at(w, L, phase, int(i), -math.pi + math.radians(margin_deg)) for i in k[:CROSSINGS]]
    for size in sorted(sizes, reverse=True):
        found = _margin(loop._replace(num=loop.num / size), dt)
        if found.stable and abs(found.phase_margin_deg - margin_deg) < 0.1:
            return 1.0 / size
    raise ModelError(
        f"no gain keeps {margin_deg:g} deg at a sample time of {dt:g} s with Ti = {shape.Ti:g} s; sample faster, or "
        "take a longer Ti"
    )


def sampled_limits(process: Process | Mapping[str, Any], dt: float, *, delay_samples: int = 1) -> SampledLimits:
    """Limits of a sampled P regulator; arguments and errors as `sampled_margin`.

    Infinite where there is none. Aperiodic: all closed-loop poles real and positive, or 0.
    """
    loop = _loop(process, Gains(1.0), dt, delay_samples)
    unit = _margin(loop, dt).gain_margin if math.isfinite(_margin(loop, dt).gain_margin) else 1.0

    def poles(gain: float) -> Any:
        return np.roots(np.polyadd(loop.den, gain * loop.num))

    def calm(gain: float) -> bool:
        p = poles(gain)
        return bool(np.all((np.abs(p.imag) <= 1e-7) & (p.real >= -1e-9)))

    largest = _edge(lambda g: bool(np.abs(poles(g)).max() < 1.0), unit)
    return SampledLimits(largest, _edge(calm, unit))


def sampled_step(
    process: Process | Mapping[str, Any], gains: Gains, dt: float, samples: int, *, delay_samples: int = 1
) -> Array:
    """Output (samples,) at the sample times after a step of the reference; arguments and errors as `sampled_margin`."""
    from scipy import signal  # heavy: on first use

    loop = _loop(process, gains, dt, delay_samples)
    den = np.polyadd(loop.den, loop.num)
    num = np.concatenate([np.zeros(len(den) - len(loop.num)), loop.num])
    y: Array = signal.lfilter(num, den, np.ones(whole_number("samples", samples, least=1)))
    return y


def too_short(process: Process, dt: float) -> bool:
    """Whether the poles of the sampled process lie so near to 1 that doubles do not tell the loop to 1e-6."""
    poles = np.abs(np.roots(process.den)) * dt
    return bool(np.prod(np.minimum(poles[poles > 0.0], 1.0)) < LEAST)


def _edge(call: Callable[[float], bool], unit: float) -> float:
    """Gain up to which something holds, from small ones on."""
    low, high = 1e-6 * unit, 1e-6 * unit
    if not call(low):
        return 0.0
    while call(high):
        low, high = high, 2.0 * high
        if high > 1e9 * unit:
            return math.inf
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if call(middle) else (low, middle)
    return low


def _loop(process: Process | Mapping[str, Any], gains: Gains, dt: float, delay_samples: int) -> _Loop:
    if not 0.0 < dt < math.inf:
        raise OutOfLimits(f"dt is {dt!r}; a sample time must be finite and greater than 0 s")
    process, delay = make_process(process), whole_number("delay_samples", delay_samples)
    if process.dead_time > LONGEST * dt:
        raise OutOfLimits(
            f"a dead time of {process.dead_time:g} s is more than {LONGEST} samples of {dt:g} s; sample more slowly"
        )
    if too_short(process, dt):
        raise OutOfLimits(
            f"a sample time of {dt:g} s is so short beside the lags that the sampled loop's numbers are lost; sampling "
            "costs nothing there: take the margins of the continuous loop"
        )
    num, den = _held(process, dt)
    Kc, Ti, Td = gains
    i, d = (0.0 if math.isinf(Ti) else dt / Ti), Td / dt
    top, bottom = np.array([1.0]), np.array([1.0])
    if i > 0.0 and d > 0.0:
        top, bottom = np.array([1.0 + i + d, -1.0 - 2.0 * d, d]), np.array([1.0, -1.0, 0.0])
    elif i > 0.0:
        top, bottom = np.array([1.0 + i, -1.0]), np.array([1.0, -1.0])
    elif d > 0.0:
        top, bottom = np.array([1.0 + d, -d]), np.array([1.0, 0.0])
    late = np.zeros(delay + 1)
    late[0] = 1.0
    above: Any = Kc * np.polymul(num, top)
    below: Any = np.polymul(np.polymul(den, bottom), late)
    return _Loop(above, below)


def _held(process: Process, dt: float) -> tuple[Array, Array]:
    """Process behind a zero-order hold, as num(z)/den(z); what of the dead time is no whole sample is exact, too."""
    from scipy import signal  # heavy: on first use

    whole = math.floor(process.dead_time / dt + 1e-9)
    part = max(process.dead_time - whole * dt, 0.0)
    if part < 1e-9 * dt:
        part = 0.0
    if len(process.den) == 1:
        if part > 0.0:
            whole += 1  # the held output is seen at the next sample
        late = np.zeros(whole + 1)
        late[0] = 1.0
        return np.array([process.num[0] / process.den[0]]), late
    A, B, C, _ = signal.tf2ss(process.num, process.den)
    full, rest = _stepped(A, B, dt), _stepped(A, B, dt - part)
    Phi = full[0]
    now, den = signal.ss2tf(Phi, rest[1], C, np.zeros((1, 1)))
    num = np.trim_zeros(np.ravel(now), "f")
    if part > 0.0:  # the input of the sample before acts until the dead time is over
        earlier, _ = signal.ss2tf(Phi, full[1] - rest[1], C, np.zeros((1, 1)))
        num = np.polyadd(np.polymul(num, [1.0, 0.0]), np.ravel(earlier))
        den = np.polymul(den, [1.0, 0.0])
    late = np.zeros(whole + 1)
    late[0] = 1.0
    return np.trim_zeros(num, "f"), np.polymul(den, late)


def _stepped(A: Array, B: Array, h: float) -> tuple[Array, Array]:
    from scipy import linalg  # heavy: on first use

    n = len(A)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n:] = A * h, B * h
    whole = linalg.expm(block)
    return whole[:n, :n], whole[:n, n:]


def _response(loop: _Loop, dt: float) -> tuple[Array, Array]:
    w = np.unique(np.concatenate([np.geomspace(1e-6, 1.0, 6000), np.linspace(1e-3, 1.0, 6000)])) * math.pi / dt
    z = np.exp(1j * w * dt)
    return w, np.polyval(loop.num, z) / np.polyval(loop.den, z)


def _from_start(loop: _Loop, L: Array) -> Array:
    """Unwrapped phase, which begins at -90 deg for each integrator."""
    at_one = int(sum(abs(p - 1.0) < 1e-4 for p in np.roots(loop.den)))
    phase = np.unwrap(np.angle(L))
    turned: Array = phase - 2.0 * math.pi * round((phase[0] + 0.5 * math.pi * at_one) / (2.0 * math.pi))
    return turned


def _size_at(w: Array, L: Array, phase: Array, k: int, angle: float) -> float:
    part = (phase[k] - angle) / (phase[k] - phase[k + 1])
    return float(math.exp((1.0 - part) * math.log(abs(L[k])) + part * math.log(abs(L[k + 1]))))


def _margin(loop: _Loop, dt: float) -> SampledMargin:
    from scipy.optimize import brentq  # heavy: on first use

    poles = np.roots(np.polyadd(loop.den, loop.num))
    pole = float(np.abs(poles).max(initial=0.0))
    w, L = _response(loop, dt)
    phase, size = _from_start(loop, L), np.log(np.abs(L))

    def log_size(x: float) -> float:
        z = np.exp(1j * x * dt)
        return math.log(abs(np.polyval(loop.num, z) / np.polyval(loop.den, z)))

    margins = []
    for k in np.flatnonzero(np.signbit(size[:-1]) != np.signbit(size[1:]))[:CROSSINGS]:
        if log_size(w[k]) * log_size(w[k + 1]) >= 0.0:  # a size of 1 but for rounding
            continue
        x = float(brentq(log_size, w[k], w[k + 1]))
        margins.append((180.0 + math.degrees(np.interp(x, w, phase)), x))
    phase_margin, crossover = min(margins, default=(math.inf, math.nan))
    turn = (phase + math.pi) / (2.0 * math.pi)
    turns = np.flatnonzero(np.floor(turn[:-1]) != np.floor(turn[1:]))
    gains = []
    for k in turns:
        whole = math.pi * (2.0 * max(math.floor(turn[k]), math.floor(turn[k + 1])) - 1.0)
        gains.append(1.0 / _size_at(w, L, phase, int(k), whole))
    z = -1.0 + 0.0j
    end = np.polyval(loop.num, z) / np.polyval(loop.den, z)
    if end.real < 0.0 and abs(end.imag) < 1e-9 * abs(end):
        gains.append(1.0 / float(abs(end)))
    gain = min(gains, key=lambda g: abs(math.log(g)), default=math.inf)
    return SampledMargin(crossover, phase_margin, gain, pole < 1.0, pole, 1.0 / float(np.abs(1.0 + L).min()))
