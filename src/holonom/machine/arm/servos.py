"""`ArmServos`: the servo loops of an arm, from encoders and shunts to motor voltages; the plant they never see."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array
from holonom.control import (
    CONTROLLERS,
    AxisLimits,
    CascadeGains,
    CascadeSettings,
    ComputedTorqueSettings,
    SampleTimes,
    ServoAxis,
    Violation,
    acceleration_params,
    design_cascade,
    drive_fault,
    greatest_bandwidth,
)
from holonom.devices import DcMotor, Encoder, Friction, tracking_params
from holonom.devices.drive_signals import JointSignals
from holonom.errors import DriveFault, LevelFault, ModelError
from holonom.machine.arm.kernels import CASCADE, COMPUTED_TORQUE, CURRENT
from holonom.machine.arm.law import JointLaw
from holonom.machine.arm.records import SERVO, SERVO_STATE, Servo, ServoTiming
from holonom.machine.levels import Levels
from holonom.mechanics import Arm
from holonom.mechanics.equations.dynamics.composite_body import mass_matrix
from holonom.mechanics.kernels.placement import bodies_of
from holonom.mechanics.motion.trajectory import joint_vector
from holonom.model import ArmModel, Joint
from holonom.trace.call.records import record_table

__all__ = ["STEP", "ArmServos", "ControlSettings", "check_drives", "joint_friction", "joint_motor"]


LAWS = {CascadeSettings: CASCADE, ComputedTorqueSettings: COMPUTED_TORQUE}
"""Compiled laws, by the settings of the controllers that they are of."""
STEP = 1e-4
"""Step of the current loop, s."""
SPEED_TICK = 5
"""Sample time of the speed loops, in steps of the current loop."""


@dataclass(frozen=True, slots=True)
class ControlSettings:
    """Which controller drives the arm and where it trips.

    `controller` is of the table `CONTROLLERS`, `params` its params record (None: its defaults). `law_bandwidth` (rad/s;
    None: see `bandwidth`) places the poles of the computed-torque error equation; `following_error` (rad; of joints
    that slide `slide_error`, m) and `trip_margin` (part of the rated speed and current by which they may be passed)
    stop an axis; `levels` are the periods and delays of the loops.

    Raises
    ------
    UnknownName
        A controller that there is not.
    OutOfLimits
        A bandwidth that the model's period does not bear.
    """

    controller: str = "cascade"
    params: Any = None
    law_bandwidth: float | None = None
    following_error: float = 0.1
    slide_error: float = 0.02
    trip_margin: float = 0.25
    levels: Levels = field(default_factory=Levels)

    def __post_init__(self) -> None:
        CONTROLLERS[self.controller]  # UnknownName
        acceleration_params(self.bandwidth, self.levels.model)  # OutOfLimits

    @property
    def bandwidth(self) -> float:
        """Of the computed-torque law, rad/s; unless stated what is usual, or the most that the model's period bears."""
        if self.law_bandwidth is not None:
            return self.law_bandwidth
        return min(ComputedTorqueSettings().law_bandwidth, greatest_bandwidth(self.levels.model))

    def error_of(self, joint: Joint) -> float:
        """Following error at which a joint stops, rad or m."""
        return self.following_error if joint.turns else self.slide_error

    def law(self) -> JointLaw | None:
        """Return the law where it is not a compiled one.

        Raises
        ------
        ModelError
            What the method makes is no `JointLaw`.
        """
        method = CONTROLLERS[self.controller]
        if method.record in LAWS:
            return None
        made = method.build(self.params if self.params is not None else CONTROLLERS.params(self.controller, {}))
        if not isinstance(made, JointLaw):
            raise ModelError(
                f"controller {self.controller!r} makes a {type(made).__name__}; a JointLaw is needed: an object with "
                "torques(arm, reference, position, speed, dt)"
            )
        return made


class ArmServos:
    """Servo loops of n axes. Mutable state: the records `states`, the count of steps `clock`.

    Parameters
    ----------
    arm
        Its model has a motor with drive and encoder data for each joint.
    q
        Joints (n,), rad, at whose inertia the loops are tuned and where they start.
    settings
        Controller and levels.

    Raises
    ------
    ModelError
        A joint without complete motor data.
    ShapeError
        Joints of another shape, or not finite.
    """

    def __init__(self, arm: Arm, q: ArrayLike, settings: ControlSettings = ControlSettings()) -> None:
        self.arm, self.settings = arm, settings
        self.mode = LAWS.get(CONTROLLERS[settings.controller].record, CURRENT)
        self.law = settings.law()
        self.timing = _timing(settings.levels)
        self.model = arm.kernel("inverse_dynamics")
        self.limits = [_axis_limits(arm.model, i, settings) for i in range(arm.n)]
        B = mass_matrix(arm.model, bodies_of(arm.model), joint_vector("q", q, arm.n).tolist())
        inertia = np.diagonal(np.array(B, dtype=float))
        designs = [_design(arm.model, i, float(b), settings) for i, b in enumerate(inertia)]
        self.warnings = [
            f"joint {joint.name!r}: {warning.text}"
            for joint, gains in zip(arm.model.joints, designs, strict=True)
            for warning in gains.warnings
        ]
        """What the design of its loops does not reach."""
        rows = [
            _servo(arm.model, i, float(b), gains, settings, limits)
            for i, (b, gains, limits) in enumerate(zip(inertia, designs, self.limits, strict=True))
        ]
        self.axes = record_table(rows, SERVO)
        self.states = np.zeros(arm.n, dtype=SERVO_STATE)
        self.clock = np.zeros(1, dtype=np.int64)
        self.scratch = np.zeros(4 * arm.n)
        self._ratio = self.axes["ratio"]

    def start(self, q: ArrayLike, hold: ArrayLike, signals: JointSignals) -> None:
        """Take over an arm that stands at q (n,), rad, under its own weight, with currents `hold` (n,), A; homed.

        Encoders know where they are; their counters are in `signals`.

        Raises
        ------
        ShapeError
            Joints or currents of another shape, or not finite.
        """
        states, currents = self.states, finite_array("hold", hold, (self.arm.n,))
        counts = np.floor(
            joint_vector("q", q, self.arm.n) * self._ratio * self.axes["encoder"]["counts_per_rad"]
        ).astype(np.int64)
        assert ((counts - signals.counters) % 0x10000 == 0).all(), "the counters are those of q"
        states["count"] = counts
        states["angle"] = (counts + 0.5) * self.axes["encoder"]["resolution"]
        for name in ("current_reference", "coming_reference", "speed_integral"):
            states[name] = currents
        states["current_integral"] = currents / self.axes["speed"]["conductance"]
        states["load"] = -self.axes["torque_constant"] * currents / self.axes["inertia"]

    @property
    def position(self) -> Array:
        """Measured joint positions (n,), rad."""
        found: Array = self.states["angle"] / self._ratio
        return found

    @property
    def speed(self) -> Array:
        """Measured joint speeds (n,), rad/s."""
        found: Array = self.states["rate"] / self._ratio
        return found

    def effort(self, currents: Array) -> Array:
        """Motor torques at the joints (n,), N m, by measured currents (n,), A."""
        found: Array = self._ratio * self.axes["torque_constant"] * currents
        return found

    def ask(self, law: JointLaw, reference: Array) -> None:
        """Take the current references of a law that is not compiled, within the drives' limits."""
        tau = np.asarray(law.torques(self.arm, reference, self.position, self.speed, self.settings.levels.model), float)
        if tau.shape != (self.arm.n,) or not np.isfinite(tau).all():
            raise LevelFault(
                f"controller {self.settings.controller!r} gave torques {tau.tolist()}; "
                f"{self.arm.n} finite numbers are needed"
            )
        most = self.axes["speed"]["max_current"]
        self.states["current_reference"] = np.clip(tau / (self._ratio * self.axes["torque_constant"]), -most, most)

    def fault(self, code: int, axis: int, time: float, reference: float, current: float) -> DriveFault:
        """Return the error for a limit that an axis left at a time (s)."""
        return drive_fault(
            Violation(code),
            self.limits[axis],
            axis=self.arm.model.joints[axis].name,
            time=time,
            reference=reference,
            position=float(self.position[axis]),
            speed=float(self.speed[axis]),
            current=current,
        )


def _timing(levels: Levels) -> ServoTiming:
    position, model = round(levels.servo / STEP), round(levels.model / STEP)
    return ServoTiming(SPEED_TICK, position, model, round(levels.delay / STEP))


def check_drives(model: ArmModel) -> None:
    """Raise `ModelError` where a joint lacks what its drive's simulation needs."""
    for joint in model.joints:
        joint_motor(joint)


def joint_motor(joint: Joint) -> DcMotor:
    """Return the motor of a joint.

    Raises
    ------
    ModelError
        It has none, or no encoder.
    """
    motor = joint.motor
    if motor is None or motor.encoder_counts == 0:
        raise ModelError(
            f"joint {joint.name!r} has no motor with drive and encoder data, so its drives cannot be simulated; "
            "give the model a complete Motor per joint, or size them from its limits"
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


def joint_friction(joint: Joint, ratio: float) -> Friction:
    """The joint's friction at its motor; a negative ratio swaps the directions.

    Raises
    ------
    ModelError
        Numbers that cannot be.
    """
    f = joint.friction
    if f is None:
        return Friction()
    positive, negative = f.coulomb_positive / abs(ratio), f.coulomb_negative / abs(ratio)
    if math.copysign(1.0, ratio) < 0.0:
        positive, negative = negative, positive
    return Friction(f.viscous / ratio**2, positive, negative, f.static_ratio, f.stribeck_speed * abs(ratio))


def _axis_limits(model: ArmModel, axis: int, settings: ControlSettings) -> AxisLimits:
    joint, limits = model.joints[axis], model.limits(axis)
    motor, margin, error = joint_motor(joint), 1.0 + settings.trip_margin, settings.error_of(joint)
    return AxisLimits(
        limits.lower - error,
        limits.upper + error,
        limits.speed * margin,
        motor.max_current * margin,
        error,
        joint.unit,
    )


def _design(model: ArmModel, axis: int, inertia: float, settings: ControlSettings) -> CascadeGains:
    """Gains of a joint whose inertia (rotor included) is known at its working point, kg m2."""
    joint = model.joints[axis]
    data, motor = joint.motor, joint_motor(joint)
    assert data is not None
    ratio = data.gear_ratio
    return design_cascade(
        ServoAxis(
            resistance=motor.resistance,
            inductance=motor.inductance,
            torque_constant=motor.torque_constant,
            back_emf_constant=motor.back_emf_constant,
            inertia=inertia / ratio**2,
            viscous=joint_friction(joint, ratio).viscous,
            max_voltage=motor.max_voltage,
            max_current=motor.max_current,
            max_speed=model.limits(axis).speed * abs(ratio),
            counts_per_rev=data.encoder_counts,
        ),
        times=SampleTimes(STEP, STEP * SPEED_TICK, settings.levels.servo),
    )


def _servo(
    model: ArmModel, axis: int, inertia: float, gains: CascadeGains, settings: ControlSettings, limits: AxisLimits
) -> Servo:
    """A joint's gains and what its controller knows of it."""
    data = model.joints[axis].motor
    assert data is not None
    ratio = data.gear_ratio
    return Servo(
        Encoder(data.encoder_counts).params(),
        tracking_params(gains.observer_bandwidth, gains.times.speed),
        gains.current,
        gains.speed,
        gains.position,
        acceleration_params(settings.bandwidth, settings.levels.model),
        limits.params(),
        ratio,
        data.torque_constant,
        inertia / ratio**2,
    )
