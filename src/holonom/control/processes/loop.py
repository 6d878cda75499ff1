"""Open loops by their frequency response, dead time exact: margins, peaks, whether the closed loop is stable."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.control.processes.process import Process, make_process
from holonom.errors import OutOfLimits

__all__ = ["Gains", "LoopFigures", "OpenLoop", "loop_figures", "open_loop", "phase_crossings", "ultimate_gain"]

NEAREST = 4  # phase crossings that are refined: those where the size is nearest to 1
DERIVATIVE_FILTER = 10.0  # Td over the lag of its filter, where the loop would not fall off without one


class Gains(NamedTuple):
    """`K_c (1 + 1/(s T_i) + s T_d)`; Ti infinite without an integral. In form I only `K_c/(s T_i)` is meant."""

    Kc: float
    Ti: float = math.inf
    Td: float = 0.0


class OpenLoop(NamedTuple):
    """`e^(-s dead_time) num(s)/den(s)`, falling powers of s."""

    num: Array
    den: Array
    dead_time: float

    def response(self, w: Any) -> Any:
        """At frequencies (n,), rad/s."""
        s = 1j * np.asarray(w, dtype=float)
        return np.polyval(self.num, s) / np.polyval(self.den, s) * np.exp(-s * self.dead_time)


@dataclass(frozen=True, slots=True)
class LoopFigures:
    """What an open loop promises.

    Attributes
    ----------
    crossover, phase_crossover
        rad/s, where its size is 1, and where its phase is -180 deg; NaN where there is none.
    phase_margin_deg, gain_margin
        deg (infinite without a crossover), factor (infinite without a phase crossover).
    Ms, peak_frequency
        Largest sensitivity `|1/(1 + L)|`, and where, rad/s; 1/Ms is the distance from -1.
    stable
        Whether the closed loop is.
    """

    crossover: float
    phase_crossover: float
    phase_margin_deg: float
    gain_margin: float
    Ms: float
    peak_frequency: float
    stable: bool


def open_loop(process: Process | Mapping[str, Any], gains: Gains, form: str = "PI") -> OpenLoop:
    """Regulator times process; where the loop would not fall off at high frequencies, Td is filtered by Td/10.

    `process` may be its kind and keys, as `make_process` takes them.
    """
    process = make_process(process)
    Kc, Ti, Td = gains
    if form == "I":
        num, den = np.array([Kc]), np.array([Ti, 0.0])
    elif math.isinf(Ti):
        num, den = np.array([Kc * Td, Kc]), np.ones(1)
    else:
        num, den = Kc * np.array([Ti * Td, Ti, 1.0]), np.array([Ti, 0.0])
    num, top = np.trim_zeros(num, "f"), np.polymul(np.trim_zeros(num, "f"), process.num)
    bottom = np.polymul(den, process.den)
    if Td > 0.0 and len(top) >= len(bottom):
        lag = Td / DERIVATIVE_FILTER
        # P and I keep their part, D gets the filter: Kc (1 + 1/(s Ti) + s Td/(1 + s lag))
        steady = np.array([Kc]) if math.isinf(Ti) else Kc * np.array([Ti, 1.0])
        num = np.polyadd(np.polymul(steady, [lag, 1.0]), Kc * Td * np.polymul(den, [1.0, 0.0]))
        top, bottom = np.polymul(num, process.num), np.polymul(bottom, [lag, 1.0])
    return OpenLoop(top, bottom, process.dead_time)


def loop_figures(loop: OpenLoop) -> LoopFigures:
    """Margins, peak and stability of a loop whose poles lie on the left or at 0.

    Notes
    -----
    The frequency response is searched finely (also linearly where the dead time turns it), each crossing refined.
    Stable is what does not encircle -1 (Nyquist): 1 + L turns by a quarter for each integrator, and by no more.
    """
    w = _grid(loop)
    L = loop.response(w)
    size, phase = np.abs(L), np.unwrap(np.angle(L))
    integrators = _integrators(loop.den)
    sign = 0.0 if _steady(loop, integrators) > 0.0 else -math.pi
    phase += 2.0 * math.pi * round((sign - 0.5 * math.pi * integrators - phase[0]) / (2.0 * math.pi))
    crossings = [_root(lambda x: math.log(abs(loop.response(x))), w, k) for k in _changes(np.log(size))]
    margins = [(math.degrees(math.remainder(np.angle(-loop.response(x)), 2.0 * math.pi)), x) for x in crossings]
    turn = (phase + math.pi) / (2.0 * math.pi)
    near = sorted(_wraps(turn), key=lambda k: abs(math.log(size[k])))[:NEAREST]
    real = [_root(lambda x: float(np.imag(loop.response(x))), w, k) for k in near]
    gains = [(1.0 / float(abs(loop.response(x))), x) for x in real]
    phase_margin, crossover = min(margins, key=lambda m: abs(m[0]), default=(math.inf, math.nan))
    gain_margin, phase_crossover = min(gains, key=lambda g: abs(math.log(g[0])), default=(math.inf, math.nan))
    peak, at = _sensitivity(loop, w, L)
    around = np.unwrap(np.angle(1.0 + L))
    turned = around[-1] - around[0]
    begin = -0.5 * math.pi * integrators if integrators else 0.0
    stable = abs(turned + begin) < 2.0 and peak < 1e6 and (integrators == 0 or sign == 0.0)
    if (integrators == 0 and 1.0 + _steady(loop, 0) <= 0.0) or _at_infinity(loop) >= 1.0:
        stable = False
    return LoopFigures(crossover, phase_crossover, phase_margin, gain_margin, peak, at, stable)


def ultimate_gain(process: Process | Mapping[str, Any]) -> tuple[float, float]:
    """Gain from which the process swings under a P regulator, and the period, s.

    Raises
    ------
    OutOfLimits
        No gain makes it swing: its phase never reaches -180 deg.
    """
    process = make_process(process)
    first = _first_phase_crossing(open_loop(process, Gains(1.0), "P"))
    if math.isnan(first):
        raise OutOfLimits(
            "no gain makes this process swing: its phase never reaches -180 deg; rules of the ultimate gain do not fit"
        )
    return 1.0 / abs(complex(process.response(1j * first))), 2.0 * math.pi / first


def phase_crossings(process: Process, most: int = 10) -> tuple[Array, Array]:
    """Frequencies (n,), rad/s, at which the response is real, the lowest `most` and 0 last, and its values (n,).

    Without integrators 0 is one of them.
    """
    loop = open_loop(process, Gains(1.0), "P")
    w = _grid(loop)
    values = np.imag(loop.response(w))
    found = [_root(lambda x: float(np.imag(loop.response(x))), w, k) for k in _changes(values)[:most]]
    found = [x for x in found if abs(loop.response(x)) > 1e-9 * abs(loop.response(w[0]))]
    if not _integrators(loop.den):
        found.append(0.0)
    at = np.array(found)
    return at, np.real(loop.response(at)) if len(at) else at


def _first_phase_crossing(loop: OpenLoop) -> float:
    w = _grid(loop)
    phase = np.unwrap(np.angle(loop.response(w)))
    phase += 2.0 * math.pi * round((-0.5 * math.pi * _integrators(loop.den) - phase[0]) / (2.0 * math.pi))
    below = np.flatnonzero((phase[:-1] > -math.pi) & (phase[1:] <= -math.pi))
    if not len(below):
        return math.nan
    return _root(lambda x: float(np.imag(loop.response(x))), w, int(below[0]))


def _grid(loop: OpenLoop) -> Array:
    """Frequencies, rad/s: five decades around every corner, and finely where the dead time turns the phase."""
    corners = [abs(x) for p in (loop.num, loop.den) for x in np.roots(p) if abs(x) > 0.0]
    gain = abs(loop.num[-1]) / (abs(loop.den[np.flatnonzero(loop.den)[-1]]) or 1.0)
    n = _integrators(loop.den)
    if n:
        corners.append(gain ** (1.0 / n))
    if loop.dead_time > 0.0:
        corners += [0.1 / loop.dead_time, 10.0 / loop.dead_time]
    low, high = (min(corners), max(corners)) if corners else (1.0, 1.0)
    rough = [np.geomspace(1e-3 * low, 1e3 * high, 6000)]
    for p in (loop.num, loop.den):  # a resonance is as narrow as its damping
        for root in np.roots(p):
            if 0.0 < -root.real < 0.3 * abs(root.imag):
                rough.append(abs(root.imag) + abs(root.real) * np.linspace(-20.0, 20.0, 401))
    if loop.dead_time > 0.0:
        size = np.abs(loop.response(rough[0]))
        large = rough[0][size > 0.02]
        end = min(float(large[-1]) if len(large) else 0.0, 3000.0 / loop.dead_time)
        rough.append(np.arange(0.05 / loop.dead_time, max(end, 30.0 / loop.dead_time), 0.05 / loop.dead_time))
    w = np.unique(np.concatenate(rough))
    return w[w > 0.0]


def _integrators(den: Array) -> int:
    return len(den) - 1 - int(np.flatnonzero(den)[-1])


def _steady(loop: OpenLoop, integrators: int) -> float:
    return float(loop.num[-1] / loop.den[len(loop.den) - 1 - integrators])


def _at_infinity(loop: OpenLoop) -> float:
    return abs(float(loop.num[0] / loop.den[0])) if len(loop.num) == len(loop.den) else 0.0


def _changes(values: Array) -> list[int]:
    found: list[int] = np.flatnonzero(np.signbit(values[:-1]) != np.signbit(values[1:])).tolist()
    return found


def _wraps(turn: Array) -> list[int]:
    """Where a phase in turns goes through a whole number, either way."""
    found: list[int] = np.flatnonzero(np.floor(turn[:-1]) != np.floor(turn[1:])).tolist()
    return found


def _root(function: Callable[[float], float], w: Array, k: int) -> float:
    from scipy.optimize import brentq  # heavy: on first use

    a, b = float(w[k]), float(w[k + 1])
    if function(a) * function(b) >= 0.0:
        return a if abs(function(a)) < abs(function(b)) else b
    return float(brentq(function, a, b, xtol=1e-14 * b, rtol=1e-14))


def _sensitivity(loop: OpenLoop, w: Array, L: Array) -> tuple[float, float]:
    from scipy.optimize import minimize_scalar  # heavy: on first use

    distance = np.abs(1.0 + L)
    k = int(np.argmin(distance))
    if 0 < k < len(w) - 1:
        found = minimize_scalar(
            lambda x: abs(1.0 + loop.response(math.exp(x))), bounds=(math.log(w[k - 1]), math.log(w[k + 1])),
            method="bounded", options={"xatol": 1e-10},
        )  # fmt: skip
        least, at = min((float(found.fun), math.exp(found.x)), (float(distance[k]), float(w[k])))
    else:
        least, at = float(distance[k]), float(w[k])
    return (max(1.0 / least, 1.0) if least > 0.0 else math.inf), at  # 1 is its limit at high frequencies
