"""Samples that odometry should not be trusted with: gaps in time, wheels that disagree, motion that cannot be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.errors import LogError, OutOfLimits, ShapeError
from holonom.mobile.odometry.integrate import increments_of

__all__ = ["Flags", "find_gaps", "flag"]

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Flags:
    """What was found, each (N,): `gap` before the sample, wheels that `slip`, speed or acceleration `implausible`."""

    gap: Mask
    slip: Mask
    implausible: Mask

    @property
    def any(self) -> Mask:
        """(N,) samples with any of the three."""
        return self.gap | self.slip | self.implausible


def find_gaps(time: ArrayLike, factor: float = 2.5) -> Mask:
    """Samples (N,) before which the clock stood still for the log: a step above `factor` times the median one.

    Raises
    ------
    LogError
        Time that does not increase.
    OutOfLimits
        A factor that is not above 1.
    """
    if not factor > 1.0:
        raise OutOfLimits(f"a factor of {factor} came; one above 1 is allowed")
    t = np.asarray(time, dtype=np.float64)
    steps = np.diff(t)
    if t.ndim != 1 or not np.all(steps > 0.0):
        at = int(np.argmin(steps > 0.0)) + 1 if t.ndim == 1 else 0
        raise LogError(f"time does not increase at sample {at}; sort the log, or cut it there")
    gap = np.zeros(len(t), dtype=np.bool_)
    if len(steps):
        gap[1:] = steps > factor * np.median(steps)
    return gap


def flag(
    time: ArrayLike,
    increments: ArrayLike,
    *,
    residual: ArrayLike | None = None,
    max_residual: float = np.inf,
    max_speed: float = np.inf,
    max_turn_rate: float = np.inf,
    max_acceleration: float = np.inf,
    gap_factor: float = 2.5,
) -> Flags:
    """Flag samples of a log.

    Parameters
    ----------
    time : (N,) s.
    increments : (N, 3) of the base in each sample, m and rad.
    residual : (N, m)
        Rim speeds that no twist explains, m/s: `base.residual(speeds)`, for bases with more wheels than freedoms.
    max_residual, max_speed, max_turn_rate, max_acceleration : m/s, m/s, rad/s, m/s^2; without them nothing is flagged.
    gap_factor : a step of time that many times the median one is a gap.

    Raises
    ------
    ShapeError, LogError, OutOfLimits
    """
    t, rows = np.asarray(time, dtype=np.float64), increments_of(increments)
    gap = find_gaps(t, gap_factor)
    if len(t) != len(rows):
        raise ShapeError(f"{len(t)} times for {len(rows)} increments; give one each")
    dt = np.diff(t, prepend=t[0] - np.median(np.diff(t))) if len(t) > 1 else np.ones(len(t))
    twist = rows / dt[:, None]
    speed = np.hypot(twist[:, 0], twist[:, 1])
    change = np.diff(twist[:, :2], axis=0, prepend=twist[:1, :2])
    acceleration = np.hypot(change[:, 0], change[:, 1]) / dt
    odd = (speed > max_speed) | (np.abs(twist[:, 2]) > max_turn_rate) | (acceleration > max_acceleration)
    return Flags(gap, _slipping(residual, max_residual, len(rows)), odd)


def _slipping(residual: ArrayLike | None, bound: float, count: int) -> Mask:
    if residual is None:
        return np.zeros(count, dtype=np.bool_)
    rims = np.asarray(residual, dtype=np.float64)
    if rims.ndim != 2 or len(rims) != count:
        raise ShapeError(f"residuals have shape {rims.shape}; give ({count}, wheels), m/s")
    return np.asarray(np.max(np.abs(rims), axis=1) > bound)
