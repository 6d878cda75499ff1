"""`IdealArm`: joints that follow their references within their limits, without motors and without dynamics."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, whole_number
from holonom.closed_loop.arm_loop import Measured, Truth
from holonom.closed_loop.reference import checked_reference
from holonom.control import AxisLimits, Violation, drive_fault
from holonom.control.servo.kernels import axis_violation
from holonom.machine.arm.servos import ControlSettings
from holonom.mechanics import Arm
from holonom.mechanics.motion.trajectory import joint_vector
from holonom.model import ArmModel

__all__ = ["IdealArm"]


class IdealArm:
    """An arm whose drives are perfect: each joint is where it is told to be, no faster than its limit.

    It takes the place of `ArmLoop` for models without motors, or without masses. Mutable state: joints, clock, peaks.

    Parameters
    ----------
    arm
        Its limits are those of the joints.
    q
        Joints (n,), rad or m, where it stands at first.
    settings
        Levels; the following error at which it stops.

    Raises
    ------
    ShapeError
        Joints of another shape, or not finite.
    """

    def __init__(self, arm: Arm, q: ArrayLike, settings: ControlSettings) -> None:
        self.arm, self.settings = arm, settings
        self.payload = np.zeros(4)
        """What the hand holds; it weighs nothing here."""
        self.touch = 0.0
        self.ground = -math.inf
        self.pressing: float | None = None
        """Ideal joints feel no force."""
        self.position: Array = joint_vector("q", q, arm.n).copy()
        """Joints (n,)."""
        self.speed: Array = np.zeros(arm.n)
        self.ticks = 0
        self.worst = {name: np.zeros(arm.n) for name in ("speed", "torque", "current", "voltage", "error", "rms_error")}
        """Largest magnitudes since the start (n,)."""
        self._limits = [_axis_limits(arm.model, i, settings) for i in arm.model.independent]

    @property
    def warnings(self) -> list[str]:
        """None: it has no servos."""
        return []

    @property
    def tick(self) -> float:
        """Sample time of a reference, s."""
        return self.settings.levels.servo

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.ticks * self.tick

    @property
    def measured(self) -> Measured:
        """What its sensors say: all is as it is."""
        none = np.zeros(self.arm.n)
        return Measured(self.position.copy(), self.speed.copy(), none, none, none, None)

    @property
    def truth(self) -> Truth:
        """What is so; nobody knows the forces."""
        none = np.zeros(self.arm.n)
        return Truth(self.position.copy(), self.speed.copy(), none, none)

    def advance(self, reference: Array) -> None:
        """Advance over reference samples (3, ticks, n): positions, speeds, accelerations.

        Raises
        ------
        ShapeError
            Samples of another shape; nothing moves.
        LevelFault
            Samples that are not finite; nothing moves.
        DriveFault
            A reference outside the joints' limits, or faster than they follow.
        """
        for target in checked_reference(self.arm, reference)[0]:
            self._watch(target)
            most = self.tick * self.arm.limits.speed
            self._move(self.position + np.clip(target - self.position, -most, most))
            error = np.abs(target - self.position)
            self.worst["error"] = np.maximum(self.worst["error"], error)

    def at_limit(self) -> tuple[str, ...]:
        """No drive of ideal joints is at a limit."""
        return ("",) * self.arm.n

    def brake(self, ticks: int) -> None:
        """Hold zero speed for some ticks.

        Raises
        ------
        OutOfLimits
            Not a whole number of ticks, or a negative one.
        """
        for _ in range(whole_number("ticks", ticks)):
            self._move(self.position)

    def _move(self, q: Array) -> None:
        self.speed, self.position = (q - self.position) / self.tick, q
        self.worst["speed"] = np.maximum(self.worst["speed"], np.abs(self.speed))
        self.ticks += 1

    def _watch(self, target: Array) -> None:
        for axis, limits in enumerate(self._limits):
            here = float(self.position[axis])
            code = axis_violation(limits.params(), float(target[axis]), here, 0.0, 0.0)
            if code != 0:
                raise drive_fault(
                    Violation(code), limits, axis=self.arm.limits.names[axis], time=self.time,
                    reference=float(target[axis]), position=here, speed=float(self.speed[axis]), current=0.0,
                )  # fmt: skip


def _axis_limits(model: ArmModel, axis: int, settings: ControlSettings) -> AxisLimits:
    joint, bounds = model.joints[axis], model.limits(axis)
    error = settings.error_of(joint)
    return AxisLimits(bounds.lower - error, bounds.upper + error, 2.0 * bounds.speed, 1.0, error, joint.unit)
