"""A sampled joint path and the limits it keeps: data, and the checks every planner shares."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, final

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import MotionError, NotFinite, OutOfLimits, ShapeError
from holonom.model import joint_values, outside
from holonom.model.joint_values import looks_like_degrees, written

__all__ = [
    "MOST_SAMPLES",
    "STILL",
    "JointLimits",
    "Rows",
    "Table",
    "Trajectory",
    "check_count",
    "check_inside",
    "joined",
    "joint_vector",
    "limits_of",
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

    @property
    def turns(self) -> tuple[bool, ...]:
        """Of each joint whether it turns; the others slide."""


class Rows(Protocol):
    """Samples of a joint motion, made when they are asked for."""

    @property
    def count(self) -> int:
        """How many there are."""

    def take(self, first: int, last: int) -> Array:
        """Return samples `first` to `last`, that one not included: positions, speeds, accelerations (3, k, n)."""

    def after(self, number: int) -> Rows:
        """Return what is left from sample `number` on; what is over is forgotten."""


@dataclass(frozen=True, slots=True)
class Table:
    """Samples that are all there: `values` (3, N, n)."""

    values: Array

    @property
    def count(self) -> int:
        """How many there are."""
        return int(self.values.shape[1])

    def take(self, first: int, last: int) -> Array:
        """See `Rows`."""
        return self.values[:, first:last]

    def after(self, number: int) -> Rows:
        """See `Rows`."""
        return Table(self.values[:, number:])


@dataclass(frozen=True, slots=True)
class Overlapped:
    """`first`, and from its sample `start` on `second`, whose motion from `origin` (n,) is added over `lap` steps."""

    first: Rows
    second: Rows
    start: int
    lap: int
    origin: Array

    @property
    def count(self) -> int:
        """How many there are."""
        return self.start + self.second.count

    def take(self, first: int, last: int) -> Array:
        """See `Rows`."""
        last = min(last, self.count)
        alone, joined = min(last, self.start), min(last, self.start + self.lap + 1)
        parts = [self.first.take(first, alone)] if first < alone else []
        if max(first, self.start) < joined:
            at = max(first, self.start)
            added = self.second.take(at - self.start, joined - self.start).copy()
            added[0] -= self.origin
            parts.append(self.first.take(at, joined) + added)
        if max(first, joined) < last:
            parts.append(self.second.take(max(first, joined) - self.start, last - self.start))
        return np.concatenate(parts, axis=1)

    def after(self, number: int) -> Rows:
        """See `Rows`."""
        if number > self.start + self.lap:
            return self.second.after(number - self.start)
        into = max(number - self.start, 0)
        second = self.second.after(into) if into else self.second
        return Overlapped(self.first.after(number), second, max(self.start - number, 0), self.lap - into, self.origin)


@final
@dataclass(frozen=True, slots=True, init=False)
class Trajectory:
    """A joint motion with a sample every `dt`, whatever shape it came from; at rest at its end.

    Samples are made when they are asked for, so that a long motion takes no more memory than a short one: `take` gives
    some of them, `q`, `qd`, `qdd` all.

    Parameters
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
    rows: Rows
    line: int
    begin: int
    brake: int

    def __init__(
        self, dt: float, q: Array, qd: Array, qdd: Array, line: int = 0, begin: int = 0, brake: int = 0
    ) -> None:
        self._fill(dt, Table(np.stack([q, qd, qdd])), line, begin, brake)

    @classmethod
    def of(cls, dt: float, rows: Rows, line: int = 0, begin: int = 0, brake: int = 0) -> Trajectory:
        """Return the trajectory of samples that are made when they are asked for."""
        made = cls.__new__(cls)
        made._fill(dt, rows, line, begin, brake)
        return made

    def _fill(self, dt: float, rows: Rows, line: int, begin: int, brake: int) -> None:
        for name, value in (("dt", dt), ("rows", rows), ("line", line), ("begin", begin), ("brake", brake)):
            object.__setattr__(self, name, value)

    @property
    def count(self) -> int:
        """Number of samples, N."""
        return self.rows.count

    @property
    def duration(self) -> float:
        """Time from the first to the last sample (s)."""
        return float((self.count - 1) * self.dt)

    @property
    def end(self) -> Array:
        """Position (n,) of the last sample."""
        found: Array = self.take(self.count - 1, self.count)[0, 0]
        return found.copy()

    @property
    def q(self) -> Array:
        """Positions (N, n), rad or m."""
        return self._whole()[0]

    @property
    def qd(self) -> Array:
        """Speeds (N, n)."""
        return self._whole()[1]

    @property
    def qdd(self) -> Array:
        """Accelerations (N, n)."""
        return self._whole()[2]

    def take(self, first: int, last: int) -> Array:
        """Return samples `first` to `last`, that one not included: positions, speeds, accelerations (3, k, n)."""
        return self.rows.take(first, last)

    def _whole(self) -> Array:
        if self.count > MOST_SAMPLES:
            raise OutOfLimits(
                f"the motion lasts {self.duration:.6g} s and has {self.count:.6g} samples; up to {MOST_SAMPLES} are "
                "given at once: use take(first, last)"
            )
        return self.take(0, self.count)


def standstill(q: Array, dt: float, line: int) -> Trajectory:
    """Trajectory of the single sample `q` (n,), at rest."""
    rest = np.zeros((1, q.shape[0]))
    return Trajectory(dt, q[None, :].copy(), rest, rest.copy(), line)


def joined(first: Trajectory, second: Trajectory, lap: int) -> Trajectory:
    """`second` over the last `lap` steps of `first`: positions from its start, speeds and accelerations added."""
    start = first.count - 1 - lap
    rows = Overlapped(first.rows, second.rows, start, lap, second.take(0, 1)[0, 0].copy())
    return Trajectory.of(first.dt, rows, second.line, begin=start, brake=start + second.brake)


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


def check_inside(q: Array, limits: JointLimits, *, in_degrees: bool = False) -> None:
    """Raise `OutOfLimits` where a position in `q` (n,), rad or m, lies outside its limits.

    `in_degrees`: they were written in degrees and mm, and are told so; otherwise degrees are asked about.
    """
    beyond = outside(q, limits.lower, limits.upper)
    if beyond.any():
        j = int(np.argmax(beyond))
        if in_degrees:
            low, high, turns = limits.lower[j], limits.upper[j], limits.turns[j]
            raise OutOfLimits(
                f"{limits.names[j]} is to go to {joint_values.in_degrees(q[j], turns)}; "
                f"its limits are {joint_values.range_in_degrees(low, high, turns)}"
            )
        degrees = looks_like_degrees(q, limits.lower, limits.upper, limits.turns)
        hint = "; angles are in rad: are these degrees? give numpy.radians(q)" if degrees else ""
        raise OutOfLimits(
            f"{limits.names[j]} is to go to {written(q[j], limits.turns[j])}; {limits_of(limits, j)}{hint}"
        )


def limits_of(limits: JointLimits, j: int) -> str:
    """The limits of joint `j` in words."""
    low, high = float(limits.lower[j]), float(limits.upper[j])
    if not limits.turns[j]:
        return f"its limits are {low:.6g} to {high:.6g} m"
    return f"its limits are {low:.6g} to {high:.6g} rad ({math.degrees(low):.4g} to {math.degrees(high):.4g} deg)"


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
    count = current.count
    if not 0 <= consumed <= count:
        raise MotionError(f"{consumed} samples consumed of a trajectory of {count}; give 0 to {count}")
    k = min(consumed, count - 1)
    begin, brake = max(current.begin - k, 0), max(current.brake - k, 0)
    return Trajectory.of(current.dt, current.rows.after(k), current.line, begin=begin, brake=brake)
