"""`simulate_axis`: one axis under its servo, with quantised angles, friction, backlash, limits and delays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.closed_loop.axis_kernels import ROWS, run_axis
from holonom.control import CascadeGains
from holonom.devices import tracking_params
from holonom.errors import OutOfLimits, ShapeError
from holonom.machine.axis.kernels import CURRENT_LOOP, POSITION_LOOP, SPEED_LOOP, AxisServoParams, AxisServoState
from holonom.sim.axis.axis import Axis

__all__ = ["AxisRun", "simulate_axis"]

OUTER = {"position": POSITION_LOOP, "speed": SPEED_LOOP, "current": CURRENT_LOOP}


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


def simulate_axis(
    axis: Axis,
    gains: CascadeGains,
    reference: ArrayLike,
    *,
    loop: Literal["position", "speed", "current"] = "position",
    load_torque: ArrayLike | None = None,
    start: float = 0.0,
    feed_forward: bool = True,
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

    Raises
    ------
    ShapeError
        A reference or a load of another shape, or not finite.
    OutOfLimits
        A loop that there is not; sample times of which one is no multiple of the one inside.
    """
    if loop not in OUTER:
        raise OutOfLimits(f"simulate_axis: loop is {loop!r}; it must be one of {', '.join(OUTER)}")
    given = _reference(reference)
    n, ratio = given.shape[1], axis.gear.ratio
    loads = _loads(axis, load_torque, n)
    at_motor = given if loop == "current" else ratio * given
    if not feed_forward or loop == "current":
        at_motor = np.stack([at_motor[0], np.zeros(n), np.zeros(n)])
    servo = _servo(axis, gains, OUTER[loop])
    dt = gains.times.current
    state, seen = axis.at(start), _standing(axis, start)
    log = np.empty((ROWS, n))
    run_axis(axis.plant(dt), servo, state, seen, np.ascontiguousarray(at_motor), loads, log)
    return AxisRun(
        time=gains.times.position * np.arange(n, dtype=float),
        reference=given[0].copy(),
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
    )


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


def _servo(axis: Axis, gains: CascadeGains, outer: int) -> AxisServoParams:
    times, m = gains.times, axis.servo_axis()
    rubbing = axis.rubbing
    coulomb = 0.5 * (rubbing.coulomb_positive + rubbing.coulomb_negative) + axis.load.coulomb / abs(axis.gear.ratio)
    inner = _multiple("speed", times.speed, times.current)
    return AxisServoParams(
        encoder=axis.encoder.params(),
        tracking=tracking_params(gains.observer_bandwidth, times.speed),
        current=gains.current,
        speed=gains.speed,
        position=gains.position,
        acceleration_per_ampere=m.torque_constant / m.inertia,
        viscous_current=m.viscous / m.torque_constant,
        friction_current=coulomb / m.torque_constant,
        speed_samples=inner,
        position_samples=_multiple("position", times.position, times.speed)
        * _multiple("speed", times.speed, times.current),
        outer=outer,
    )


def _multiple(name: str, slow: float, fast: float) -> int:
    count = round(slow / fast)
    if abs(count * fast - slow) > 1e-6 * slow:
        raise OutOfLimits(
            f"simulate_axis: the {name} loop samples every {slow:g} s; that must be a multiple of {fast:g} s, the "
            "sample time of the loop inside"
        )
    return count


def _standing(axis: Axis, start: float) -> AxisServoState:
    """What a servo knows of an axis that stands, homed, without current."""
    encoder = axis.encoder.params()
    count = math.floor(axis.gear.ratio * start * encoder.counts_per_rad)
    return AxisServoState(count, (count + 0.5) * encoder.resolution, *([0.0] * 10))
