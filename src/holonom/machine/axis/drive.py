"""Settings of an axis's drive, and the params and first state of its compiled step."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from holonom.control import CascadeGains, ServoAxis, ServoGains
from holonom.control.servo.axis import SampleTimes
from holonom.control.servo.kernels import LimitParams
from holonom.control.servo.law_kernels import LAW_START, THREE_LOOPS, LawParams, LawState
from holonom.control.servo.watch_kernels import WATCH_START, DriveWatchParams
from holonom.devices import Encoder, Friction, tracking_params
from holonom.devices.encoders.counters.index import INDEX_START, IndexCorrection
from holonom.devices.encoders.homing.potentiometer import PotentiometerHoming
from holonom.devices.encoders.homing.states import HOMING_START
from holonom.devices.encoders.kernels import EncoderParams
from holonom.devices.motors.dc_motor import mean_weight
from holonom.devices.power.brake import Brake
from holonom.errors import OutOfLimits
from holonom.machine.axis.drive_records import (
    CHECKING,
    RUNNING,
    AxisDriveParams,
    AxisDriveState,
    CheckParams,
    StopParams,
)
from holonom.machine.axis.kernels import (
    CURRENT_LOOP,
    POSITION_LOOP,
    SPEED_LOOP,
    AxisServoParams,
    AxisServoState,
    powered,
    standing,
)
from holonom.registry import check_fields, parameter

__all__ = ["OUTER", "DriveSettings", "drive_params", "drive_start"]

OUTER = {"position": POSITION_LOOP, "speed": SPEED_LOOP, "current": CURRENT_LOOP}
LEAST_SPEED = 5e-3  # of the no-load speed: what both witnesses of the speed may differ by
CONSTANT_ERROR = 0.05  # part by which a back-emf constant may differ from its sheet
INDUCTANCE_ERROR = 0.12  # part by which an inductance may
PATIENCE = 3  # looks
EDGES, WINDOW = 8, 10  # edges of one channel alone within so many looks
BAD_FRAMES = 3
LOOP_DELAY = 1.5  # samples: computing and hold
TURN = 2.0 * math.pi
ZERO_TIME, TORQUE_TIME = 0.01, 0.025  # s of the self-check: the shunt's zero, the test torque each way


@dataclass(frozen=True, slots=True)
class DriveSettings:
    """How a drive starts, what it watches, how it stops.

    Raises
    ------
    OutOfLimits
        A number outside its range, another way to start.
    """

    start: Literal["powered", "off"] = "powered"
    """Whether it holds the axis from the first sample, its checks long done, or begins with self-check and brake."""
    supervised: bool = True
    prefilter: bool = True
    """Whether a reference of the speed loop passes 1/(1 + s Ti), which takes the overshoot of its zero."""
    brake: Brake = field(default_factory=lambda: Brake(1e3))
    homing: PotentiometerHoming | None = None
    """How it finds its zero after power-on, from a potentiometer that reads rad of the motor; None: it knows it."""
    hold: float = parameter(0.0, meaning="torque at the motor that the model says carries the load", unit="N m")
    following_error: float = parameter(
        math.inf, meaning="at which it stops, motor", unit="rad", above=0.0, most=math.inf
    )
    lower: float = parameter(-math.inf, meaning="position limit, motor", unit="rad", least=-math.inf)
    upper: float = parameter(math.inf, meaning="position limit, motor", unit="rad", most=math.inf)
    trip: float = parameter(1.3, meaning="part of greatest speed at which it stops", above=1.0)
    stop_time: float = parameter(
        0.2, meaning="in which a path comes to its end in a controlled stop", unit="s", above=0.0
    )
    settling: float = parameter(0.02, meaning="in which an axis settles", unit="s", least=0.0)
    test_current: float = parameter(0.2, meaning="of the self-check, part of the greatest", above=0.0, most=1.0)
    brake_turns: float = parameter(0.02, meaning="turn against the closed brake, motor", unit="rad", above=0.0)
    apart: float = parameter(math.pi, meaning="counter and potentiometer, motor", unit="rad", above=0.0)
    supply_error: float = parameter(0.15, meaning="part by which the supply may be off", above=0.0)
    greatest_zero: float = parameter(0.03, meaning="current sensor's zero, part of the greatest current", above=0.0)
    resistance_error: float = parameter(
        0.03, meaning="part by which a winding may differ from what the self-check measured", above=0.0
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if self.homing is not None and self.start != "off":
            raise OutOfLimits(
                'DriveSettings: homing comes with start = "powered"; a drive looks for its zero after "off"'
            )
        if self.start not in ("powered", "off"):
            raise OutOfLimits(f'DriveSettings: start is {self.start!r}; it must be "powered" or "off"')


def drive_params(
    axis: ServoAxis, friction: Friction, gains: CascadeGains | ServoGains, loop: str, settings: DriveSettings,
    feed_forward: bool = True,
) -> AxisDriveParams:  # fmt: skip
    """Params of `drive_step` for an axis, its friction at the motor as it is known (fed forward or not), and gains.

    Raises
    ------
    OutOfLimits
        Sample times of which one is no multiple of the one inside.
    """
    s, times = settings, gains.times
    encoder = Encoder(round(axis.counts_per_rev))
    limits = LimitParams(s.lower, s.upper, s.trip * axis.max_speed, 1.5 * axis.max_current, s.following_error)
    stop = StopParams(
        slowing=times.position / s.stop_time,
        samples=1.0 / times.position,
        opening=round(s.brake.release / times.current),
        closing=round(s.brake.engage / times.current),
        settling=round(s.settling / times.current),
        emf_gain=gains.speed.gain,
        slow=2.0 * LEAST_SPEED * axis.max_voltage / axis.back_emf_constant,
    )
    return AxisDriveParams(
        _servo_params(axis, friction if feed_forward else Friction(), gains, loop, s.prefilter, encoder),
        _watch_params(axis, friction, times, s.resistance_error, encoder),
        IndexCorrection(encoder.counts_per_rev, each_crossing=False).params(),
        limits,
        _check_params(axis, times.current, s, encoder),
        stop,
        s.hold / axis.torque_constant,
        s.supervised,
        (s.homing or PotentiometerHoming(encoder.counts_per_rev, encoder.counts_per_rev / TURN)).params(times.speed),
        s.homing is not None,
    )


def _servo_params(
    axis: ServoAxis, friction: Friction, gains: CascadeGains | ServoGains, loop: str, prefilter: bool, encoder: Encoder
) -> AxisServoParams:
    times = gains.times
    law: LawParams | tuple[()] = ()
    start: LawState | tuple[()] = ()
    if isinstance(gains, ServoGains):
        law, start = gains.law, LAW_START
        if gains.law.form != THREE_LOOPS and loop == "current":
            raise OutOfLimits("simulate_axis: loop is 'current'; this servo has no such loop of its own")
    inner = _multiple("speed", times.speed, times.current)
    coulomb = 0.5 * (friction.coulomb_positive + friction.coulomb_negative)
    return AxisServoParams(
        encoder=encoder.params(),
        tracking=tracking_params(gains.observer_bandwidth, times.speed),
        current=gains.current,
        speed=gains.speed,
        position=gains.position,
        acceleration_per_ampere=axis.torque_constant / axis.inertia,
        viscous_current=friction.viscous / axis.torque_constant,
        friction_current=coulomb / axis.torque_constant,
        speed_samples=inner,
        position_samples=inner * _multiple("position", times.position, times.speed),
        outer=OUTER[loop],
        speed_lead=LOOP_DELAY if loop == "position" else 0.0,
        acceleration_lead=LOOP_DELAY * times.speed / times.position,
        following=_followed(gains) if prefilter else 1.0,
        load_encoder=_load_encoder(axis, encoder),
        law=law,
        law_start=start,
    )


def _followed(gains: CascadeGains | ServoGains) -> float:
    """Part of `1/(1 + s Ti)` in a sample of the speed loop; without an integral there is nothing to take out."""
    part = gains.speed.integral_gain / gains.speed.gain
    if isinstance(gains, ServoGains) and gains.law.tachometer:
        part *= gains.times.speed / gains.times.current
    return min(part, 1.0) if part > 0.0 else 1.0


def _load_encoder(axis: ServoAxis, encoder: Encoder) -> EncoderParams:
    """Of the load, at the motor; where there is none, the motor's."""
    per_rad = axis.load_counts / (2.0 * math.pi)
    return EncoderParams(per_rad, 1.0 / per_rad) if per_rad > 0.0 else encoder.params()


def _watch_params(
    axis: ServoAxis, friction: Friction, times: SampleTimes, resistance_error: float, encoder: Encoder
) -> DriveWatchParams:
    most = max(friction.coulomb_positive, friction.coulomb_negative) * friction.static_ratio  # at rest
    return DriveWatchParams(
        dt=times.speed,
        resolution=encoder.resolution,
        inductance=axis.inductance,
        back_emf=axis.back_emf_constant,
        resistance=axis.resistance,
        least_speed=LEAST_SPEED * axis.max_voltage / axis.back_emf_constant,
        resistance_error=resistance_error,
        inductance_error=INDUCTANCE_ERROR,
        constant_error=CONSTANT_ERROR,
        patience=PATIENCE,
        edges=EDGES,
        window=WINDOW,
        max_current=axis.max_current,
        max_voltage=axis.max_voltage,
        bad_frames=BAD_FRAMES,
        acceleration_per_ampere=axis.torque_constant / axis.inertia,
        friction_current=most / axis.torque_constant,
        skew=times.current / times.speed,
        current_before=1.0 - mean_weight(times.current * axis.resistance / axis.inductance),
    )


def _check_params(axis: ServoAxis, dt: float, settings: DriveSettings, encoder: Encoder) -> CheckParams:
    s = settings
    return CheckParams(
        zero_steps=round(ZERO_TIME / dt),
        torque_steps=2 * round(TORQUE_TIME / dt),
        greatest_zero=s.greatest_zero * axis.max_current,
        least_supply=(1.0 - s.supply_error) * axis.max_voltage,
        most_supply=(1.0 + s.supply_error) * axis.max_voltage,
        current=s.test_current * axis.max_current,
        turns=math.ceil(s.brake_turns / encoder.resolution),
        apart=s.apart if s.homing is None else math.inf,
    )


def drive_start(params: AxisDriveParams, settings: DriveSettings, count: int) -> AxisDriveState:
    """First state of a drive whose counter is at zero where the homed count is `count`."""
    zero = count if settings.homing is None else 0
    nothing = AxisServoState(zero, zero, *([0.0] * 11), params.servo.law_start)  # type: ignore[call-arg]
    servo = standing(params.servo, nothing, 0)
    phase = CHECKING
    if settings.start == "powered":
        servo, phase = powered(servo, params.hold), RUNNING
    watch = WATCH_START._replace(resistance=params.watch.resistance)
    on = 1 if phase == RUNNING else 0
    return AxisDriveState(
        servo, watch, INDEX_START, HOMING_START, phase, 0, 0.0, float(on), servo.angle, 0, 0.0, 0.0, params.hold, 0.0,
        0.0, 0, 1 - on, on, 0, 0,
    )  # fmt: skip


def _multiple(name: str, slow: float, fast: float) -> int:
    count = round(slow / fast)
    if abs(count * fast - slow) > 1e-6 * slow:
        raise OutOfLimits(
            f"simulate_axis: the {name} loop samples every {slow:g} s; that must be a multiple of {fast:g} s, the "
            "sample time of the loop inside"
        )
    return count
