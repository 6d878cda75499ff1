"""Levels of a controller: who gives what to whom, how often, and what is made of it in between.

The supervisor gives points of a path, the model (dynamics) torques or accelerations, the servos follow. Each level
has a period of its own, and holds what the level above gave until the next comes (specification 04).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array, real_array, whole_number
from holonom.errors import OutOfLimits, ShapeError, UnknownName

__all__ = ["INTERPOLATIONS", "LevelState", "Levels", "PointBuffer", "interpolate"]


GRID = 5e-4
"""Periods are multiples of this, s: the sample time of the speed loops."""
INTERPOLATIONS = ("hold", "linear", "cubic")
"""What a level makes of points between two of them."""


@dataclass(frozen=True, slots=True)
class Levels:
    """Periods (s) of the levels, computing delay (s) of the model law, interpolation of the supervisor's points.

    Raises
    ------
    OutOfLimits
        A period that is no multiple of the one below or of 0.5 ms, or a delay that is not shorter than the model's.
    UnknownName
        An interpolation that there is not.
    """

    supervisor: float = 1e-3
    model: float = 1e-3
    servo: float = 1e-3
    delay: float = 0.0
    interpolation: str = "linear"

    def __post_init__(self) -> None:
        if self.interpolation not in INTERPOLATIONS:
            raise UnknownName("interpolation", self.interpolation, INTERPOLATIONS)
        for name, below, what in (
            ("servo", GRID, "0.5 ms"),
            ("model", self.servo, "the servos' period"),
            ("supervisor", self.servo, "the servos' period"),
        ):
            value = getattr(self, name)
            if not (0.0 < value < math.inf and _multiple(value, below)):
                raise OutOfLimits(f"Levels: {name} is {value!r} s; it must be a multiple of {what}, {below:g} s")
        if not (0.0 <= self.delay < self.model and _multiple(self.delay, 1e-4)):
            raise OutOfLimits(
                f"Levels: delay is {self.delay!r} s; it must be a multiple of 0.1 ms below the model's {self.model:g} s"
            )

    @property
    def ratio(self) -> int:
        """Servo periods between two points of the supervisor."""
        return round(self.supervisor / self.servo)


def _multiple(value: float, unit: float) -> bool:
    return abs(value / unit - round(value / unit)) < 1e-6


def interpolate(points: ArrayLike, ratio: int, how: str = "linear") -> Array:
    """Return points (k, n), and `ratio - 1` more between each two of them: ((k - 1) ratio + 1, n).

    Parameters
    ----------
    points
        At equal intervals.
    how
        One of `INTERPOLATIONS`. "cubic" takes the slopes from neighbours (Catmull and Rom), one-sided at the ends.

    Raises
    ------
    UnknownName
        An interpolation that there is not.
    OutOfLimits
        A ratio that is no whole number, or below 1.
    """
    if how not in INTERPOLATIONS:
        raise UnknownName("interpolation", how, INTERPOLATIONS)
    ratio = whole_number("ratio", ratio, least=1)
    p = np.asarray(points, float)
    if ratio == 1 or len(p) < 2:
        return p.copy()
    s = (np.arange(ratio) / ratio)[None, :, None]
    a, b = p[:-1, None], p[1:, None]
    if how == "hold":
        between = a + 0.0 * s
    elif how == "linear":
        between = a + s * (b - a)
    else:
        slope = np.gradient(p, axis=0)
        between = _hermite(a, b, slope[:-1, None], slope[1:, None], s)
    return np.vstack([between.reshape(-1, p.shape[1]), p[-1:]])


def _hermite(a: Array, b: Array, u: Array, v: Array, s: Array) -> Array:
    """Cubic from a to b with slopes u and v per interval, at parts s of it."""
    curve: Array = a + s * u + s * s * (3.0 * (b - a) - 2.0 * u - v) + s**3 * (u + v - 2.0 * (b - a))
    return curve


def _limits(name: str, value: ArrayLike, n: int) -> Array:
    limits = real_array(name, value)
    if limits.shape != (n,):
        raise ShapeError(f"{name} has shape {limits.shape}; it must be ({n},), one limit for each axis")
    if not (limits > 0.0).all():
        raise OutOfLimits(f"{name} is {limits.tolist()}; each limit must be above 0")
    return limits


class LevelState(Enum):
    """How a level fares with the one above."""

    STANDING = "standing"
    FOLLOWING = "following"
    STOPPING = "stopping"


class PointBuffer:
    """What a level holds of the points that the level above sends, and how it goes on when they fail to come.

    Points (n,) are due one each period; between them it interpolates. A point that is not finite, or farther from the
    last than the axes can move in a period, is not taken. When what it holds is used up in motion, it stops on the
    line of that motion within the axes' accelerations, and `reason` names the level and what it did; it stands until
    `restart`. Mutable state: points, place between them, position and speed of the last sample.

    Parameters
    ----------
    name
        Of the level above, for `reason`.
    start
        Point (n,) where it stands at first.
    levels
        Periods and interpolation.
    speed, acceleration
        Limits of the axes (n,).

    Raises
    ------
    ShapeError
        A start that is not (n,), finite; limits of another shape.
    OutOfLimits
        Limits that are not above 0.
    """

    def __init__(
        self, name: str, start: ArrayLike, levels: Levels, *, speed: ArrayLike, acceleration: ArrayLike
    ) -> None:
        self.name, self.levels = name, levels
        self.position = finite_array("start", start, ("n",)).copy()
        """Reference of the last sample (n,)."""
        self.rate = np.zeros_like(self.position)
        """Its speed (n,)."""
        self.speed = _limits("speed", speed, len(self.position))
        self.acceleration = _limits("acceleration", acceleration, len(self.position))
        self.restart()

    def restart(self) -> None:
        """Begin again where it stands."""
        self.state, self.reason = LevelState.STANDING, ""
        self._refused, self._place = "", 0
        self._pace = self._braking = np.zeros_like(self.rate)
        self._points, self._samples = [self.position.copy()], np.empty((0, len(self.position)))
        self._slope = np.zeros_like(self.position)

    @property
    def held(self) -> int:
        """Servo periods that the points reach."""
        return len(self._samples) - self._place + (len(self._points) - 1) * self.levels.ratio

    def push(self, point: ArrayLike) -> bool:
        """Take the next point; False where it is refused, and the level stops once what it holds is used up.

        Raises
        ------
        ShapeError
            Another number of axes, or no numbers.
        """
        new, last = real_array("a point", point), self._points[-1]
        if new.shape != last.shape:
            raise ShapeError(f"{self.name} sent a point of shape {new.shape}; the axes are {last.shape}")
        if self.state is LevelState.STOPPING or self.reason or self._refused:
            return False
        self._refused = self._fault(new, last)
        if self._refused:
            return False
        self._points.append(new.copy())
        self.state = LevelState.FOLLOWING
        return True

    def take(self, count: int) -> Array:
        """Return the reference of the next servo periods: positions, speeds, accelerations (3, count, n).

        Raises
        ------
        OutOfLimits
            Not a whole number of periods, or a negative one.
        """
        count = whole_number("count", count)
        dt, out = self.levels.servo, np.empty((3, count, len(self.position)))
        for k in range(count):
            before = self.rate
            self._advance(dt)
            out[:, k] = self.position, self.rate, (self.rate - before) / dt
        return out

    def _fault(self, new: Array, last: Array) -> str:
        if not np.isfinite(new).all():
            return f"{self.name} sent {new.tolist()}, which is not finite"
        step, most = np.abs(new - last), self.speed * self.levels.supervisor * (1.0 + 1e-9)
        if (step <= most).all():
            return ""
        axis, period = int(np.argmax(step / most)), 1e3 * self.levels.supervisor
        jump = f"{step[axis]:.3g} in {period:g} ms, {most[axis]:.3g} is allowed"
        return f"{self.name} sent a jump of axis {axis + 1}: {jump}"

    def _advance(self, dt: float) -> None:
        """One servo period: along the points, or on the line of the last motion until it stands."""
        if self._place == len(self._samples) and len(self._points) > 1:
            self._begin_segment()
        if self._place < len(self._samples):
            new = self._samples[self._place]
            self.rate, self.position = (new - self.position) / dt, new.copy()
            self._place += 1
            return
        if self.state is LevelState.FOLLOWING:
            self._use_up()
        if self.state is LevelState.STOPPING:
            part = dt * (self.acceleration / np.maximum(np.abs(self._braking), 1e-12)).min()
            left = np.abs(self.rate).max() / np.abs(self._braking).max() - part
            self.rate = max(left, 0.0) * self._braking
            self.position = self.position + dt * self.rate
            if left <= 0.0:
                self.state = LevelState.STANDING
        else:
            self.rate = np.zeros_like(self.rate)

    def _use_up(self) -> None:
        """The points have come to an end: at rest that is that; in motion the level above is at fault."""
        moving = bool((np.abs(self._pace) > self.acceleration * self.levels.supervisor).any())
        if not (moving or self._refused):
            self.state = LevelState.STANDING
            return
        late = f"{self.name} is late: no point came within its period of {1e3 * self.levels.supervisor:g} ms"
        self.reason, self._braking = self._refused or late, self._pace
        self.rate = self._pace
        self.state = LevelState.STOPPING if moving else LevelState.STANDING

    def _begin_segment(self) -> None:
        """Interpolate to the next point; a cubic takes its slopes from the points that are known now."""
        a, b = self._points[0], self._points[1]
        self._pace = (b - a) / self.levels.supervisor
        if self.levels.interpolation == "cubic":
            slope = self._slope
            self._slope = 0.5 * (self._points[2] - a) if len(self._points) > 2 else b - a
            parts = (np.arange(1, self.levels.ratio + 1) / self.levels.ratio)[:, None]
            self._samples, self._place = _hermite(a, b, slope, self._slope, parts), 0
        else:
            rows = interpolate([a, b], self.levels.ratio, self.levels.interpolation)
            self._samples, self._place = rows[1:], 0
        del self._points[0]
