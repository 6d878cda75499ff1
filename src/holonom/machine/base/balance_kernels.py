"""A base that balances its body, compiled: estimate of its pitch, the motion asked of it, voltages of its wheels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.balance.kernels import (
    BalanceGains,
    Tilt,
    TiltParams,
    Upright,
    asked_lean,
    balance_step,
    level_acceleration,
    tilt_ahead,
    tilt_step,
    trim_step,
)
from holonom.control.base.kernels import Planar
from holonom.devices.drive_signals import WheelSignals
from holonom.devices.transmission.kernels import friction_torque
from holonom.machine.base.wheel_kernels import rim_force, rim_speed
from holonom.trace.code.compiled import select, sincos
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import load, packed, store

__all__ = ["HOLD", "PATH", "VELOCITY", "BalanceParams", "balance", "look_at_pitch", "turn_with_body", "weigh_wheels"]

PATH, VELOCITY, HOLD = 0, 1, 2
"""What a base does: it keeps a path, follows velocities, holds its pose."""
Records = NDArray[np.void]


class BalanceParams(NamedTuple):
    """A body that balances: gains of its law, its rest, and the motion that fits an acceleration."""

    gains: BalanceGains
    tilt: TiltParams
    radius: float  # of the wheels, m
    rest: float  # pitch at which it stands, rad
    lean: float  # pitch per steady acceleration, rad s2/m
    time: float  # s, of its falling on wheels that run as they are told
    mass: float  # force per acceleration, kg, and per that of the pitch, kg m
    coupling: float
    most: float  # m, of the place that velocities leave behind


@loop(error_model="numpy", forceinline=True)
def look_at_pitch(params: BalanceParams | None, base: Any, signals: WheelSignals) -> None:
    """Pitch by gyro and accelerometers; turning rate and acceleration level with the floor."""
    if params is None:
        return
    ahead, rate, up = signals.inertial[1], signals.inertial[3], signals.inertial[4]
    before = Tilt(base.seen_along, base.seen_pitch, base.pitch_bias)
    after = tilt_ahead(params.tilt, before, rate, ahead, up)
    base.seen_along, base.seen_pitch, base.seen_pitch_rate = after.speed, after.pitch, rate - after.bias
    _, c = sincos(after.pitch)
    base.gyro = signals.inertial[0] / max(c, 0.5)
    base.imu_x = level_acceleration(after.pitch, ahead, up)


@loop(error_model="numpy", forceinline=True)
def turn_with_body(params: BalanceParams | None, base: Any, states: Records, rims: Array, gripping: Array) -> None:
    """Rim speeds against the floor: the motors count against the body, which pitches."""
    if params is None:
        return
    more = params.radius * base.seen_pitch_rate
    for i in range(len(states)):
        own = packed(states[i])
        own.rim = own.rim + more
        store(rims, i, own.rim)
        store(gripping, i, load(gripping, i) + more)


@loop(error_model="numpy", forceinline=True)
def weigh_wheels(params: BalanceParams | None, rows: Array, base: Any, rims: Array) -> None:
    """Correct the pitch by the speed that the wheels measure."""
    if params is None:
        return
    along = square = 0.0
    for i in range(len(rows)):
        along += rows[i, 0] * rims[i]
        square += rows[i, 0] * rows[i, 0]
    after = tilt_step(params.tilt, Tilt(base.seen_along, base.seen_pitch, base.pitch_bias), along / square)
    base.seen_along, base.seen_pitch, base.pitch_bias = after.speed, after.pitch, after.bias


@loop(error_model="numpy", forceinline=True)
def lead(params: BalanceParams | None, base: Any, now: Array) -> None:
    """Take speed and turning rate of a reference to what a body can follow that must lean before it speeds up.

    Notes
    -----
    z follows each as a filter of third order at `1/time` does; `v = z - t^2 z''`, `phi = k z'` then keep
    `t^2 phi'' = phi - k v'` exactly: the wheels run back first. Both alike, so that curves are kept.
    """
    if params is None:
        return
    dt, w, square = params.tilt.dt, 1.0 / params.time, params.time * params.time
    base.led_jerk = w * (w * (w * (now[3] - base.led) - 3.0 * base.led_rate) - 3.0 * base.led_change)
    base.led_change += dt * base.led_jerk
    base.led_rate += dt * base.led_change
    base.led += dt * base.led_rate
    jerk = w * (w * (w * (now[5] - base.led_turn) - 3.0 * base.led_turn_rate) - 3.0 * base.led_turn_change)
    base.led_turn_change += dt * jerk
    base.led_turn_rate += dt * base.led_turn_change
    base.led_turn += dt * base.led_turn_rate
    now[3], now[6] = base.led - square * base.led_change, base.led_rate - square * base.led_jerk
    now[5], now[8] = base.led_turn - square * base.led_turn_change, base.led_turn_rate - square * jerk


@loop(error_model="numpy", forceinline=True)
def balance(
    params: BalanceParams | None, base: Any, lean: Array, now: Array, wanted: Planar, signals: WheelSignals,
    wheels: Records, states: Records, command: Planar, turning: Planar,
) -> bool:  # fmt: skip
    """Voltages that keep the body up: force along the way by its law, torque about the vertical axis as it is wanted.

    False where no body balances. `lean` (N, 3) are pitch, its rate and force that fit a path; the place of velocities
    is where they would have led. `turning` is the torque on the base.
    """
    if params is None:
        return False
    e = now[2] - base.seen_theta
    s, c = sincos(base.seen_theta)
    _, d = sincos(e)
    speed = d * now[3]
    pitch = rate = force = 0.0
    k = int(base.phase)
    if base.mode == VELOCITY:
        pitch, rate = params.lean * base.led_rate, params.lean * base.led_change
        force = params.mass * now[6] + params.coupling * params.lean * base.led_jerk
        gone = base.ahead_of + params.tilt.dt * (base.seen_along - speed)
        base.ahead_of = min(max(gone, -params.most), params.most)
    else:
        base.ahead_of = c * (base.seen_x - now[0]) + s * (base.seen_y - now[1])
        if base.mode == PATH and k < len(lean):
            pitch, rate, force = lean[k, 0], lean[k, 1], lean[k, 2]
    seen = Upright(base.seen_pitch - params.rest, base.seen_pitch_rate, base.seen_along, base.ahead_of)
    asked = Upright(pitch, rate, speed, 0.0)
    base.trim = trim_step(params.gains, params.tilt.dt, base.trim, asked_lean(params.gains, seen, asked))
    push = balance_step(params.gains, seen, asked, force, base.trim)
    shared = Planar(push, 0.0, turning.turn)
    spun = Planar(0.0, 0.0, wanted.turn)
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        own.rim_reference = rim_speed(wheel, command)
        _torque_voltage(wheel, own, rim_force(own, shared), rim_speed(wheel, spun))
        store(signals.voltages, i, own.voltage)
        store(signals.speeds, i, own.works * own.rim_reference / wheel.radius)
    return True


@loop(error_model="numpy", forceinline=True)
def _torque_voltage(wheel: Any, own: Any, force: Any, acceleration: Any) -> None:
    """Voltage of a wheel for a rim force (N), and the acceleration (m/s2) of its rim that is not in that."""
    ratio, r = wheel.gear.ratio, wheel.radius
    bounded = min(max(force, -wheel.max_force), wheel.max_force)
    torque = (bounded * r + wheel.inertia * acceleration / r) / (ratio * wheel.gear.efficiency)
    current = (torque + friction_torque(wheel.friction, own.seen_speed)) / wheel.torque_constant
    supply, works = wheel.armature.max_voltage, own.works > 0.0
    voltage = current / wheel.armature.conductance + wheel.armature.back_emf * own.seen_speed
    own.voltage = select(works, min(max(voltage, -supply), supply), 0.0)
    own.current_reference = select(works, current, 0.0)
