"""Wheels of a base as its controller sees them: sensors, watch, force and speed of each, four at once in a register.

What is called `wheel` and `own` is four wheels and their states, `packed`. Whole numbers are taken lane by lane.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.base.force_kernels import allocation
from holonom.control.base.kernels import (
    BLIND,
    JAMMED,
    OFF,
    WORKS,
    Planar,
    Suspicion,
    TractionParams,
    WatchParams,
    traction_step,
    watch_step,
    watch_verdict,
    within_slip,
)
from holonom.control.servo.kernels import speed_step
from holonom.devices.encoders.kernels import EncoderParams, TrackingState, count_angle, extend_counter, tracking_step
from holonom.devices.transmission.kernels import friction_torque
from holonom.mobile.drive.slip_kernels import AMBIGUOUS, SLIP
from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH, largest, packed

__all__ = [
    "control_traction",
    "creep",
    "driven_part",
    "rim_force",
    "rim_speed",
    "sense",
    "set_weights",
    "share_force",
    "unseen_twist",
    "watch_motors",
    "wheel_voltage",
]

SLIPPING_WEIGHT = 0.3  # in the allocation of force: a wheel on ice is asked last
Integers = NDArray[np.int64]
Records = NDArray[np.void]


@loop(error_model="numpy", forceinline=True)
def sense(wheels: Any, states: Any, counters: Integers, currents: Any, block: int) -> None:
    """Counters, observers and shunts of four wheels, a block of those that are measured; their rim speeds, m/s."""
    wheel, own = packed(wheels), packed(states)
    for lane in range(WIDTH):
        encoder = EncoderParams(wheels.encoder.counts_per_rad[lane], wheels.encoder.resolution[lane])
        states.count[lane] = extend_counter(states.count[lane], counters[block * WIDTH + lane])
        states.counted[lane] = count_angle(encoder, states.count[lane])
    before = TrackingState(own.seen_angle, own.seen_speed, own.seen_load)
    after = tracking_step(wheel.tracking, before, own.counted, 0.0)
    own.seen_angle, own.seen_speed, own.seen_load = after.angle, after.speed, after.load
    own.measured_current = currents
    own.modelled_current = wheel.armature.conductance * (own.voltage - wheel.armature.back_emf * after.speed)
    own.rim = wheel.radius * after.speed / wheel.gear.ratio


@loop(error_model="numpy", forceinline=True)
def watch_motors(params: WatchParams, wheels: Records, states: Records, m: int, base: Any, held: bool) -> int:
    """Set (bit i: wheel i) of the motors that do not do as they are told; once lost they stay so.

    A jammed wheel holds the base (`held`), so that others may stand, too: they are not suspected of a jam any more.
    """
    lost = 0
    for i in range(m):
        wheel, own, lane = wheels[i // WIDTH], states[i // WIDTH], i % WIDTH
        if own.lost[lane] == WORKS:
            reference = wheel.gear.ratio[lane] * own.rim_reference[lane] / wheel.radius[lane]
            slips = base.status == SLIP or base.status == AMBIGUOUS
            explained = slips and base.flagged != 1 << i
            before = Suspicion(own.open[lane], own.stuck[lane], own.blind[lane])
            hidden = (own.modelled_current[lane] - own.measured_current[lane]) / (
                wheel.armature.conductance[lane] * wheel.armature.back_emf[lane]
            )
            after = watch_step(
                params, before, own.measured_current[lane], own.modelled_current[lane], own.seen_speed[lane],
                reference, explained, hidden,
            )  # fmt: skip
            after = Suspicion(after.open, 0.0 if held else after.jam, after.blind)
            own.open[lane], own.stuck[lane], own.blind[lane] = after.open, after.jam, after.blind
            own.lost[lane] = watch_verdict(params, after)
        if own.lost[lane] != WORKS:
            own.works[lane] = 0.0
            lost |= 1 << i
    return lost


@loop(error_model="numpy", forceinline=True)
def set_weights(traction: bool, bearing: Array, states: Records, named: int, trust: Array, weights: Array) -> int:
    """Which wheels are believed (one without current turns freely) and asked for force; set of those that jam."""
    jams = 0
    for i in range(len(weights)):
        slips, lost = (named >> i) & 1 == 1, states[i // WIDTH].lost[i % WIDTH]
        jams |= (1 << i) if lost == JAMMED else 0
        trust[i] = 0.0 if slips or lost in (JAMMED, BLIND, OFF) else 1.0
        weights[i] = 0.0 if lost != WORKS else bearing[i] * (SLIPPING_WEIGHT if slips and traction else 1.0)
    return jams


@loop(error_model="numpy", forceinline=True)
def share_force(rows: Array, pull: Array, weights: Array, share: Array, states: Records) -> None:
    """Share the force on the base among the wheels, in `share` (m, 3) and in their states.

    `rows` (m, 3) are rims per motion that wheels allow, `pull` (3, 3) takes a force on base_link to such motions.
    """
    allocation(rows, weights, share)
    for i in range(len(share)):
        a, b, c = share[i, 0], share[i, 1], share[i, 2]
        for j in range(3):
            share[i, j] = a * pull[0, j] + b * pull[1, j] + c * pull[2, j]
        own, lane = states[i // WIDTH], i % WIDTH
        own.force_x[lane], own.force_y[lane], own.force_turn[lane] = share[i, 0], share[i, 1], share[i, 2]


@loop(error_model="numpy", forceinline=True)
def unseen_twist(rows: Array, weights: Array) -> tuple[float, float, float, bool]:
    """Twist that turns none of the wheels that count, of length 1, and whether there is one.

    A row of the adjugate of their normal matrix; w counts by the rows' own lever.
    """
    xx = yy = ww = xy = xw = yw = lever = 0.0
    for i in range(rows.shape[0]):
        lever = max(lever, abs(rows[i, 2]))
    for i in range(rows.shape[0]):
        if weights[i] > 0.0:
            x, y, w = rows[i, 0], rows[i, 1], rows[i, 2] / lever
            xx, yy, ww, xy, xw, yw = xx + x * x, yy + y * y, ww + w * w, xy + x * y, xw + x * w, yw + y * w
    x0, y0, w0 = yy * ww - yw * yw, xw * yw - xy * ww, xy * yw - xw * yy
    y1, w1, w2 = xx * ww - xw * xw, xy * xw - xx * yw, xx * yy - xy * xy
    determinant, usual = xx * x0 + xy * y0 + xw * w0, (xx + yy + ww) / 3.0
    if determinant > 1e-9 * usual * usual * usual:
        return 0.0, 0.0, 0.0, False
    ux, uy, uw = x0, y0, w0
    if y1 >= x0 and y1 >= w2:
        ux, uy, uw = y0, y1, w1
    elif w2 >= x0 and w2 >= y1:
        ux, uy, uw = w0, w1, w2
    size = math.sqrt(ux * ux + uy * uy + uw * uw)
    if size <= 1e-12 * usual * usual:  # one wheel is left, or none: no one twist
        return 0.0, 0.0, 0.0, False
    return ux / size, uy / size, uw / size / lever, True


@loop(error_model="numpy", forceinline=True)
def rim_force(own: Any, force: Planar) -> Any:
    """Rim force (N) that is asked of a wheel, for a force on the base (N, N, N m)."""
    return own.force_x * force.x + own.force_y * force.y + own.force_turn * force.turn


@loop(error_model="numpy", forceinline=True)
def rim_speed(wheel: Any, twist: Planar) -> Any:
    """Rim speed (m/s) of a wheel that does not slip while the base has a twist."""
    return wheel.rim_x * twist.x + wheel.rim_y * twist.y + wheel.rim_turn * twist.turn


@loop(error_model="numpy", forceinline=True)
def driven_part(wheels: Records, states: Records, force: Planar) -> float:
    """Part (0 to 1) of a wanted force (N, N, N m) that no wheel needs more than its largest one for, by its shares."""
    worst = 1.0
    for i in range(len(states)):
        worst = max(worst, largest(abs(rim_force(packed(states[i]), force)) / packed(wheels[i]).max_force))
    return 1.0 / worst


@loop(error_model="numpy", forceinline=True)
def control_traction(params: TractionParams, wheel: Any, own: Any, ground: float, force: float) -> float:
    """Hold the commanded rim speed near the floor's; return the drive force (N) that is left.

    A Swedish wheel slips along its rollers' axes, by the cosine of their angle less than its rim.
    """
    part = wheel.roller_cosine
    own.cut = traction_step(params, own.cut, part * (own.rim - ground), own.current_reference * wheel.gear.ratio)
    own.rim_reference = within_slip(params, part * own.rim_reference, part * ground) / part
    return own.cut * force


@loop(error_model="numpy", forceinline=True)
def wheel_voltage(wheel: Any, own: Any, force: float, acceleration: float, ground: float) -> None:
    """Speed loop of a wheel and the voltage that it asks for, fed forward its rim's force (N), acceleration (m/s2).

    A wheel that is done without gets the back-emf of rolling with the ground (m/s): it neither drives nor brakes.
    """
    ratio, r = wheel.gear.ratio, wheel.radius
    speed = ratio * own.rim_reference / r
    torque = (force * r + wheel.inertia * acceleration / r) / (ratio * wheel.gear.efficiency)
    ahead = (torque + friction_torque(wheel.friction, speed)) / wheel.torque_constant
    current, integral = speed_step(wheel.speed_loop, own.integral, speed, own.seen_speed, ahead)
    supply, works = wheel.armature.max_voltage, own.works > 0.0
    voltage = current / wheel.armature.conductance + wheel.armature.back_emf * own.seen_speed
    voltage = select(works, voltage, wheel.armature.back_emf * ratio * ground / r)
    own.voltage = min(max(voltage, -supply), supply)
    own.current_reference, own.integral = select(works, current, 0.0), select(works, integral, 0.0)


@loop(error_model="numpy", forceinline=True)
def creep(full: float, used: float) -> float:
    """Slip (m/s) of the rim of a gripping wheel that uses a part of its grip; half as much again with all of it.

    Nearly the magic formula's, which rises without bound towards the peak.
    """
    part = min(max(used, -1.0), 1.0)
    return full * part * (1.0 + 0.5 * part * part)
