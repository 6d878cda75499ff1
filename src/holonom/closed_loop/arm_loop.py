"""`ArmLoop`: the servos of an arm and a simulated arm, advanced in compiled code along references."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite_array, whole_number
from holonom.closed_loop.arm_kernels import run_reference
from holonom.closed_loop.reference import checked_reference
from holonom.devices import Encoder, Gear
from holonom.machine.arm.kernels import CURRENT, STOP
from holonom.machine.arm.servos import STEP, ArmServos, ControlSettings, joint_friction, joint_motor
from holonom.mechanics import Arm
from holonom.model import Joint
from holonom.sim.arm.plant import ArmPlant, AxisDrive, Ground

__all__ = ["ArmLoop", "Measured", "Truth", "drives_of"]


_FULL = 0.99
"""Part of its limit from which a current is at it."""


class Measured(NamedTuple):
    """Positions (rad, m), speeds, torques by current (N m, N), currents (A), voltages (V) asked for, counts: (n,)."""

    position: Array
    speed: Array
    effort: Array
    current: Array
    voltage: Array
    counts: NDArray[np.int64] | None


class Truth(NamedTuple):
    """Positions (rad or m), speeds, torques behind the gears (N m or N), currents (A): (n,)."""

    position: Array
    speed: Array
    effort: Array
    current: Array


class ArmLoop:
    """Servos and plant that do not know each other; they meet in `plant.signals`.

    Parameters
    ----------
    arm
        A model with complete motors; the plant is made of the same numbers.
    q
        Joints (n,), rad, where it stands at first.
    settings
        Controller, limits, levels.
    ground
        What lies under the tool.

    Raises
    ------
    ShapeError
        Joints of another shape, or not finite.
    ModelError
        A joint without complete motor data.
    """

    def __init__(self, arm: Arm, q: ArrayLike, settings: ControlSettings, ground: Ground = Ground()) -> None:
        self.arm, self.settings = arm, settings
        self.servos = ArmServos(arm, q, settings)
        self.plant = ArmPlant(arm, drives_of(arm), q, ground)
        self.servos.start(q, self.plant.hold, self.plant.signals)
        self._ticks = 0
        self._pressing = 0.0

    @property
    def warnings(self) -> list[str]:
        """What the design of its servos does not reach."""
        return self.servos.warnings

    @property
    def tick(self) -> float:
        """Sample time of a reference, s."""
        return self.settings.levels.servo

    @property
    def position(self) -> Array:
        """Measured joint positions (n,), rad."""
        return self.servos.position

    @property
    def speed(self) -> Array:
        """Measured joint speeds (n,), rad/s."""
        return self.servos.speed

    @property
    def measured(self) -> Measured:
        """What its sensors and drives say."""
        s, signals = self.servos, self.plant.signals
        return Measured(
            s.position, s.speed, s.effort(signals.currents), signals.currents.copy(), signals.voltages.copy(),
            s.states["count"].copy(),
        )  # fmt: skip

    @property
    def truth(self) -> Truth:
        """What is so."""
        states = self.plant.states
        return Truth(
            states["position"].copy(), states["speed"].copy(), states["torque"].copy(), states["current"].copy()
        )

    @property
    def worst(self) -> dict[str, Array]:
        """Largest magnitudes since the start (n,): speed, torque, current, voltage, error; rms of the error."""
        states = self.plant.states
        found = {name: states[f"peak_{name}"].copy() for name in ("speed", "torque", "current", "voltage", "error")}
        found["rms_error"] = np.sqrt(states["square_error"] / max(self._ticks, 1))
        return found

    @property
    def payload(self) -> Array:
        """Mass (kg) and centre of mass (m, tool frame) of what the hand holds: (4,)."""
        return self.plant.payload

    @payload.setter
    def payload(self, value: Array) -> None:
        self.plant.payload = finite_array("payload", value, (4,))

    @property
    def touch(self) -> float:
        """Largest force (N) with which the tool pressed on the ground since the start."""
        return self.plant.touch

    @property
    def ground(self) -> float:
        """Height of what lies under the tool, m, as the arm's base sees it."""
        return self.plant.ground

    @ground.setter
    def ground(self, height: float) -> None:
        self.plant.ground = height

    @property
    def pressing(self) -> float | None:
        """Largest force (N) with which the tool pressed on the ground in the last advance."""
        return self._pressing

    def at_limit(self) -> tuple[str, ...]:
        """Of each joint whether its measured current is at the limit of its drive, in words."""
        most, currents = self.servos.axes["speed"]["max_current"], np.abs(self.plant.signals.currents)
        return tuple(
            f"its current is at its limit of {limit:g} A" if now >= _FULL * limit else ""
            for now, limit in zip(currents.tolist(), most.tolist(), strict=True)
        )

    @property
    def ticks(self) -> int:
        """Reference samples since the start."""
        return self._ticks

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._ticks * self.tick

    def advance(self, reference: Array) -> None:
        """Advance over reference samples (3, ticks, n): positions, speeds, accelerations.

        Raises
        ------
        ShapeError
            Samples of another shape; nothing moves.
        LevelFault
            Samples that are not finite; nothing moves.
        DriveFault
            An axis left a limit; the plant stands at the start of the tick at which it did.
        LevelFault
            A law that is not compiled gave no torques.
        """
        reference, law = checked_reference(self.arm, reference), self.servos.law
        self._pressing = 0.0
        if law is None:
            self._advance(self.servos.mode, reference)
            return
        every = round(self.settings.levels.model / self.tick)
        for k in range(reference.shape[1]):
            if self._ticks % every == 0:
                self.servos.ask(law, reference[:, k])
            self._advance(CURRENT, reference[:, k : k + 1])

    def _advance(self, mode: int, reference: Array) -> None:
        code, axis, tick = self._run(mode, reference)
        self._ticks += reference.shape[1] if code == 0 else tick
        if code != 0:
            current = float(self.plant.signals.currents[axis])
            raise self.servos.fault(code, axis, self.time, float(reference[0, tick, axis]), current)

    def brake(self, ticks: int) -> None:
        """Hold zero speed for some ticks, whatever the reference: the controlled stop after a fault.

        Raises
        ------
        OutOfLimits
            Not a whole number of ticks, or a negative one.
        """
        ticks, self._pressing = whole_number("ticks", ticks), 0.0
        self._run(STOP, np.zeros((3, ticks, self.arm.n)))
        self._ticks += ticks

    def _run(self, mode: int, reference: Array) -> tuple[int, int, int]:
        s, p = self.servos, self.plant
        code, axis, tick, touch = run_reference(
            mode, s.timing, s.clock, p.signals, s.model.address, s.axes, s.states, s.scratch,
            p.kernel.address, STEP, p.axes, p.states, p.work(), np.ascontiguousarray(reference),
        )  # fmt: skip
        p.touch, self._pressing = max(p.touch, touch), max(self._pressing, touch)
        return code, axis, tick


def drives_of(arm: Arm) -> list[AxisDrive]:
    """The drives that an arm's model states, one per joint.

    Raises
    ------
    ModelError
        A joint without complete motor data.
    """
    return [_drive(joint) for joint in arm.model.joints]


def _drive(joint: Joint) -> AxisDrive:
    motor = joint_motor(joint)
    assert joint.motor is not None
    ratio = joint.motor.gear_ratio
    gear = Gear(ratio, joint.motor.gear_efficiency)
    return AxisDrive(motor, gear, Encoder(joint.motor.encoder_counts), joint_friction(joint, ratio))
