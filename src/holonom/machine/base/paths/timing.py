"""Reference paths in time: limits, the largest speed within them over the way, and when the base is where."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import OutOfLimits

__all__ = ["GRID", "TICK", "PathLimits", "ReferencePath", "in_time", "squared_speeds"]

TICK = 1e-3
GRID = 4000  # points at which the speed is planned


@dataclass(frozen=True, slots=True)
class ReferencePath:
    """A motion at 1 kHz.

    Attributes
    ----------
    time
        (N,) s.
    pose
        (N, 3) x, y, theta in the world; theta does not wrap.
    twist
        (N, 3) vx, vy, w in the base_link of that pose.
    acceleration
        (N, 3): acceleration of the centre in the axes of that base_link (m/s^2), and of the heading (rad/s^2).
    """

    time: Array
    pose: Array
    twist: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class PathLimits:
    """How fast a path is driven: speed (m/s), acceleration along and across together (m/s^2), s in which it comes on.

    Raises
    ------
    OutOfLimits
        A number that is not positive.
    """

    speed: float = 1.5
    acceleration: float = 2.0
    rise_time: float = 0.1

    def __post_init__(self) -> None:
        for name in ("speed", "acceleration", "rise_time"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise OutOfLimits(f"PathLimits: {name} is {value!r}; it must be finite and greater than 0")


def squared_speeds(s: Array, curvature: Array, limits: PathLimits) -> Array:
    """Squared speed at each s, from rest to rest."""
    k = np.abs(curvature)
    most = np.minimum(limits.speed**2, limits.acceleration / np.maximum(k, 1e-9))
    most[[0, -1]] = 0.0
    for order in (range(1, len(s)), range(len(s) - 2, -1, -1)):
        step = 1 if order.step == 1 else -1
        for i in order:
            before = most[i - step]
            left = math.sqrt(max(limits.acceleration**2 - (before * k[i - step]) ** 2, 0.0))
            most[i] = min(most[i], before + 2.0 * left * abs(s[i] - s[i - step]))
    return most


def in_time(s: Array, square: Array, rise: float, rest: float) -> tuple[Array, Array, Array]:
    """Distance, speed and acceleration along the way at 1 kHz, smoothed, resting at both ends."""
    from scipy.ndimage import uniform_filter1d  # heavy: on first use

    v = np.sqrt(square)
    t = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (v[1:] + v[:-1]))])
    window = max(round(rise / TICK), 1)
    pad = round(rest / TICK) + window
    n = math.ceil(t[-1] / TICK) + 1
    speed = np.pad(np.interp(TICK * np.arange(n), t, v, right=0.0), pad)
    for _ in range(2):
        speed = uniform_filter1d(speed, window, mode="constant")
    distance = np.concatenate([[0.0], np.cumsum(0.5 * TICK * (speed[1:] + speed[:-1]))])
    scale = s[-1] / distance[-1]
    return scale * distance, scale * speed, np.gradient(scale * speed, TICK)
