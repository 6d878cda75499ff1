"""A sampled joint path and the limits it keeps: data, and the checks every planner shares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import MotionError, NotFinite, OutOfLimits, ShapeError
from holonom.model import outside

__all__ = [
    "MOST_SAMPLES",
    "STILL",
    "JointLimits",
    "Trajectory",
    "check_count",
    "check_inside",
    "joint_vector",
    "remainder",
    "standstill",
]


STILL = 1e-12  # shorter motions (rad, m) are none
MOST_SAMPLES = 20_000_000  # of a trajectory that is held at once


class JointLimits(Protocol):
    """Limits of n joints, each (n,): positions (rad or m), speed (1/s), acceleration (1/s^2); and their names."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints, for messages."""

    @property
    def lower(self) -> Array:
        """Lowest positions."""

    @property
    def upper(self) -> Array:
        """Highest positions."""

    @property
    def speed(self) -> Array:
        """Largest speeds, positive."""

    @property
    def acceleration(self) -> Array:
        """Largest accelerations, positive."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A joint motion sampled every `dt`, whatever shape it came from; at rest at its end.

    Attributes
    ----------
    dt
        Time between samples (s).
    q, qd, qdd
        Positions (rad or m), speeds and accelerations, each (N, n), N >= 1.
    line
        Source line of the last segment.
    begin
        Index at which the last segment begins; the samples before belong to earlier ones.
    brake
        Index at which the last segment begins to brake: a next one may overlap from here on.
    """

    dt: float
    q: Array
    qd: Array
    qdd: Array
    line: int = 0
    begin: int = 0
    brake: int = 0

    @property
    def duration(self) -> float:
        """Time from the first to the last sample (s)."""
        return float((self.q.shape[0] - 1) * self.dt)


def standstill(q: Array, dt: float, line: int) -> Trajectory:
    """Trajectory of the single sample `q` (n,), at rest."""
    rest = np.zeros((1, q.shape[0]))
    return Trajectory(dt, q[None, :].copy(), rest, rest.copy(), line)


def joint_vector(name: str, value: ArrayLike, n: int) -> Array:
    """`value` as finite floats of shape (n,).

    Raises
    ------
    ShapeError
        Another shape, or values that are not finite.
    """
    vector = real_array(name, value)
    if vector.shape != (n,):
        raise ShapeError(f"{name} has shape {vector.shape}; the arm has {n} joints, give shape ({n},)")
    if not np.isfinite(vector).all():
        k = int(np.argmin(np.isfinite(vector)))
        raise NotFinite(f"{name}[{k}] is {vector[k]} of {vector}; give finite joint positions")
    return vector


def check_inside(q: Array, limits: JointLimits) -> None:
    """Raise `OutOfLimits` where a position in `q` (n,) lies outside its limits."""
    beyond = outside(q, limits.lower, limits.upper)
    if beyond.any():
        j = int(np.argmax(beyond))
        raise OutOfLimits(
            f"{limits.names[j]} is to go to {q[j]:.6g}; "
            f"its limits are {limits.lower[j]:.6g} to {limits.upper[j]:.6g} (rad or m)"
        )


def check_count(duration: float, dt: float) -> None:
    """Refuse a motion of more samples than can be held, before they are made.

    Raises
    ------
    MotionError
    """
    if not duration / dt <= MOST_SAMPLES:
        raise MotionError(
            f"the motion lasts {duration:.6g} s, more than {MOST_SAMPLES} samples of {dt:g} s; give a longer dt="
        )


def remainder(current: Trajectory, consumed: int) -> Trajectory:
    """What is left of a trajectory after `consumed` samples, at least its last one.

    Raises
    ------
    MotionError
        A `consumed` outside 0 to N.
    """
    count = current.q.shape[0]
    if not 0 <= consumed <= count:
        raise MotionError(f"{consumed} samples consumed of a trajectory of {count}; give 0 to {count}")
    k = min(consumed, count - 1)
    return Trajectory(
        current.dt,
        current.q[k:],
        current.qd[k:],
        current.qdd[k:],
        current.line,
        begin=max(current.begin - k, 0),
        brake=max(current.brake - k, 0),
    )
