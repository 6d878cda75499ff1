"""One millisecond of a base's controller, compiled: sensors, estimate, path or velocity, wheel loops.

What it knows comes from counters, shunts, gyro and accelerometers only. Records in `records.py`, what is done wheel by
wheel in `wheel_kernels.py`, the loops' steps in `control.base.kernels`, slip detection in `mobile.drive.slip_kernels`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.base.force_kernels import feasible_rate, wrench_of
from holonom.control.base.kernels import (
    BLIND,
    OFF,
    EstimateParams,
    KeepingParams,
    Planar,
    estimate_step,
    keeping_step,
    pose_step,
    reference_at,
    wanted_acceleration,
)
from holonom.control.base.shaping_kernels import awake, drivable_twist, shaping_step
from holonom.control.base.skid_kernels import SkidParams, skid_twist
from holonom.control.path_laws.compiled import law_step
from holonom.control.path_laws.kanayama import line_keeping_step
from holonom.devices.drive_signals import WheelSignals
from holonom.machine.base.balance_kernels import (
    HOLD,
    PATH,
    VELOCITY,
    balance,
    lead,
    look_at_pitch,
    turn_with_body,
    weigh_wheels,
)
from holonom.machine.base.check_kernels import (
    check_inertia,
    detect_slip,
    drives_on,
    members,
    pin,
    pinned,
    watch_pushes,
    watch_steering,
)
from holonom.machine.base.params import BaseParams, BaseTask, Work
from holonom.machine.base.steering_kernels import allowed, eased, look_at, ready, rim_change, set_off, steer_along
from holonom.machine.base.wheel_kernels import (
    control_traction,
    creep,
    driven_part,
    rim_force,
    rim_speed,
    sense,
    set_weights,
    share_force,
    unseen_twist,
    watch_motors,
    wheel_voltage,
)
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH, load, packed, store

__all__ = [
    "DONE",
    "HOLD",
    "KEEP_BOTH",
    "KEEP_HEADING",
    "KEEP_PATH",
    "PATH",
    "RUNNING",
    "STOPPED",
    "VELOCITY",
    "control_step",
    "path_ending",
    "say",
]

RUNNING, DONE, STOPPED = 0, 1, 2
"""How far its path is: under way, at its end, stopped by a jammed wheel."""
KEEP_BOTH, KEEP_PATH, KEEP_HEADING = 0, 1, 2
"""What is kept where the motors that are left cannot hold path and heading at once."""
CREEPS = 0.01  # m/s of a rim, from which on a base does not stand
LEARNED = 20  # samples at rest, from which on a slope is believed beyond it
THERE = 2e-3  # m from where it is to be, from which on it goes there
SLOW = 0.2  # m/s, below which the way that a base goes is not told from the one that it looks
SLOW_TURN = 0.3  # rad/s, below which little is learned of how much wheels skid
LEARNING = 4.0  # 1/s
LEANING = 0.1  # s, over which the way is averaged: it swings with the turning rate, which a law would only excite
MOST_SKID = 0.8  # part by which wheels may turn a base more, or less, than they would without skidding
STANDING = 500  # ms after which a base that had to stop is done
Records = NDArray[np.void]


@loop(error_model="numpy", forceinline=True)
def control_step(
    params: BaseParams,
    task: BaseTask,
    signals: WheelSignals,
    state: Records,
    wheels: Records,
    states: Records,
    work: Work,
) -> None:
    """From what is measured to voltages, in `signals`; all that evolves is in `state`, `states` and `work`."""
    base = state[0]
    base.gyro, base.raw_x, base.raw_y = signals.inertial[0], signals.inertial[1], signals.inertial[2]
    s, c = sincos(base.seen_theta)  # what accelerometers show of a slope turns under the base
    level = params.level + params.level_noise / math.sqrt(max(base.rests, 1))
    told = base.stands != 0 or base.rests >= LEARNED
    sure = 1.0 if told and base.rise_x * base.rise_x + base.rise_y * base.rise_y > level * level else 0.0
    base.slope_x = sure * (c * base.rise_x + s * base.rise_y)
    base.slope_y = sure * (c * base.rise_y - s * base.rise_x)
    base.imu_x, base.imu_y = base.raw_x - base.slope_x, base.raw_y - base.slope_y
    look_at_pitch(params.balance, base, signals)
    look_at(params.steered, signals, work, wheels)
    _sense(params, base, signals, wheels, states, work)
    turn_with_body(params.balance, base, states, work.rims, work.gripping)
    weigh_wheels(params.balance, work.rows, base, work.rims)
    _learn_slope(base, work.rims, len(work.rows))
    detect_slip(params, base, work)
    check_inertia(params.check, base, work)
    if params.compensate:
        watch_steering(params.steered, base, signals, work.held)
        watch_pushes(params.check, base, wheels, states, len(work.rows))
    _react(params, task.path, base, signals, wheels, states, work)
    change = max(min((base.goal - base.rate) / params.keeping.dt, params.rate_change), -params.rate_change)
    twist = _estimate(params.estimate, work.estimate_rows, base, work)
    _refer(params, task.path, base, change, signals, work)
    command, ahead = _keep(params, task.path, base, twist, work.now, work.pin)
    steer_along(params.steered, params.drivable, task.path, base, command, ahead, signals, work, states)
    if base.lame != 0 and params.keep != KEEP_BOTH:
        command = _given_up(params, base, command, twist)
    wanted = wanted_acceleration(params.keeping, command, twist, ahead)
    if base.rate <= 0.0:  # the base had to stop: hold the wheels
        command = wanted = Planar(0.0, 0.0, 0.0)
    if len(params.skid.wheels):
        command = _skidding(params.keeping, base, command)
    _drive(params, task, signals, base, command, wanted, twist, wheels, states, work.now)
    base.phase += base.rate * set_off(params.steered, task.path, base, signals)
    base.rate += params.keeping.dt * change
    base.stood = base.stood + 1 if base.rate <= 0.0 else 0


@loop(error_model="numpy", forceinline=True)
def path_ending(base: Any, path: Array) -> int:
    """How far a path is before the next step: `RUNNING`, `DONE`, `STOPPED`."""
    if base.mode != PATH:
        return RUNNING
    return DONE if base.phase > len(path) - 1 else STOPPED if base.stood >= STANDING else RUNNING


@loop(error_model="numpy", forceinline=True)
def say(base: Any, wheels: Records, states: Records, row: Any, rows: Array) -> None:
    """Write a `CONTROL_SAMPLE`, and `SEEN_WHEEL_SAMPLE` of the wheels in rows (4, 4 n)."""
    row.seen_x, row.seen_y, row.seen_theta = base.seen_x, base.seen_y, base.seen_theta
    row.seen_vx, row.seen_vy, row.seen_w = base.seen_vx, base.seen_vy, base.seen_w
    row.ref_x, row.ref_y, row.ref_theta = base.ref_x, base.ref_y, base.ref_theta
    row.ref_vx, row.ref_vy, row.ref_w, row.ref_rate = base.ref_vx, base.ref_vy, base.ref_w, base.ref_rate
    row.gyro, row.imu_x, row.imu_y = base.gyro, base.raw_x, base.raw_y
    row.status, row.flagged, row.dead, row.jams = base.status, base.flagged, base.dead, base.jams
    row.blind, row.loose, row.lodged = base.blind, base.loose, base.lodged
    row.pinned, row.crippled = base.pinned, base.crippled
    row.seen_pitch = base.seen_pitch
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        store(rows[0], i, own.seen_speed / wheel.gear.ratio)
        store(rows[1], i, own.rim_reference / wheel.radius)
        store(rows[2], i, own.measured_current)
        for lane in range(WIDTH):
            rows[3, i * WIDTH + lane] = states[i].count[lane]


@loop(error_model="numpy", forceinline=True)
def _sense(params: BaseParams, base: Any, signals: WheelSignals, wheels: Records, states: Records, work: Work) -> None:
    """Counters, observers and shunts; rim speeds, and what they are without the creep of a gripping wheel."""
    for i in range(len(wheels)):
        own = packed(states[i])
        sense(wheels[i], states[i], signals.counters, load(signals.currents, i), i)
        store(work.rims, i, own.rim)
        used = load(params.grip_per_ampere, i) * own.measured_current
        store(work.gripping, i, own.rim - creep(load(params.creep, i), used))
    m = len(work.rows)
    for i in range(m, len(work.estimate_rows)):  # wheels that do not slide still creep outwards
        p, q = work.estimate_rows[i, 0], work.estimate_rows[i, 1]
        work.rims[i] = work.swinging[i - m] - params.creep_across * (p * base.imu_x + q * base.imu_y)
    if len(params.skid.wheels):
        _skid(params.skid, base, work)


@loop(error_model="numpy", forceinline=True)
def _learn_slope(base: Any, rims: Array, m: int) -> None:
    """What accelerometers show on the average while it stands where it was placed."""
    if base.stands == 0:
        return
    base.rests += 1
    s, c = sincos(base.seen_theta)
    base.rise_x += ((c * base.raw_x - s * base.raw_y) - base.rise_x) / base.rests
    base.rise_y += ((s * base.raw_x + c * base.raw_y) - base.rise_y) / base.rests
    stands = base.ref_vx == 0.0 and base.ref_vy == 0.0 and base.ref_w == 0.0
    stands = stands and abs(base.ref_x - base.seen_x) + abs(base.ref_y - base.seen_y) < THERE
    for i in range(m):
        stands = stands and abs(rims[i]) < CREEPS
    base.stands = 1 if stands else 0


@loop(error_model="numpy", forceinline=True)
def _skid(params: SkidParams, base: Any, work: Work) -> None:
    """Put rim speeds in the place of what is measured that say the twist at which the wheels skid."""
    before, rows = Planar(base.skid_vx, base.skid_vy, 0.0), work.estimate_rows
    found = skid_twist(params, work.rims, before, base.gyro - base.gyro_bias, base.imu_x, base.imu_y)
    base.skid_vx, base.skid_vy = found.x, found.y
    for i in range(len(rows)):
        work.rims[i] = rows[i, 0] * found.x + rows[i, 1] * found.y + rows[i, 2] * found.turn


@loop(error_model="numpy", forceinline=True)
def _react(
    params: BaseParams, path: Array, base: Any, signals: WheelSignals, wheels: Records, states: Records, work: Work
) -> None:
    """Leave out wheels that slip and motors that are lost; drive slower, or stop, where the others must not push so."""
    m = len(work.rows)
    lost = watch_motors(params.watch, wheels, states, m, base, base.jams != 0) if params.compensate else 0
    if lost == base.dead and base.flagged == base.named and base.lodged == base.known_lodged:
        return
    new = lost != base.dead or base.lodged != base.known_lodged
    base.named, base.dead, base.known_lodged = base.flagged, lost, base.lodged
    base.blind, base.loose = members(states, m, BLIND), members(states, m, OFF)
    base.jams = set_weights(params.control_traction, params.bearing, states, base.named, work.trust, work.weights)
    if params.steered is None:
        share_force(params.pull_rows, params.pull, work.weights, work.share, states)
    _lame(params, base, work)
    base.pinned = 1 if params.sideways and pin(params.steered, base, signals, work.pin) else 0
    left = drives_on(work.rows, params.drivable, work.weights, params.lever)
    unseen = len(params.skid.wheels) > 0 and base.blind != 0  # how wheels skid is seen by all of them
    base.crippled = 1 if left < params.freedoms or (base.lodged != 0 and base.pinned == 0) or unseen else 0
    if new and (base.jams != 0 or base.crippled != 0):
        base.goal = 0.0
    elif new and base.mode == PATH:
        rest = feasible_rate(work.share, path, int(base.phase), params.body, params.path_force)
        base.goal = min(base.goal, rest)


@loop(error_model="numpy", forceinline=True)
def _refer(params: BaseParams, path: Array, base: Any, change: float, signals: WheelSignals, work: Work) -> None:
    """Reference of this sample: on the path, the twist that was asked for within limits, or the pose that is held."""
    now = work.now
    if base.mode == PATH:
        reference_at(path, base.phase, base.rate, change, now)
    elif base.mode == VELOCITY:
        _shape(params, base, signals, work.rows, work.pin, now)
    else:
        now[:] = 0.0
        now[0], now[1], now[2] = base.hold_x, base.hold_y, base.hold_theta
    base.ref_x, base.ref_y, base.ref_theta = now[0], now[1], now[2]
    base.ref_vx, base.ref_vy, base.ref_w, base.ref_rate = now[3], now[4], now[5], base.rate


@loop(error_model="numpy", forceinline=True)
def _shape(params: BaseParams, base: Any, signals: WheelSignals, rows: Array, pin_row: Array, now: Array) -> None:
    """Nearest drivable twist to the one asked for, zero once that is too old, within speed, acceleration and jerk."""
    shaping = params.shaping
    base.age += 1
    heard = base.rate if base.age * shaping.dt <= shaping.timeout else 0.0
    heard *= awake(shaping, base.wanted_vx, base.wanted_vy, base.wanted_w)
    wanted = Planar(heard * base.wanted_vx, heard * base.wanted_vy, heard * base.wanted_w)
    goal = drivable_twist(params.drivable, rows, wanted, params.max_rim)
    base.shaped_vx, base.shaped_ax = shaping_step(shaping.dt, shaping.forwards, base.shaped_vx, base.shaped_ax, goal.x)
    base.shaped_vy, base.shaped_ay = shaping_step(shaping.dt, shaping.sideways, base.shaped_vy, base.shaped_ay, goal.y)
    base.shaped_w, base.shaped_aw = shaping_step(shaping.dt, shaping.turning, base.shaped_w, base.shaped_aw, goal.turn)
    now[0], now[1], now[2] = base.seen_x, base.seen_y, base.seen_theta  # no place to keep
    asked = allowed(params.steered, params.drivable, Planar(base.shaped_vx, base.shaped_vy, base.shaped_w))
    asked = pinned(base, pin_row, asked)
    part = ready(params.steered, asked, signals)
    w = base.shaped_w  # the centre's acceleration in turning axes
    now[6], now[7] = base.shaped_ax - w * base.shaped_vy, base.shaped_ay + w * base.shaped_vx
    now[8] = base.shaped_aw
    before = Planar(base.ref_vx, base.ref_vy, base.ref_w)
    driven = Planar(part * asked.x, part * asked.y, part * asked.turn)
    driven = eased(params.steered, shaping, before, driven, now)
    now[3], now[4], now[5] = driven.x, driven.y, driven.turn
    lead(params.balance, base, now)


@loop(error_model="numpy", forceinline=True)
def _skidding(params: KeepingParams, base: Any, command: Planar) -> Planar:
    """The command to wheels that skid: they are to turn as much more as it takes until the gyro sees what is wanted.

    What they turn more by, over the wanted rate, is learned while it turns: the effective track is not constant.
    """
    w = command.turn
    learned = params.dt * LEARNING * (w - base.seen_w) * w / (w * w + SLOW_TURN * SLOW_TURN)
    base.skid_more = min(max(base.skid_more + learned, -MOST_SKID), MOST_SKID)
    return Planar(command.x, command.y, (1.0 + base.skid_more) * w)


@loop(error_model="numpy", forceinline=True)
def _estimate(params: EstimateParams, rows: Array, base: Any, work: Work) -> Planar:
    before = Planar(base.seen_vx, base.seen_vy, base.seen_w)
    twist, base.gyro_bias = estimate_step(
        params, rows, work.trust, work.rims, before, base.gyro_bias, base.gyro, Planar(base.imu_x, base.imu_y, 0.0)
    )
    pose = pose_step(Planar(base.seen_x, base.seen_y, base.seen_theta), twist, params.dt)
    base.seen_vx, base.seen_vy, base.seen_w = twist.x, twist.y, twist.turn
    base.seen_x, base.seen_y, base.seen_theta = pose.x, pose.y, pose.turn
    return twist


@loop(error_model="numpy", forceinline=True)
def _keep(
    params: BaseParams, path: Array, base: Any, twist: Planar, reference: Array, pin_row: Array
) -> tuple[Planar, Planar]:
    """Twist to command and acceleration to feed forward."""
    pose = Planar(base.seen_x, base.seen_y, base.seen_theta)
    integral = Planar(base.integral_x, base.integral_y, base.integral_theta)
    before = Planar(base.command_vx, base.command_vy, base.command_w)
    if params.sideways or base.mode == VELOCITY:  # whose place is not kept
        command, ahead, grown = keeping_step(params.keeping, reference, pose, base.seen_w, integral, before)
    elif base.mode == HOLD:
        command, ahead, grown = line_keeping_step(params.keeping, reference, pose, before)
    else:
        if len(params.skid.wheels):  # where it goes is not where it looks
            lean = twist.y * twist.x / (twist.x * twist.x + SLOW * SLOW)
            base.skid_lean += params.keeping.dt / LEANING * (lean - base.skid_lean)
            pose = Planar(pose.x, pose.y, pose.turn + base.skid_lean)
        command = law_step(params.law, path, base.phase, reference, pose, twist, before, base.law)
        ahead, grown = Planar(reference[6], reference[7], reference[8]), integral
    command = pinned(base, pin_row, allowed(params.steered, params.drivable, command))
    ahead = pinned(base, pin_row, ahead)
    base.command_vx, base.command_vy, base.command_w = command.x, command.y, command.turn
    base.integral_x, base.integral_y, base.integral_theta = grown.x, grown.y, grown.turn
    return command, ahead


@loop(error_model="numpy", forceinline=True)
def _lame(params: BaseParams, base: Any, work: Work) -> None:
    """Find the twist that turns no wheel with a motor, if there is one: forces of those wheels do no work on it."""
    base.lame = 0
    if base.dead == 0:
        return
    ux, uy, uw, found = unseen_twist(work.rows, work.weights)
    if found and params.sideways and params.steered is None:
        base.lame, base.unseen_x, base.unseen_y, base.unseen_turn = 1, ux, uy, uw


@loop(error_model="numpy", forceinline=True)
def _given_up(params: BaseParams, base: Any, command: Planar, twist: Planar) -> Planar:
    """The command with that part of it taken as it is which the motors cannot change: of turning, or of the way.

    What is left of the difference to the present twist is an acceleration that they can make: its momentum has no part
    along the twist that turns none of their wheels.
    """
    x, y, turn = command.x - twist.x, command.y - twist.y, command.turn - twist.turn
    B, (ux, uy, uw) = params.momentum, (base.unseen_x, base.unseen_y, base.unseen_turn)
    px = B[0, 0] * ux + B[1, 0] * uy + B[2, 0] * uw
    py = B[0, 1] * ux + B[1, 1] * uy + B[2, 1] * uw
    pw = B[0, 2] * ux + B[1, 2] * uy + B[2, 2] * uw
    missed = px * x + py * y + pw * turn
    if params.keep == KEEP_PATH:
        return Planar(command.x, command.y, command.turn - missed / pw)
    part = missed / (px * px + py * py)
    return Planar(command.x - part * px, command.y - part * py, command.turn)


@loop(error_model="numpy", forceinline=True)
def _drive(
    params: BaseParams, task: BaseTask, signals: WheelSignals, base: Any, command: Planar, wanted: Planar,
    twist: Planar, wheels: Records, states: Records, now: Array,
) -> None:  # fmt: skip
    """Rim speeds and forces for a twist and an acceleration of the base; voltages from them."""
    held = Planar(wanted.x + base.slope_x, wanted.y + base.slope_y, wanted.turn)  # against gravity along the floor
    force = wrench_of(params.body, held, twist.turn)
    if balance(params.balance, base, task.lean, now, wanted, signals, wheels, states, command, force):
        return
    change, rolls = rim_change(params.steered, wanted, twist), 1.0 if base.goal > 0.0 else 0.0
    part = driven_part(wheels, states, force)
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        own.rim_reference = rim_speed(wheel, command)
        rim, ground = part * rim_force(own, force), rim_speed(wheel, twist)
        if params.control_traction:
            rim = control_traction(params.traction, wheel, own, ground, rim)
        own.asked = rim
        wheel_voltage(wheel, own, rim, rim_speed(wheel, change), rolls * ground)
        store(signals.voltages, i, own.voltage)
        store(signals.speeds, i, own.works * own.rim_reference / wheel.radius)
