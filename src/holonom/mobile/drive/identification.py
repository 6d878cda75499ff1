"""What a wheel's drive is, from recorded voltages and angles: `V = kS sign(w) + kV w + kA wd`.

Neither speed nor acceleration is differentiated out of an encoder: both sides are multiplied by windows g that vanish
with their first derivative at both ends, and integrated, which moves the derivatives on to the windows (modulating
functions: Shinbrot 1957; Preisig & Rippin, Computers and Chemical Engineering 17, 1993):

    int g V dt = kS int g sign(w) dt - kV int g' phi dt + kA int g'' phi dt

Windows lie where the wheel turns one way. Noise of the angle then has a known share in each equation, and equations
that overlap are weighed by the covariance that follows (generalised least squares).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array
from holonom.errors import CalibrationError, OutOfLimits, ShapeError

__all__ = ["DriveConstants", "Estimate", "MotorConstants", "identify_drive", "mechanics_of"]


SPAN = 0.4  # s of a window, unless the turning is shorter
LEAST = 24  # samples of a window
OVERLAP = 4  # windows over each moment
SLOW = 0.02  # share of the fastest speed below which a wheel may stand
FEWEST = 6  # windows that tell three numbers
STEADY = 1e-6  # change of speed over a window, share of it, that is none
OPEN = 0.3  # standard deviation over the number above which it is left open


class Estimate(NamedTuple):
    """A number and its standard deviation."""

    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class DriveConstants:
    """Constants of one wheel's drive.

    Attributes
    ----------
    kS : V that static friction takes, at the motor.
    kV : V s/rad of the wheel, with back EMF and viscous friction.
    kA : V s^2/rad of the wheel.
    covariance : (3, 3) of the three.
    misfit : V, root mean square of what the windows leave.
    """

    kS: Estimate
    kV: Estimate
    kA: Estimate
    covariance: Array
    misfit: float


@dataclass(frozen=True, slots=True)
class MotorConstants:
    """What the motor's data sheet says.

    Attributes
    ----------
    resistance : of the armature, ohm.
    torque_constant : N m/A.
    back_emf_constant : V s/rad of the motor's shaft; the torque constant unless given.
    gear : motor turns per wheel turn.
    """

    resistance: float
    torque_constant: float
    back_emf_constant: float | None = None
    gear: float = 1.0

    def __post_init__(self) -> None:
        for name in ("resistance", "torque_constant", "back_emf_constant", "gear"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise OutOfLimits(f"{name} {value} came; a number above zero is allowed")


def identify_drive(
    time: ArrayLike, voltage: ArrayLike, *, angle: ArrayLike | None = None, speed: ArrayLike | None = None,
    loaded: bool = False,
) -> DriveConstants:  # fmt: skip
    """Identify the drive of one wheel from a slow ramp and a step of its voltage.

    Parameters
    ----------
    time : (N,) s.
    voltage : (N,) V, each held until the next sample.
    angle : (N,) of the wheel, rad, running on; or instead
    speed : (N,) rad/s.
    loaded : whether the floor and other wheels push it. What they push with is no noise: it lasts, and goes with the
        motion, so that no number of samples averages it out. Standard deviations then hold for the worst that a load
        of the size of the misfit can do.

    Raises
    ------
    CalibrationError
        A log without excitation: a wheel that stands, or whose speeds or accelerations leave a constant open; it says
        which, and what to record.
    ShapeError

    Notes
    -----
    The armature's inductance is left out; a current that settles in a few milliseconds does not show in the windows.
    """
    t, V = _row("time", time), _row("voltage", voltage)
    if (angle is None) == (speed is None):
        raise CalibrationError("give either the wheel's angle or its speed")
    signal = _row("angle" if speed is None else "speed", angle if speed is None else speed)
    if not (len(t) == len(V) == len(signal)) or len(t) < LEAST or not np.all(np.diff(t) > 0.0):
        raise ShapeError(
            f"{len(t)} times, {len(V)} voltages, {len(signal)} angles or speeds came; give as many of each, {LEAST} or "
            "more, of time that grows"
        )
    edges, sense = _turning(t, signal, speed is not None)
    rows, right, weights = _equations(t, V, signal, edges, sense, by_angle=speed is None)
    if len(rows) < FEWEST:
        raise CalibrationError(
            f"it turns steadily for {len(rows)} windows of {SPAN:g} s, {FEWEST} are needed: record a slow ramp of the "
            "voltage and a step, both long enough to turn"
        )
    return _fitted(rows, right, weights, loaded=loaded)


def mechanics_of(drive: DriveConstants, motor: MotorConstants) -> Mapping[str, Estimate]:
    """Static friction (N m), viscous friction (N m s/rad) and inertia (kg m^2) at the wheel, by a motor's data sheet.

    With `V = R i + k_e N w` and `k_t N i = J wd + b w + c sign(w)`: `c = kS k_t N / R`, `J = kA k_t N / R`,
    `b = (kV - k_e N) k_t N / R`.
    """
    per = motor.torque_constant * motor.gear / motor.resistance
    emf = (motor.torque_constant if motor.back_emf_constant is None else motor.back_emf_constant) * motor.gear
    return {
        "static_friction": Estimate(drive.kS.value * per, drive.kS.sigma * per),
        "viscous_friction": Estimate((drive.kV.value - emf) * per, drive.kV.sigma * per),
        "inertia": Estimate(drive.kA.value * per, drive.kA.sigma * per),
    }


def _row(name: str, values: ArrayLike | None) -> Array:
    try:
        row = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        row = np.full((0, 0), np.nan)
    if row.ndim != 1 or not np.all(np.isfinite(row)):
        raise ShapeError(f"{name} has shape {row.shape}; give a row of finite numbers")
    return row


def _turning(t: Array, signal: Array, is_speed: bool) -> tuple[list[tuple[int, int]], list[float]]:
    """Stretches of samples, first and last, in which the wheel turns one way, and which."""
    span = max(SPAN, LEAST * float(np.median(np.diff(t))))
    half = max(2, int(np.searchsorted(t - t[0], 0.125 * span)))
    at = np.arange(len(t))
    a, b = np.maximum(at - half, 0), np.minimum(at + half, len(t) - 1)
    if is_speed:
        sums = np.concatenate([[0.0], np.cumsum(signal)])
        speed = (sums[b + 1] - sums[a]) / (b + 1 - a)
    else:
        speed = (signal[b] - signal[a]) / (t[b] - t[a])
    fastest = float(np.abs(speed).max())
    if fastest == 0.0:
        raise CalibrationError(
            "it never turns: record a slow ramp of the voltage and a step, beyond its static friction"
        )
    sign = np.sign(speed) * (np.abs(speed) > SLOW * fastest)
    edges = [0, *(np.flatnonzero(np.diff(sign)) + 1).tolist(), len(t)]
    found, sense = [], []
    for first, last in pairwise(edges):
        inner = (first + half, last - 1 - half)
        if sign[first] != 0.0 and t[min(inner[1], len(t) - 1)] - t[inner[0] if inner[0] < len(t) else -1] > 0.5 * span:
            found.append(inner)
            sense.append(float(sign[first]))
    return found, sense


class _Window(NamedTuple):
    """Samples from `first` on, weights of the voltage (n - 1,), and of the signal for kV and kA (n,)."""

    first: int
    by_voltage: Array
    by_speed: Array
    by_acceleration: Array


def _equations(
    t: Array, V: Array, signal: Array, edges: list[tuple[int, int]], sense: list[float], *, by_angle: bool
) -> tuple[Array, Array, list[_Window]]:
    rows, right, windows = [], [], []
    span = max(SPAN, LEAST * float(np.median(np.diff(t))))
    for (first, last), sign in zip(edges, sense, strict=True):
        T = min(span, float(t[last] - t[first]))
        for start in np.arange(t[first], t[last] - T + 1e-9 * T, T / OVERLAP):
            a = int(np.searchsorted(t, start - 1e-12))
            b = min(int(np.searchsorted(t, start + T + 1e-12)), last + 1)
            if b - a < LEAST // 2:
                continue
            window = _window(a, t[a:b], by_angle=by_angle)
            part = signal[a:b] - (signal[a] if by_angle else 0.0)
            rows.append([sign * window.by_voltage.sum(), window.by_speed @ part, window.by_acceleration @ part])
            right.append(window.by_voltage @ V[a : b - 1])
            windows.append(window)
    return np.array(rows).reshape(-1, 3), np.array(right), windows


def _window(first: int, t: Array, *, by_angle: bool) -> _Window:
    """`g = sin^4(pi (t - a)/T)` with its derivatives; the voltage held between samples, the signal by trapezoids.

    Three derivatives vanish at the ends, so that trapezoids are of fourth order.
    """
    u, T = np.pi * (t - t[0]) / (t[-1] - t[0]), float(t[-1] - t[0])
    rate = np.pi / T
    area = 0.375 * t - np.sin(2.0 * u) / (4.0 * rate) + np.sin(4.0 * u) / (32.0 * rate)
    s, c = np.sin(u), np.cos(u)
    share = np.gradient(t)
    share[[0, -1]] *= 0.5
    g, slope, bend = s**4, 4.0 * rate * s**3 * c, 4.0 * rate**2 * (3.0 * s**2 * c**2 - s**4)
    if by_angle:
        return _Window(first, np.diff(area), -slope * share, bend * share)
    return _Window(first, np.diff(area), g * share, -slope * share)


def _fitted(rows: Array, right: Array, windows: list[_Window], *, loaded: bool) -> DriveConstants:
    size: Array = np.asarray(np.linalg.norm(rows, axis=0), dtype=np.float64)
    if np.any(size == 0.0):
        raise CalibrationError("its speed never changes: record a slow ramp of the voltage and a step")
    k = np.linalg.lstsq(rows / size, right, rcond=None)[0] / size
    root = np.eye(len(rows))
    for _ in range(3):  # noise of the angle goes through the constants themselves
        root = _whitener(windows, k)
        A, b = root @ rows, root @ right
        size = np.asarray(np.linalg.norm(A, axis=0), dtype=np.float64)
        k = np.linalg.lstsq(A / size, b, rcond=None)[0] / size
    left = b - A @ k
    variance = float(left @ left) / (len(b) - 3)
    inverse = np.linalg.pinv(A.T @ A / np.outer(size, size), rcond=1e-14, hermitian=True)
    covariance = np.asarray(variance * inverse / np.outer(size, size), dtype=np.float64)
    _check_open(k, covariance, np.asarray(A / size), size)
    area = np.array([window.by_voltage.sum() for window in windows])
    misfit = float(np.sqrt((((right - rows @ k) / area) ** 2).mean()))
    if loaded:
        worst = misfit * np.abs(inverse / np.outer(size, size) @ A.T @ root * area).sum(axis=1)
        grown = np.sqrt(1.0 + worst**2 / np.diagonal(covariance))
        covariance = covariance * np.outer(grown, grown)
    sigma = np.sqrt(np.diagonal(covariance))
    kS, kV, kA = (Estimate(float(v), float(s)) for v, s in zip(k, sigma, strict=True))
    return DriveConstants(kS, kV, kA, covariance, misfit)


def _whitener(windows: list[_Window], k: Array) -> Array:
    """L^-1 for the covariance L L^T of the equations, from white noise of the signal's samples."""
    n = len(windows)
    weights = [k[1] * w.by_speed + k[2] * w.by_acceleration for w in windows]
    cov = np.zeros((n, n))
    order: NDArray[np.intp] = np.argsort([w.first for w in windows])
    for p, i in enumerate(order):
        a = windows[i].first
        for j in order[p : p + 3 * OVERLAP]:
            c = windows[j].first
            shared = min(a + len(weights[i]), c + len(weights[j])) - c
            if shared > 0:
                cov[i, j] = cov[j, i] = weights[i][c - a : c - a + shared] @ weights[j][:shared]
    cov += 1e-3 * np.diag(np.diagonal(cov)) + 1e-300 * np.eye(n)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(cov)))


def _check_open(k: Array, covariance: Array, A: Array, size: Array) -> None:
    """Refuse constants that the motion leaves open."""
    s = np.linalg.svd(A, compute_uv=False)
    sigma = np.sqrt(np.diagonal(covariance))
    wide = [name for name, v, d in zip(("kS", "kV", "kA"), k, sigma, strict=True) if d > OPEN * max(abs(v), 1e-12)]
    wide = [name for name in wide if name != "kS" or sigma[0] > OPEN * max(abs(k[0]), 0.1 * float(np.abs(k[1])))]
    if SPAN * size[2] < STEADY * size[1] and "kA" not in wide:
        wide.append("kA")
    if s[-1] < STEADY * s[0] or wide:
        named = ", ".join(wide) or "kS, kV and kA apart"
        raise CalibrationError(f"its motion does not tell {named}: record a slow ramp of the voltage, and a step")
