"""`simulate_axis`: one axis under its drive, with quantised angles, friction, backlash, limits, delays and faults."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array
from holonom.closed_loop.axis_faults import AxisFault, faults_of
from holonom.closed_loop.axis_kernels import ROWS, Plant, axis_runner
from holonom.control import CascadeGains, ServoGains
from holonom.control.servo.causes import Cause
from holonom.devices.encoders.quadrature.encoder import QuadratureEncoder
from holonom.devices.power.brake import BrakeState
from holonom.errors import OutOfLimits, ShapeError
from holonom.machine.axis.drive import OUTER, DriveSettings, drive_params, drive_start
from holonom.machine.axis.drive_records import NONE
from holonom.machine.axis.kernels import axis_servo_step
from holonom.machine.axis.law_kernels import law_servo_step
from holonom.sim.axis.axis import Axis

__all__ = ["AxisEvent", "AxisRun", "simulate_axis"]

LONGEST_STOP = 1.0  # s that a run goes on after its reference where a stop is under way


@dataclass(frozen=True, slots=True)
class AxisEvent:
    """A cause that the drive found: time, s; name (`Cause`); in words; whether it was the first, or follows from it."""

    time: float
    cause: Cause
    text: str
    first: bool


@dataclass(frozen=True, slots=True)
class AxisRun:
    """What an axis did, a sample each (n,) of the position loop.

    Attributes
    ----------
    time
        s.
    reference
        Of the outermost loop: rad, rad/s at the joint, or A.
    position, speed
        Of the joint as it truly is, rad and rad/s.
    motor_position, motor_speed, seen_position, seen_speed
        Of the motor's shaft; the last two as the controller believes.
    current, voltage, current_reference, speed_reference
        A, V, A, rad/s of the motor.
    square_current
        Mean of the squared current over each sample, A2.
    phase
        Of the drive: `machine.axis.drive_records`, OFF 0, CHECKING 1, RELEASING 2, RUNNING 3, SLOWING 4, CLOSING 5,
        HOLDING 6, BLIND 7, HOMING 8.
    events
        What the drive found, the first cause before what follows from it.
    """

    time: Array
    reference: Array
    position: Array
    speed: Array
    motor_position: Array
    motor_speed: Array
    seen_position: Array
    seen_speed: Array
    current: Array
    voltage: Array
    current_reference: Array
    speed_reference: Array
    square_current: Array
    phase: NDArray[np.int64]
    events: tuple[AxisEvent, ...]


def simulate_axis(
    axis: Axis,
    gains: CascadeGains | ServoGains,
    reference: ArrayLike,
    *,
    loop: Literal["position", "speed", "current"] = "position",
    load_torque: ArrayLike | None = None,
    start: float = 0.0,
    feed_forward: bool = True,
    drive: DriveSettings = DriveSettings(),
    known: Axis | None = None,
    faults: Iterable[AxisFault | str] = (),
    stop: tuple[float, int] | None = None,
) -> AxisRun:
    """Run an axis along a reference.

    Parameters
    ----------
    axis, gains
        What is moved, and gains of a servo (`SERVOS`); their sample times are those of the simulation.
    reference
        (n,) or (3, n) with two derivatives, a sample each of the position loop: rad, rad/s of the joint or A.
    loop, feed_forward
        The outermost loop; whether derivatives of the reference and friction are fed forward.
    load_torque, start
        On the joint against the positive direction, N m, a number or (n,); joint angle (rad) where it stands at first.
    drive, known
        How the drive starts, supervises, stops; the axis that it believes in where that is another one.
    faults, stop
        What breaks (a name alone: from the start); time (s) and category (0, 1, 2) of a stop that is asked for.

    Raises
    ------
    ShapeError
        A reference or a load of another shape, or not finite.
    OutOfLimits
        A loop that the servo has not, sample times that are no multiples, counts per turn that are none of four.
    """
    if loop not in OUTER:
        raise OutOfLimits(f"simulate_axis: loop is {loop!r}; it must be one of {', '.join(OUTER)}")
    given = _reference(reference)
    n, ratio, dt = given.shape[1], axis.gear.ratio, gains.times.current
    broken = tuple(AxisFault(fault) if isinstance(fault, str) else fault for fault in faults)
    at_motor = given if loop == "current" else ratio * given
    if not feed_forward or loop == "current":
        at_motor = np.stack([at_motor[0], np.zeros(n), np.zeros(n)])
    believed = known if known is not None else axis
    params = drive_params(believed.servo_axis(), believed.known_friction, gains, loop, drive, feed_forward)
    plant = _plant(axis, drive, broken, dt)
    asked_step, category = _stop(stop, dt)
    goes_on = stop is not None or broken or drive.start == "off"
    ticks = n + (round(LONGEST_STOP / gains.times.position) if goes_on else 0)
    log, events = np.empty((ROWS, ticks)), np.zeros((16, 2), dtype=np.int64)
    many = _runner(gains)(
        plant, params, axis.at(start), QuadratureEncoder(plant.encoder.quarters_per_rev // 4).start(ratio * start),
        BrakeState(1 if drive.start == "off" else 0, 0),
        drive_start(params, drive, math.floor(ratio * start / axis.encoder.resolution)),
        np.ascontiguousarray(at_motor), _loads(axis, load_torque, n), asked_step, category, log, events,
    )  # fmt: skip
    return _run(log, given[0], ratio, gains.times.position, dt, events[:many])


def _runner(gains: CascadeGains | ServoGains) -> Any:
    """The compiled run under a servo."""
    return axis_runner(law_servo_step, False) if isinstance(gains, ServoGains) else axis_runner(axis_servo_step, True)


def _run(log: Array, reference: Array, ratio: float, tick: float, dt: float, events: NDArray[np.int64]) -> AxisRun:
    """What the log says, at the joint."""
    return AxisRun(
        time=tick * np.arange(log.shape[1], dtype=float),
        reference=np.interp(log[11], np.arange(len(reference)), reference),
        position=log[0] / ratio,
        speed=log[2] / ratio,
        motor_position=log[1],
        motor_speed=log[3],
        seen_position=log[12],
        seen_speed=log[9],
        current=log[4],
        voltage=log[5],
        current_reference=log[6],
        speed_reference=log[7],
        square_current=log[8],
        phase=log[10].astype(np.int64),
        events=tuple(
            AxisEvent(step * dt, Cause(code), Cause(code).text, e == 0)
            for e, (step, code) in enumerate(events.tolist())
        ),
    )


def _plant(axis: Axis, drive: DriveSettings, faults: tuple[AxisFault, ...], dt: float) -> Plant:
    """Params of the plant with what is wrong with it from the start."""
    encoder, brake = _encoder(axis), drive.brake.params(dt)
    for fault in faults:
        if fault.kind == "wrong_counts":
            encoder = QuadratureEncoder(round(fault.value / 4))
        if fault.kind == "brake_slips":
            brake = brake._replace(torque=fault.value)
    per_rad = axis.servo_axis().load_counts / (2.0 * math.pi)
    return Plant(axis.plant(dt), encoder.params(), per_rad, brake, faults_of(faults, axis.motor.max_voltage, dt))


def _encoder(axis: Axis) -> QuadratureEncoder:
    counts = axis.encoder.counts_per_rev
    if counts % 4:
        raise OutOfLimits(
            f"simulate_axis: the encoder has {counts} counts per turn; with 4x decoding they are a multiple of four"
        )
    return QuadratureEncoder(counts // 4)


def _stop(stop: tuple[float, int] | None, dt: float) -> tuple[int, int]:
    """Step and category."""
    if stop is None:
        return -1, NONE
    time, category = stop
    if category not in (0, 1, 2) or not 0.0 <= time < math.inf:
        raise OutOfLimits(
            f"simulate_axis: stop is {stop!r}; it must be a time (s, at least 0) and a category 0, 1 or 2"
        )
    return round(time / dt), category


def _reference(reference: ArrayLike) -> Array:
    given = np.asarray(reference, dtype=float)
    if given.ndim == 1:
        given = np.stack([given, np.zeros_like(given), np.zeros_like(given)])
    if given.ndim != 2 or given.shape[0] != 3:
        raise ShapeError(
            f"reference: shape {np.shape(reference)} came; (n,) or (3, n) finite numbers are needed, a sample each of "
            "the position loop"
        )
    _finite("reference", given)
    return given


def _finite(name: str, given: Array) -> None:
    if not np.isfinite(given).all():
        at = np.argwhere(~np.isfinite(given))[0]
        raise ShapeError(
            f"{name}: {given[tuple(at)]} came at sample {at[-1] if len(at) else 0}; finite numbers are needed"
        )


def _loads(axis: Axis, load_torque: ArrayLike | None, n: int) -> Array:
    """At the motor's shaft, N m."""
    torque = np.asarray(0.0 if load_torque is None else load_torque, dtype=float)
    if torque.shape not in ((), (n,)):
        raise ShapeError(f"load_torque: shape {torque.shape} came; a number or ({n},) finite numbers are needed")
    _finite("load_torque", torque)
    return np.ascontiguousarray(np.broadcast_to((torque + axis.load.torque) / axis.gear.ratio, n))
