"""`simulate_axis`: one axis under its drive, with quantised angles, friction, backlash, limits, delays and faults."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array
from holonom.closed_loop.axis_faults import AxisFault, faults_of
from holonom.closed_loop.axis_kernels import ROWS, Plant, run_axis
from holonom.control import CascadeGains
from holonom.control.servo.causes import Cause
from holonom.devices import Friction
from holonom.devices.encoders.quadrature.encoder import QuadratureEncoder
from holonom.devices.power.brake import BrakeState
from holonom.errors import OutOfLimits, ShapeError
from holonom.machine.axis.drive import OUTER, DriveSettings, drive_params, drive_start
from holonom.machine.axis.drive_kernels import NONE
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
    motor_position, motor_speed, seen_speed
        Of the motor's shaft; the last one as the controller believes.
    current, voltage, current_reference, speed_reference
        A, V, A, rad/s of the motor.
    square_current
        Mean of the squared current over each sample, A2.
    phase
        Of the drive: `machine.axis.drive_kernels`, OFF 0, CHECKING 1, RELEASING 2, RUNNING 3, SLOWING 4, CLOSING 5,
        HOLDING 6, BLIND 7.
    events
        What the drive found, the first cause before what follows from it.
    """

    time: Array
    reference: Array
    position: Array
    speed: Array
    motor_position: Array
    motor_speed: Array
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
    gains: CascadeGains,
    reference: ArrayLike,
    *,
    loop: Literal["position", "speed", "current"] = "position",
    load_torque: ArrayLike | None = None,
    start: float = 0.0,
    feed_forward: bool = True,
    drive: DriveSettings = DriveSettings(),
    known: Axis | None = None,
    faults: Iterable[AxisFault] = (),
    stop: tuple[float, int] | None = None,
) -> AxisRun:
    """Run an axis along a reference.

    Parameters
    ----------
    axis
        What is moved.
    gains
        Of `design_cascade`; their sample times are those of the simulation.
    reference
        A sample each of the position loop: (n,) or (3, n) with its first two derivatives, which are fed forward.
        Joint angles (rad), speeds (rad/s) or currents (A), by `loop`.
    loop
        The outermost loop.
    load_torque
        Torque (N m) on the joint against the positive direction, a number or (n,), beside that of `axis.load`.
    start
        Joint angle (rad) at which it stands at first.
    feed_forward
        Whether the derivatives of the reference act.
    drive
        How the drive starts, what it supervises, how it stops.
    known
        The axis that its controller believes in, where it is another one: its sheets, not what they are out by.
    faults
        What breaks.
    stop
        Time (s) and category (0, 1, 2) of a stop that is asked for.

    Raises
    ------
    ShapeError
        A reference or a load of another shape, or not finite.
    OutOfLimits
        A loop that there is not; sample times of which one is no multiple of the one inside; an encoder whose counts per
        turn are no multiple of four; a stop of another category; faults that exclude each other.
    """
    if loop not in OUTER:
        raise OutOfLimits(f"simulate_axis: loop is {loop!r}; it must be one of {', '.join(OUTER)}")
    given = _reference(reference)
    n, ratio, dt, tick = given.shape[1], axis.gear.ratio, gains.times.current, gains.times.position
    loads = _loads(axis, load_torque, n)
    at_motor = given if loop == "current" else ratio * given
    if not feed_forward or loop == "current":
        at_motor = np.stack([at_motor[0], np.zeros(n), np.zeros(n)])
    believed = known if known is not None else axis
    friction = believed.known_friction if feed_forward else Friction()
    params = drive_params(believed.servo_axis(), friction, gains, loop, drive)
    faults = tuple(faults)
    encoder = _encoder(axis)
    brake = drive.brake.params(dt)
    for fault in faults:
        if fault.kind == "wrong_counts":
            encoder = QuadratureEncoder(round(fault.value / 4))
        if fault.kind == "brake_slips":
            brake = brake._replace(torque=fault.value)
    plant = Plant(axis.plant(dt), encoder.params(), brake, faults_of(faults, axis.motor.max_voltage, dt))
    state, shaft = axis.at(start), encoder.start(ratio * start)
    own = drive_start(params, drive, math.floor(ratio * start / axis.encoder.resolution))
    asked_step, category = _stop(stop, dt)
    ticks = n + (round(LONGEST_STOP / tick) if stop is not None or faults or drive.start == "off" else 0)
    log, events = np.empty((ROWS, ticks)), np.zeros((16, 2), dtype=np.int64)
    many = run_axis(
        plant, params, state, shaft, BrakeState(1 if drive.start == "off" else 0, 0), own,
        np.ascontiguousarray(at_motor), loads, asked_step, category, log, events,
    )  # fmt: skip
    asked = np.interp(log[11], np.arange(n), given[0])
    return AxisRun(
        time=tick * np.arange(ticks, dtype=float),
        reference=asked,
        position=log[0] / ratio,
        speed=log[2] / ratio,
        motor_position=log[1],
        motor_speed=log[3],
        seen_speed=log[9],
        current=log[4],
        voltage=log[5],
        current_reference=log[6],
        speed_reference=log[7],
        square_current=log[8],
        phase=log[10].astype(np.int64),
        events=tuple(
            AxisEvent(step * dt, Cause(code), Cause(code).text, e == 0)
            for e, (step, code) in enumerate(events[:many].tolist())
        ),
    )


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
    if given.ndim != 2 or given.shape[0] != 3 or not np.isfinite(given).all():
        raise ShapeError(
            f"reference: shape {np.shape(reference)} came; (n,) or (3, n) finite numbers are needed, a sample each of "
            "the position loop"
        )
    return given


def _loads(axis: Axis, load_torque: ArrayLike | None, n: int) -> Array:
    """At the motor's shaft, N m."""
    torque = np.asarray(0.0 if load_torque is None else load_torque, dtype=float)
    if torque.shape not in ((), (n,)) or not np.isfinite(torque).all():
        raise ShapeError(f"load_torque: shape {torque.shape} came; a number or ({n},) finite numbers are needed")
    return np.ascontiguousarray(np.broadcast_to((torque + axis.load.torque) / axis.gear.ratio, n))
