"""A load cycle: what a joint does and bears, over and over, stretch by stretch.

A trapezoidal move in thirds over an angle `p` in a time `t` has the peak speed `3 p / 2 t` and the acceleration
`9 p / 2 t^2`; of its torque the rms is `sqrt(2/3)` of the peak, friction and dwell apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array
from holonom.devices._checks import require
from holonom.errors import ModelError, ShapeError

__all__ = ["LoadCycle", "best_ratio"]


@dataclass(frozen=True, slots=True)
class LoadCycle:
    """Stretches of constant acceleration and torque at the joint, without any motor.

    Attributes
    ----------
    duration
        s, each above 0, (n,).
    start, end
        Speed at both ends of each, rad/s, (n,).
    torque
        That the joint takes, N m, positive where it drives forwards: load, inertia and friction, (n,).
    inertia
        Of the load at the joint, kg m^2, for the ratio of inertias; 0 where nothing is known of it.

    Raises
    ------
    ShapeError, NotFinite
        Arrays of different lengths, or of none; numbers that are not finite.
    ModelError
        A duration that is not above 0.
    """

    duration: Array
    start: Array
    end: Array
    torque: Array
    inertia: float = 0.0

    def __post_init__(self) -> None:
        size = finite_array("LoadCycle: duration", self.duration, ["n"]).size
        for name in ("start", "end", "torque"):
            finite_array(f"LoadCycle: {name}", getattr(self, name), (size,))
        if size == 0:
            raise ShapeError("LoadCycle: no stretch came; one at least is needed")
        if np.any(self.duration <= 0.0):
            at = int(np.argmin(self.duration))
            raise ModelError(f"LoadCycle: duration[{at}] is {self.duration[at]:g} s; each must be above 0")
        require("LoadCycle", "inertia", self.inertia, least=0.0)

    @classmethod
    def move(
        cls,
        angle: float,
        time: float,
        inertia: float,
        *,
        friction: float = 0.0,
        load: float = 0.0,
        dwell: float = 0.0,
    ) -> Self:
        """A move from rest to rest, a third of the time each for speeding up, going on and slowing down; then a rest.

        Parameters
        ----------
        angle : rad, not 0.
        time : of the move, s.
        inertia : of the load, kg m^2.
        friction : torque against the motion, N m.
        load : torque that is always there, N m: gravity.
        dwell : s at rest after the move, under the load.
        """
        require("LoadCycle.move", "angle", abs(angle), above=0.0)
        require("LoadCycle.move", "time", time, above=0.0)
        require("LoadCycle.move", "friction", friction, least=0.0)
        require("LoadCycle.move", "inertia", inertia, least=0.0)
        require("LoadCycle.move", "load", load)
        require("LoadCycle.move", "dwell", dwell, least=0.0)
        speed, push = 1.5 * angle / time, 4.5 * angle / time**2 * inertia
        rubs = math.copysign(friction, angle)
        third = time / 3.0
        duration, start, end = [third] * 3, [0.0, speed, speed], [speed, speed, 0.0]
        torque = [load + rubs + push, load + rubs, load + rubs - push]
        if dwell > 0.0:
            duration, start, end, torque = [*duration, dwell], [*start, 0.0], [*end, 0.0], [*torque, load]
        return cls(np.array(duration), np.array(start), np.array(end), np.array(torque), inertia)

    @classmethod
    def sampled(cls, time: ArrayLike, speed: ArrayLike, torque: ArrayLike, *, inertia: float = 0.0) -> Self:
        """Of samples: time (s, increasing), speed (rad/s) and torque (N m), (n,) each; torque is held to halfway."""
        at = finite_array("time", time, ["n"])
        speeds = finite_array("speed", speed, (at.size,))
        torques = finite_array("torque", torque, (at.size,))
        if at.size < 2:
            raise ShapeError(f"time has {at.size} samples; two at least are needed")
        if np.any(np.diff(at) <= 0.0):
            k = int(np.argmax(np.diff(at) <= 0.0)) + 1
            raise ModelError(f"LoadCycle: time[{k}] is {at[k]:g} s after {at[k - 1]:g} s; times must increase")
        halves, middle = np.repeat(0.5 * np.diff(at), 2), 0.5 * (speeds[1:] + speeds[:-1])
        start, end = np.column_stack((speeds[:-1], middle)), np.column_stack((middle, speeds[1:]))
        held = np.column_stack((torques[:-1], torques[1:]))
        return cls(halves, start.ravel(), end.ravel(), held.ravel(), inertia)

    @property
    def time(self) -> float:
        """Of the whole cycle, s."""
        return float(self.duration.sum())

    @property
    def acceleration(self) -> Array:
        """Of each stretch, rad/s^2, (n,)."""
        found: Array = (self.end - self.start) / self.duration
        return found

    @property
    def peak_speed(self) -> float:
        """Largest magnitude, rad/s."""
        return float(max(np.abs(self.start).max(), np.abs(self.end).max()))

    @property
    def peak_torque(self) -> float:
        """Largest magnitude, N m."""
        return float(np.abs(self.torque).max())

    @property
    def rms_torque(self) -> float:
        """Over the time of the cycle, N m."""
        return self.rms(self.torque)

    def rms(self, value: Array) -> float:
        """Root of the mean square of what has one value a stretch, (n,)."""
        return math.sqrt(float(np.sum(self.duration * value * value)) / self.time)


def best_ratio(rotor_inertia: float, load_inertia: float) -> float:
    """Ratio with the greatest acceleration of a load by a motor torque, `sqrt(J_L / J_m)`: inertias are matched.

    Inertias in kg m^2, both above 0.
    """
    require("best_ratio", "rotor_inertia", rotor_inertia, above=0.0)
    require("best_ratio", "load_inertia", load_inertia, above=0.0)
    return math.sqrt(load_inertia / rotor_inertia)
