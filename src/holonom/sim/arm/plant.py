"""`ArmPlant`: an arm with its motors, gears and encoders, on its own or over a surface; no controller is here."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.devices.drive_signals import JointSignals
from holonom.errors import OutOfLimits, ShapeError
from holonom.mechanics import Arm
from holonom.mechanics.motion.trajectory import joint_vector
from holonom.sim.arm.kernels import sense
from holonom.sim.arm.plant_equation import plant_kernel
from holonom.sim.arm.records import DRIVE, DRIVE_STATE, Drive
from holonom.trace.call.records import record_table

__all__ = ["STEP", "ArmPlant", "AxisDrive", "Ground"]


STEP = 1e-4
"""Step of the arm and its motors, s."""


@dataclass(frozen=True, slots=True)
class Ground:
    """A horizontal surface under the tool point: height (m), stiffness (N/m), damping (N s/m)."""

    height: float = -1e3
    stiffness: float = 2e4
    damping: float = 200.0

    def __post_init__(self) -> None:
        for name, least in (("height", -math.inf), ("stiffness", 0.0), ("damping", 0.0)):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= least):
                raise OutOfLimits(
                    f"Ground: {name} is {value!r}; it must be finite" + " and at least 0" * (least == 0.0)
                )


@dataclass(frozen=True, slots=True)
class AxisDrive:
    """What drives a joint: motor, gear, encoder, and friction at the motor's shaft."""

    motor: DcMotor
    gear: Gear
    encoder: Encoder
    friction: Friction = field(default_factory=Friction)


class ArmPlant:
    """An arm with n drives. Mutable state: `states`, `payload`, `signals`, `touch`.

    Parameters
    ----------
    arm
        Its dynamics; friction is that of the drives.
    drives
        One per joint.
    q
        Joints (n,), rad, at which it stands at first, held by its motors' currents.
    ground
        What lies under the tool.

    Raises
    ------
    ShapeError
        Joints of another shape or not finite, or another number of drives.
    """

    def __init__(self, arm: Arm, drives: list[AxisDrive], q: ArrayLike, ground: Ground = Ground()) -> None:
        q = joint_vector("q", q, arm.n)
        if len(drives) != arm.n:
            raise ShapeError(f"{len(drives)} drives came; the arm has {arm.n} joints, give each its drive")
        self.arm = arm
        self.payload = np.zeros(4)
        """Mass (kg) and centre of mass (m, tool frame) of what the gripper holds."""
        self.touch = 0.0
        """Largest force (N) with which the tool pressed on the ground since the start."""
        self.kernel = plant_kernel(arm.model)
        self.axes = record_table([_row(drive) for drive in drives], DRIVE)
        self._ground = np.array([ground.height, ground.stiffness, ground.damping])
        self._work = np.zeros(4 * arm.n + 8)
        self.states = np.zeros(arm.n, dtype=DRIVE_STATE)
        self.states["position"] = q
        self.states["current"] = self.hold
        self.signals = JointSignals(np.zeros(arm.n, np.int64), self.states["current"].copy(), np.zeros(arm.n))
        """What its sensors read last, and the voltages that it is driven with."""
        sense(self.axes, self.states, self.signals)

    @property
    def ground(self) -> float:
        """Height of what lies under the tool, m, in the world that the arm's base stands in."""
        return float(self._ground[0])

    @ground.setter
    def ground(self, height: float) -> None:
        self._ground[0] = height

    @property
    def hold(self) -> Array:
        """Motor currents (n,), A, that carry its weight where it stands."""
        found: Array = self.arm.gravity(self.q) / (self.axes["gear"]["ratio"] * self.axes["torque_constant"])
        return found

    @property
    def q(self) -> Array:
        """Joint positions (n,), rad."""
        return self.states["position"].copy()

    @property
    def qd(self) -> Array:
        """Joint speeds (n,), rad/s."""
        return self.states["speed"].copy()

    def work(self) -> Array:
        """Scratch of the compiled step (4 n + 8,), with payload and ground in their places."""
        n = self.arm.n
        self._work[3 * n : 3 * n + 4], self._work[3 * n + 4 : 3 * n + 7] = self.payload, self._ground
        return self._work


def _row(drive: AxisDrive) -> Drive:
    return Drive(
        drive.motor.armature(STEP),
        drive.friction.stiction(drive.motor.rotor_inertia, STEP, drive.gear.efficiency),
        drive.gear.params(),
        drive.encoder.params(),
        drive.motor.torque_constant,
    )
