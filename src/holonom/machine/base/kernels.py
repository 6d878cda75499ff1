"""One millisecond of a base's controller, compiled: sensors, estimate, path or velocity, wheel loops.

What it knows comes from counters, shunts, gyro and accelerometers only. Records in `records.py`, what is done wheel by
wheel in `wheel_kernels.py`, the loops' steps in `control.base.kernels`, slip detection in `mobile.drive.slip_kernels`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.base.force_kernels import feasible_rate, wrench_of
from holonom.control.base.kernels import (
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
from holonom.machine.base.params import BaseParams, BaseTask, Work
from holonom.machine.base.steering_kernels import allowed, look_at, ready, rim_change, set_off, steer_along
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
from holonom.mobile.drive.slip_kernels import SlipState, slip_step
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
    base.gyro, base.imu_x, base.imu_y = signals.inertial[0], signals.inertial[1], signals.inertial[2]
    look_at_pitch(params.balance, base, signals)
    look_at(params.steered, signals, work, wheels)
    _sense(params, base, signals, wheels, states, work)
    turn_with_body(params.balance, base, states, work.rims, work.gripping)
    weigh_wheels(params.balance, work.rows, base, work.rims)
    _detect(params, base, work)
    _react(params, task.path, base, wheels, states, work)
    change = max(min((base.goal - base.rate) / params.keeping.dt, params.rate_change), -params.rate_change)
    twist = _estimate(params.estimate, work.estimate_rows, base, work)
    _refer(params, task.path, base, change, signals, work.rows, work.now)
    command, ahead = _keep(params, task.path, base, twist, work.now)
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
    row.gyro, row.imu_x, row.imu_y = base.gyro, base.imu_x, base.imu_y
    row.status, row.flagged, row.dead, row.jams = base.status, base.flagged, base.dead, base.jams
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
def _skid(params: SkidParams, base: Any, work: Work) -> None:
    """Put rim speeds in the place of what is measured that say the twist at which the wheels skid."""
    before, rows = Planar(base.skid_vx, base.skid_vy, 0.0), work.estimate_rows
    found = skid_twist(params, work.rims, before, base.gyro - base.gyro_bias, base.imu_x, base.imu_y)
    base.skid_vx, base.skid_vy = found.x, found.y
    for i in range(len(rows)):
        work.rims[i] = rows[i, 0] * found.x + rows[i, 1] * found.y + rows[i, 2] * found.turn


@loop(error_model="numpy", forceinline=True)
def _detect(params: BaseParams, base: Any, work: Work) -> None:
    """Ask the slip detector, but while all wheels are known to grip."""
    if params.detect and not (base.steady != 0 and _square(params.residual, work.gripping) <= params.quiet):
        if base.steady != 0:
            _keep_slip(base.slip, _no_slip(params.inverse, work.last))
        work.acceleration[0], work.acceleration[1] = base.imu_x, base.imu_y
        wheels = work.gripping[: len(work.rows)]
        after, found = slip_step(params.slip, base.slip, wheels, base.gyro - base.gyro_bias, work.acceleration)
        _keep_slip(base.slip, after)
        base.status, base.flagged = found.status, found.named
        base.steady = 1 if params.quiet >= 0.0 and after.level == 0 and after.held_slack == 0.0 else 0
    work.last[:] = work.gripping


@loop(error_model="numpy", forceinline=True)
def _react(params: BaseParams, path: Array, base: Any, wheels: Records, states: Records, work: Work) -> None:
    """Leave out wheels that slip and motors that are lost; drive slower, or stop, where the others must not push so."""
    m = len(work.rows)
    lost = watch_motors(params.watch, wheels, states, m, base, base.jams != 0) if params.compensate else 0
    if lost == base.dead and base.flagged == base.named:
        return
    new = lost != base.dead
    base.named, base.dead = base.flagged, lost
    base.jams = set_weights(params.control_traction, params.bearing, states, base.named, work.trust, work.weights)
    if params.steered is None:
        share_force(params.pull_rows, params.pull, work.weights, work.share, states)
    _lame(params, base, work)
    if new and base.jams != 0:
        base.goal = 0.0
    elif new and base.mode == PATH:
        rest = feasible_rate(work.share, path, int(base.phase), params.body, params.path_force)
        base.goal = min(base.goal, rest)


@loop(error_model="numpy", forceinline=True)
def _refer(
    params: BaseParams, path: Array, base: Any, change: float, signals: WheelSignals, rows: Array, now: Array
) -> None:
    """Reference of this sample: on the path, the twist that was asked for within limits, or the pose that is held."""
    if base.mode == PATH:
        reference_at(path, base.phase, base.rate, change, now)
    elif base.mode == VELOCITY:
        _shape(params, base, signals, rows, now)
    else:
        now[:] = 0.0
        now[0], now[1], now[2] = base.hold_x, base.hold_y, base.hold_theta
    base.ref_x, base.ref_y, base.ref_theta = now[0], now[1], now[2]
    base.ref_vx, base.ref_vy, base.ref_w, base.ref_rate = now[3], now[4], now[5], base.rate


@loop(error_model="numpy", forceinline=True)
def _shape(params: BaseParams, base: Any, signals: WheelSignals, rows: Array, now: Array) -> None:
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
    part = ready(params.steered, asked, signals)
    now[3], now[4], now[5] = part * asked.x, part * asked.y, part * asked.turn
    w = base.shaped_w  # the centre's acceleration in turning axes
    now[6], now[7] = base.shaped_ax - w * base.shaped_vy, base.shaped_ay + w * base.shaped_vx
    now[8] = base.shaped_aw
    for j in range(6, 9):
        now[j] *= part
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
def _keep(params: BaseParams, path: Array, base: Any, twist: Planar, reference: Array) -> tuple[Planar, Planar]:
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
    command = allowed(params.steered, params.drivable, command)
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
    force = wrench_of(params.body, wanted, twist.turn)
    if balance(params.balance, base, task.lean, now, wanted, signals, wheels, states, command, force):
        return
    change = rim_change(params.steered, wanted, twist)
    part = driven_part(wheels, states, force)
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        own.rim_reference = rim_speed(wheel, command)
        rim = part * rim_force(own, force)
        if params.control_traction:
            rim = control_traction(params.traction, wheel, own, rim_speed(wheel, twist), rim)
        wheel_voltage(wheel, own, rim, rim_speed(wheel, change))
        store(signals.voltages, i, own.voltage)
        store(signals.speeds, i, own.works * own.rim_reference / wheel.radius)


@loop(error_model="numpy", forceinline=True)
def _square(residual: Array, rims: Array) -> float:
    """Square sum, (m/s)^2, of what no twist explains of rim speeds."""
    total = 0.0
    for i in range(len(residual)):
        left = 0.0
        for j in range(len(residual)):
            left += residual[i, j] * rims[j]
        total += left * left
    return total


@loop(error_model="numpy", forceinline=True)
def _no_slip(inverse: Array, rims: Array) -> SlipState:
    """Return the state that `slip_step` takes in silence: it trusts the twist of all wheels."""
    vx, vy, rw = 0.0, 0.0, 0.0
    for i in range(inverse.shape[1]):
        vx += inverse[0, i] * rims[i]
        vy += inverse[1, i] * rims[i]
        rw += inverse[2, i] * rims[i]
    return SlipState(vx, vy, rw, 0.0, 0.0, vx, vy, rw, 0.0, 0.0, 0, False, 0, 0, 0, 0, 0, False)


@loop(error_model="numpy", forceinline=True)
def _keep_slip(own: Any, after: SlipState) -> None:
    """Remember what slip detection carries from sample to sample."""
    own.vx, own.vy, own.rw, own.slack, own.angular_slack = (
        after.vx, after.vy, after.rw, after.slack, after.angular_slack,
    )  # fmt: skip
    own.held_x, own.held_y, own.held_rw = after.held_x, after.held_y, after.held_rw
    own.held_slack, own.held_angular_slack = after.held_slack, after.held_angular_slack
    own.level, own.raised, own.pending, own.agreed = after.level, after.raised, after.pending, after.agreed
    own.named, own.doubt, own.side, own.mixed = after.named, after.doubt, after.side, after.mixed
