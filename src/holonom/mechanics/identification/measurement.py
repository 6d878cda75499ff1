"""From a recorded motion to equations: zero-phase filtering, differentiation, thinning out (Gautier 1997)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import butter, sosfiltfilt

from holonom.arrays import Array, finite_array
from holonom.errors import InputError, ShapeError

__all__ = ["Equations", "equations_of", "state"]


ORDER = 4  # of the Butterworth filter, run forwards and backwards
AT_REST = 0.01  # of a joint's largest speed: below, the direction of its friction is not known


@dataclass(frozen=True, slots=True)
class Equations:
    """Filtered samples: Y (N, n, b), tau (N, n) less what is known of it, and which joints move clearly (N, n).

    `noise` (n,) is the standard deviation that the torques' white noise has in `tau`.
    """

    Y: Array
    tau: Array
    moving: NDArray[np.bool_]
    noise: Array


def state(time: ArrayLike, q: ArrayLike, cutoff: float) -> tuple[float, Array, Array, Array]:
    """Sample time, and q, qd, qdd (N, n) by a zero-phase Butterworth filter and central differences.

    Parameters
    ----------
    time : (N,) s, even steps.
    q : (N, n) rad or m.
    cutoff : Hz.

    Raises
    ------
    ShapeError
        Shapes that do not go together, NaN, or too few samples.
    InputError
        Uneven times, or a cutoff above a quarter of the sampling rate.
    """
    t, raw = finite_array("time", time, ("samples",)), finite_array("q", q, ("samples", "joints"))
    if len(t) != len(raw) or len(t) < 30:
        raise ShapeError(f"time has {len(t)} samples and q {len(raw)}; give the same number of both, at least 30")
    steps = np.diff(t)
    dt = float(np.median(steps))
    if dt <= 0.0 or np.abs(steps - dt).max() > 0.01 * dt:
        k = int(np.abs(steps - dt).argmax())
        raise InputError(f"time goes from {t[k]} to {t[k + 1]} s where its step is {dt:.6g} s; give even steps")
    if not 0.0 < cutoff <= 0.25 / dt:
        raise InputError(f"cutoff = {cutoff} Hz; give one above 0 and up to {0.25 / dt:g} (a quarter of the rate)")
    smooth = _low_pass(raw, cutoff, dt)
    qd = np.gradient(smooth, dt, axis=0)
    return dt, smooth, qd, np.gradient(qd, dt, axis=0)


def equations_of(
    n: int,
    rows: Callable[[Array, Array, Array], Array],
    time: ArrayLike,
    q: ArrayLike,
    tau: ArrayLike,
    cutoff: float,
) -> Equations:
    """Equations Y beta = tau of n joints from a record; both sides go through one filter, so it distorts nothing.

    The last of the columns that `rows` gives is the part of the torque that is known.

    One sample per half period of the cutoff is kept, as many as carry independent noise; the first and last periods,
    which the filter spoils, go.
    """
    torque = finite_array("tau", tau, ("samples", "joints"))
    if torque.shape != np.shape(q) or torque.shape[1] != n:
        raise ShapeError(f"q has shape {np.shape(q)}, tau {torque.shape}; ({len(torque)}, {n}) of both is needed")
    dt, smooth, qd, qdd = state(time, q, cutoff)
    period = max(1, round(1.0 / (cutoff * dt)))
    keep = slice(period, -period, max(1, period // 2))
    Y = rows(smooth, qd, qdd)
    filtered = _low_pass(Y.reshape(len(Y), -1), cutoff, dt)[keep].reshape(-1, n, Y.shape[-1])
    if len(filtered) * n < Y.shape[-1]:
        raise InputError(
            f"{len(torque)} samples at {dt:g} s hold {len(filtered)} independent ones below {cutoff:g} Hz; record more"
        )
    speed = np.abs(qd)
    smooth_torque = _low_pass(torque, cutoff, dt)
    rest = smooth_torque[keep] - filtered[..., -1]
    noise = _noise_below((torque - smooth_torque)[period:-period], cutoff, dt)
    return Equations(filtered[..., :-1], rest, (speed > AT_REST * speed.max(0))[keep], noise)


def _noise_below(above: Array, cutoff: float, dt: float) -> Array:
    """Standard deviation of white noise below the cutoff, from what the filter has taken away of it."""
    impulse = np.zeros((8 * max(1, round(1.0 / (cutoff * dt))) + 1, 1))
    impulse[len(impulse) // 2] = 1.0
    kept = _low_pass(impulse, cutoff, dt)
    gain = np.sqrt(np.sum(kept**2) / np.sum((impulse - kept) ** 2))
    return np.asarray(gain * np.sqrt(np.mean(above**2, axis=0)))


def _low_pass(x: Array, cutoff: float, dt: float) -> Array:
    sections = butter(ORDER, 2.0 * cutoff * dt, output="sos")
    return np.asarray(sosfiltfilt(sections, x, axis=0))
