"""`Plant`: an arm with its drives, encoders and servo loops, advanced in compiled code."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.control import (
    CONTROLLERS,
    AxisLimits,
    CascadeSettings,
    ComputedTorqueSettings,
    SampleTimes,
    ServoAxis,
    Violation,
    acceleration_params,
    design_cascade,
    drive_fault,
)
from holonom.devices import DcMotor, Encoder, Friction, Gear, tracking_params
from holonom.errors import ModelError
from holonom.mechanics import Arm
from holonom.model import ArmModel, Joint
from holonom.sim.arm.kernels import CASCADE, COMPUTED_TORQUE, POSITION_TICK, SPEED_TICK, STOP, advance
from holonom.sim.arm.plant_equation import plant_kernel
from holonom.sim.arm.records import STATE, Axis, axis_table

__all__ = ["STEP", "TICK", "ControlSettings", "Ground", "Plant", "check_drives"]

Array = NDArray[np.float64]

LAWS = {CascadeSettings: CASCADE, ComputedTorqueSettings: COMPUTED_TORQUE}
"""Compiled laws, by the settings of the controllers that they are of."""
STEP = 1e-4
"""Step of the current loop and of the arm, s."""
TICK = STEP * POSITION_TICK
"""Sample time of the position loop and of a reference, s."""
COULOMB_SMOOTHING = 0.5
"""Motor speed (rad/s) below which Coulomb friction goes over into its opposite smoothly."""


@dataclass(frozen=True, slots=True)
class ControlSettings:
    """Which controller drives the arm and where it trips.

    `law_bandwidth` (rad/s) places the poles of the computed-torque error equation; `following_error` (rad) and
    `trip_margin` (part of the rated speed and current by which they may be passed) stop an axis.
    """

    controller: str = "cascade"
    law_bandwidth: float = ComputedTorqueSettings().law_bandwidth
    following_error: float = 0.1
    trip_margin: float = 0.25

    def __post_init__(self) -> None:
        if CONTROLLERS[self.controller].record not in LAWS:
            raise ModelError(f"controller {self.controller!r} cannot be simulated: no compiled law is of its settings")


@dataclass(frozen=True, slots=True)
class Ground:
    """A horizontal surface under the tool point: height (m), stiffness (N/m), damping (N s/m)."""

    height: float = -1e3
    stiffness: float = 2e4
    damping: float = 200.0


class Plant:
    """An arm with six (or n) complete servo axes. Mutable state: `states`, `payload`, `time_steps`."""

    def __init__(self, arm: Arm, q: ArrayLike, settings: ControlSettings, ground: Ground = Ground()) -> None:
        self.arm, self.settings = arm, settings
        self.payload = np.zeros(4)
        """Mass (kg) and centre of mass (m, tool frame) of what the gripper holds."""
        self.ticks = 0
        self.touch = 0.0
        """Largest force (N) with which the tool pressed on the ground since the start."""
        self._ground = np.array([ground.height, ground.stiffness, ground.damping])
        self._kernel = plant_kernel(arm.model)
        self._law = arm.kernel("inverse_dynamics")
        inertia = np.diagonal(arm.mass_matrix(np.asarray(q, dtype=float)))
        self.axis_limits = [_axis_limits(joint, settings) for joint in arm.model.joints]
        rows = [
            _axis(joint, float(b), settings, limits)
            for joint, b, limits in zip(arm.model.joints, inertia, self.axis_limits, strict=True)
        ]
        self._axes = axis_table(rows)
        self._work = np.zeros(8 * arm.n + 8)
        self._mode = LAWS[CONTROLLERS[settings.controller].record]
        self.states = self._at_rest(np.asarray(q, dtype=float))

    def _at_rest(self, q: Array) -> NDArray[np.void]:
        """Axes standing at q under their own gravity load, homed: encoders know where they are."""
        states = np.zeros(self.arm.n, dtype=STATE)
        states["position"] = q
        counts = np.floor(q * self._axes["gear"]["ratio"] * self._axes["encoder"]["counts_per_rad"])
        states["count"] = counts.astype(np.int64)
        states["angle"] = (counts + 0.5) * self._axes["encoder"]["resolution"]
        hold = self.arm.gravity(q) / (self._axes["gear"]["ratio"] * self._axes["torque_constant"])
        states["current"] = states["current_reference"] = states["speed_integral"] = hold
        states["current_integral"] = hold / self._axes["armature"]["conductance"]
        states["load"] = -self._axes["torque_constant"] * hold / self._axes["inertia"]
        return states

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.ticks * TICK

    @property
    def q(self) -> Array:
        """Joint positions (n,), rad."""
        return self.states["position"].copy()

    @property
    def qd(self) -> Array:
        """Joint speeds (n,), rad/s."""
        return self.states["speed"].copy()

    def advance(self, reference: Array) -> None:
        """Advance over reference samples (3, ticks, n) at 1 kHz: positions, speeds, accelerations.

        Raises
        ------
        DriveFault
            An axis left a limit; the plant stands at the start of the tick at which it did.
        """
        code, axis, tick, touch = self._advance(self._mode, reference)
        self.touch = max(self.touch, touch)
        self.ticks += reference.shape[1] if code == 0 else tick
        if code != 0:
            self._fault(Violation(code), axis, float(reference[0, tick, axis]))

    def brake(self, ticks: int) -> None:
        """Hold zero speed for some ticks, whatever the reference: the controlled stop after a fault."""
        self._advance(STOP, np.zeros((3, ticks, self.arm.n)))
        self.ticks += ticks

    def _advance(self, mode: int, reference: Array) -> tuple[int, int, int, float]:
        surroundings = np.concatenate([self.payload, self._ground])
        return advance(
            mode,
            self._kernel.address,
            self._law.address,
            STEP,
            self._axes,
            self.states,
            np.ascontiguousarray(reference),
            surroundings,
            self._work,
        )

    def _fault(self, violation: Violation, axis: int, reference: float) -> None:
        state, ratio = self.states[axis], self._axes["gear"]["ratio"][axis]
        raise drive_fault(
            violation,
            self.axis_limits[axis],
            axis=self.arm.model.joints[axis].name,
            time=self.time,
            reference=reference,
            position=state["angle"] / ratio,
            speed=state["rate"] / ratio,
            current=float(state["current"]),
        )


def _axis_limits(joint: Joint, settings: ControlSettings) -> AxisLimits:
    motor = _motor(joint)
    margin = 1.0 + settings.trip_margin
    return AxisLimits(
        joint.limits.lower - settings.following_error,
        joint.limits.upper + settings.following_error,
        joint.limits.speed * margin,
        motor.max_current * margin,
        settings.following_error,
    )


def check_drives(model: ArmModel) -> None:
    """Raise `ModelError` where a joint lacks what its drive's simulation needs."""
    for joint in model.joints:
        _motor(joint)


def _motor(joint: Joint) -> DcMotor:
    motor = joint.motor
    if motor is None or motor.encoder_counts == 0:
        raise ModelError(
            f"joint {joint.name!r} has no motor with drive and encoder data, so its drives cannot be simulated; "
            "give the model a complete Motor per joint"
        )
    return DcMotor(
        motor.resistance,
        motor.inductance,
        motor.torque_constant,
        motor.torque_constant,
        motor.rotor_inertia,
        motor.max_voltage,
        motor.max_current,
    )


def _axis(joint: Joint, inertia: float, settings: ControlSettings, limits: AxisLimits) -> Axis:
    """Data sheets and gains of a joint whose inertia (rotor included) is known at its working point, kg m2."""
    data, motor = joint.motor, _motor(joint)
    assert data is not None
    ratio = data.gear_ratio
    seen = inertia / ratio**2
    encoder = Encoder(data.encoder_counts)
    friction = _motor_friction(joint, ratio)
    times = SampleTimes(STEP, STEP * SPEED_TICK, TICK)
    gains = design_cascade(
        ServoAxis(
            resistance=motor.resistance,
            inductance=motor.inductance,
            torque_constant=motor.torque_constant,
            back_emf_constant=motor.back_emf_constant,
            inertia=seen,
            viscous=friction.viscous,
            max_voltage=motor.max_voltage,
            max_current=motor.max_current,
            max_speed=joint.limits.speed * abs(ratio),
            counts_per_rev=encoder.counts_per_rev,
        ),
        times=times,
    )
    return Axis(
        motor.armature(STEP),
        friction.params(COULOMB_SMOOTHING),
        Gear(ratio).params(),
        encoder.params(),
        tracking_params(gains.observer_bandwidth, times.speed),
        gains.current,
        gains.speed,
        gains.position,
        acceleration_params(settings.law_bandwidth, TICK),
        limits.params(),
        motor.torque_constant,
        seen,
    )


def _motor_friction(joint: Joint, ratio: float) -> Friction:
    """The joint's friction at its motor; a negative ratio swaps the directions."""
    f = joint.friction
    if f is None:
        return Friction()
    positive, negative = f.coulomb_positive / abs(ratio), f.coulomb_negative / abs(ratio)
    if math.copysign(1.0, ratio) < 0.0:
        positive, negative = negative, positive
    return Friction(f.viscous / ratio**2, positive, negative)
