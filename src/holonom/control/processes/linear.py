"""Linear systems: exact time responses, and what a step response looks like."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from holonom.arrays import Array, finite_array
from holonom.control.processes.kernels import ramped_response
from holonom.errors import ModelError, OutOfLimits

__all__ = [
    "LinearSystem",
    "StepInfo",
    "impulse_response",
    "initial_response",
    "linear_system",
    "ramp_matrices",
    "steady_gain",
    "step_info",
    "step_response",
]


@dataclass(frozen=True, slots=True)
class LinearSystem:
    """`x' = A x + B u, y = C x + D u`, or sampled every dt s: `x_(k+1) = A x_k + B u_k`.

    Attributes
    ----------
    A, B, C, D
        (n, n), (n, m), (p, n), (p, m).
    dt
        s; None for continuous time.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    dt: float | None = None


@dataclass(frozen=True, slots=True)
class StepInfo:
    """What a step response looks like.

    Attributes
    ----------
    rise_time, settling_time, peak_time
        s: from 10 to 90 % of the final value; until it stays within the band; of the largest size.
    settling_min, settling_max
        Extremes after 90 % have been reached.
    overshoot, undershoot
        % of the final value: beyond it; the other way.
    peak, steady_state
        Largest size, final value.
    """

    rise_time: float
    settling_time: float
    settling_min: float
    settling_max: float
    overshoot: float
    undershoot: float
    peak: float
    peak_time: float
    steady_state: float


def linear_system(
    *, num: Any = None, den: Any = None, A: Any = None, B: Any = None, C: Any = None, D: Any = None,
    dt: float | None = None,
) -> LinearSystem:  # fmt: skip
    """Return a system from numerator and denominator (falling powers of s or z), or from its matrices.

    Raises
    ------
    ModelError
        Neither came whole, it is not proper, shapes do not fit.
    ShapeError, OutOfLimits
        Not finite; a sample time that is not positive.
    """
    from scipy import signal  # heavy: on first use

    if dt is not None and not 0.0 < dt < math.inf:
        raise OutOfLimits(f"dt is {dt!r}; a sample time must be finite and greater than 0 s")
    if num is not None and den is not None:
        num, den = finite_array("num", num, ("N",)), finite_array("den", den, ("N",))
        if len(np.trim_zeros(num, "f")) > len(np.trim_zeros(den, "f")):
            raise ModelError(f"system: num {num.tolist()} is of higher degree than den {den.tolist()}: not proper")
        with np.errstate(all="ignore"):
            A, B, C, D = signal.tf2ss(np.trim_zeros(num, "f"), np.trim_zeros(den, "f"))
    elif any(part is None for part in (A, B, C, D)):
        raise ModelError("system: num and den, or A, B, C and D are needed")
    found = [finite_array(name, part, ("n", "m")) for name, part in (("A", A), ("B", B), ("C", C), ("D", D))]
    A, B, C, D = found
    if not (A.shape[0] == A.shape[1] == B.shape[0] == C.shape[1] and D.shape == (C.shape[0], B.shape[1])):
        shapes = ", ".join(f"{name} {part.shape}" for name, part in zip("ABCD", found, strict=True))
        raise ModelError(f"system: {shapes} do not fit; (n, n), (n, m), (p, n), (p, m) are needed")
    return LinearSystem(A, B, C, D, dt)


def ramp_matrices(A: Array, B: Array, h: float) -> tuple[Array, Array, Array]:
    """Matrices of an exact step h, s, for an input (n,) that goes straight from one sample to the next."""
    from scipy import linalg  # heavy: on first use

    n = len(A)
    block = np.zeros((n + 2, n + 2))
    block[:n, :n], block[:n, n], block[n, n + 1] = A * h, B * h, 1.0
    whole = linalg.expm(block)
    ramp = whole[:n, n + 1]
    return np.ascontiguousarray(whole[:n, :n]), whole[:n, n] - ramp, np.ascontiguousarray(ramp)


def step_response(system: LinearSystem, t: Any = None, *, input: int = 0, output: int = 0) -> tuple[Array, Array]:
    """Times (N,), s, and output (N,) after a step of one input at 0.

    Parameters
    ----------
    system
        Its poles may lie anywhere where `t` is given.
    t
        Evenly spaced times from 0, s; None: until it has settled, finely. Sampled systems: multiples of dt.
    input, output
        Which, from 0 on.

    Raises
    ------
    ModelError
        Without `t`: it does not settle.
    OutOfLimits
        Times that are not evenly spaced from 0.
    """
    times = _times(system) if t is None else _even(t, system.dt)
    return times, _run(system, np.ones(len(times)), np.zeros(len(system.A)), times, input, output)


def initial_response(system: LinearSystem, x0: Any, t: Any, *, output: int = 0) -> tuple[Array, Array]:
    """Times (N,), s, and output (N,) from a state (n,) without input; errors as `step_response`."""
    times = _even(t, system.dt)
    x = finite_array("x0", x0, (len(system.A),))
    return times, _run(system, np.zeros(len(times)), x, times, 0, output)


def impulse_response(system: LinearSystem, t: Any, *, input: int = 0, output: int = 0) -> tuple[Array, Array]:
    """Times (N,), s, and output (N,) after an impulse; of D u only what follows it. Errors as `step_response`."""
    times = _even(t, system.dt)
    if system.dt is not None:
        pulse = np.zeros(len(times))
        pulse[0] = 1.0 / system.dt
        return times, _run(system, pulse, np.zeros(len(system.A)), times, input, output)
    return times, _run(system, np.zeros(len(times)), system.B[:, input], times, input, output)


def steady_gain(system: LinearSystem, *, input: int = 0, output: int = 0) -> float:
    """Return what one output comes to at rest per unit of one input; of a system that settles."""
    at = np.eye(len(system.A)) - system.A if system.dt is not None else -system.A
    rest = np.linalg.solve(at, system.B[:, input]) if len(at) else np.zeros(0)
    return float(system.C[output] @ rest + system.D[output, input])


def step_info(
    t: Any, y: Any, *, band: float = 0.02, steady_state: float | None = None, sampled: bool = False
) -> StepInfo:
    """What a step response looks like.

    Parameters
    ----------
    t, y
        (N,), s and output, from the step on.
    band
        Part of the change, from the first to the final value, within which it counts as settled.
    steady_state
        Final value; None: the last one.
    sampled
        Whether the output is held between its samples; otherwise it goes straight from one to the next.

    Raises
    ------
    OutOfLimits
        A final value of 0, a band that is not positive.
    """
    t, y = finite_array("t", t, ("N",)), finite_array("y", y, (len(t),))
    final = float(y[-1]) if steady_state is None else float(steady_state)
    if final == 0.0 or not band > 0.0:
        raise OutOfLimits(f"step_info: final value {final!r}, band {band!r}; neither may be 0")
    z = y / final
    tenth, most = _first(t, z, 0.1, sampled), _first(t, z, 0.9, sampled)
    near = band * abs(1.0 - z[0])
    outside = np.flatnonzero(np.abs(z - 1.0) > near)
    settled = 0.0 if not len(outside) else _settled(t, z, int(outside[-1]), near, sampled)
    after = y[np.flatnonzero(z >= 0.9)[0] :]
    peak = int(np.argmax(np.abs(y)))
    return StepInfo(
        rise_time=most - tenth,
        settling_time=settled,
        settling_min=float(after.min()),
        settling_max=float(after.max()),
        overshoot=100.0 * max(float(z.max()) - 1.0, 0.0),
        undershoot=100.0 * max(-float(z.min()), 0.0) + 0.0,
        peak=abs(float(y[peak])),
        peak_time=float(t[peak]),
        steady_state=final,
    )


def _first(t: Array, z: Array, level: float, sampled: bool) -> float:
    k = int(np.argmax(z >= level))
    if not z[k] >= level:
        raise OutOfLimits(f"step_info: the response never reaches {level:g} of its final value; record it for longer")
    if k == 0 or sampled:
        return float(t[k])
    return float(t[k - 1] + (level - z[k - 1]) / (z[k] - z[k - 1]) * (t[k] - t[k - 1]))


def _settled(t: Array, z: Array, last: int, band: float, sampled: bool) -> float:
    if last + 1 >= len(t):
        return math.inf
    if sampled:
        return float(t[last + 1])
    edge = 1.0 + math.copysign(band, z[last] - 1.0)
    return float(t[last] + (edge - z[last]) / (z[last + 1] - z[last]) * (t[last + 1] - t[last]))


def _times(system: LinearSystem) -> Array:
    from scipy import linalg  # heavy: on first use

    poles = linalg.eigvals(system.A)
    if system.dt is not None:
        slowest = np.abs(poles).max(initial=0.0)
        if slowest >= 1.0:
            raise ModelError(f"system: a pole of size {slowest:.4g}: it does not settle; give the times t")
        steps = 20 if slowest == 0.0 else max(20, math.ceil(-12.0 / math.log(slowest)))
        return np.asarray(system.dt * np.arange(steps), dtype=np.float64)
    rates = -poles.real
    if len(rates) and rates.min() <= 0.0:
        raise ModelError(f"system: a pole at {poles[rates.argmin()]:.4g} 1/s: it does not settle; give the times t")
    end = 12.0 / rates.min() if len(rates) else 1.0
    fast = np.abs(poles).max(initial=1.0)
    return np.linspace(0.0, end, int(min(max(40.0 * end * fast, 20_000.0), 200_000.0)) + 1)


def _even(t: Any, dt: float | None) -> Array:
    times = finite_array("t", t, ("N",))
    h = times[1] - times[0] if len(times) > 1 else 1.0
    even = np.allclose(times, h * np.arange(len(times)), rtol=0.0, atol=1e-6 * h) and h > 0.0
    if not even or (dt is not None and abs(h - dt) > 1e-6 * dt):
        wanted = "evenly spaced from 0" if dt is None else f"multiples of {dt:g} s from 0"
        raise OutOfLimits(f"t begins {times[:3].tolist()}; times must be {wanted}")
    return times


def _run(system: LinearSystem, u: Array, x: Array, t: Array, input: int, output: int) -> Array:
    B = system.B[:, input]
    if system.dt is None:
        h = t[1] - t[0] if len(t) > 1 else 1.0
        A, B0, B1 = ramp_matrices(system.A, B, h)
    else:
        A, B0, B1 = system.A, B, np.zeros_like(B)
    row = np.ascontiguousarray(system.C[output])
    return ramped_response(np.ascontiguousarray(A), np.ascontiguousarray(B0), B1, row, system.D[output, input],
                           np.ascontiguousarray(x, dtype=float), u)  # fmt: skip
