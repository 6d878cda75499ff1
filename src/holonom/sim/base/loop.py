"""The loop of a whole base, compiled: sensors, estimate, path keeping, wheel loops each millisecond, the plant between.

What the controller knows comes from encoders, shunts, gyro and accelerometers only; true states and faults are the
plant's. Records in `base_records.py`, loops' steps in `control.base_kernels`, slip detection in `mobile.slip_kernels`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from holonom.control.base_kernels import (
    JAMMED,
    WORKS,
    EstimateParams,
    KeepingParams,
    Planar,
    Suspicion,
    TractionParams,
    WatchParams,
    allocation,
    estimate_step,
    feasible_rate,
    force_part,
    ground_speed,
    keeping_step,
    pose_step,
    reference_at,
    traction_step,
    wanted_acceleration,
    watch_step,
    watch_verdict,
    within_slip,
)
from holonom.control.kernels import speed_step
from holonom.devices.kernels import (
    TrackingState,
    count_angle,
    encoder_counter,
    extend_counter,
    friction_torque,
    tracking_step,
)
from holonom.mobile.drive.slip_kernels import NO_SLIP, SlipParams, SlipState, slip_start, slip_step
from holonom.sim.base.kernels import BLOCKED, RUNS, find_material, plant_step
from holonom.sim.base.log_kernels import log_body, log_reference, log_wheel, log_wheels
from holonom.sim.base.records import FLAGGED, HELD, LOST, STATUS

__all__ = ["CUT_OFF", "DONE", "STOPPED", "LoopParams", "SensorParams", "drive_open", "run_loop"]

DONE, STOPPED, CUT_OFF = 0, 1, 2
"""How a run ends: at the path's end, stopped by a jammed wheel, out of time because it is driven too slowly."""
STANDING = 500  # ms after which a base that had to stop is done
SLIPPING_WEIGHT = 0.3  # in the allocation of force: a wheel on ice is asked last
Floats = NDArray[np.float64]
Records = NDArray[np.void]


class SensorParams(NamedTuple):
    """Gyro and accelerometer: standard deviation of a sample, offset; shunt: standard deviation."""

    gyro_noise: float
    gyro_bias: float
    accelerometer_noise: float
    accelerometer_bias: float
    current_noise: float


class LoopParams(NamedTuple):
    """The controller: params of its steps, what it knows of the base, and what is switched on."""

    keeping: KeepingParams
    estimate: EstimateParams
    traction: TractionParams
    watch: WatchParams
    slip: SlipParams
    rows: Floats  # (m, 3) rim speeds per (vx, vy, w)
    residual: Floats  # (m, m) 1 - D D^+
    inverse: Floats  # (3, m) D^+: (vx, vy, R w) per rim speed
    quiet: float  # square sum of the residual, (m/s)^2, up to which nothing slips; below 0: ask the detector always
    push: Floats  # (m,) part of its grip that a motor pushes with per ampere
    creep: float  # m/s that a wheel slips with all its grip, were it to grow linearly
    mass: float
    inertia: float
    max_force: float  # N that one wheel is asked for, along its rim
    reserve: float  # part of it that a slowed-down path may need
    rate_change: float  # 1/s, how fast the path may be slowed down
    detect: bool  # slip detection: leave the slipping wheel out of estimate and allocation
    control_traction: bool
    compensate: bool  # watch the motors, allocate without the dead


@njit(cache=True, error_model="numpy")
def run_loop(
    params: LoopParams,
    sensors: SensorParams,
    body: Records,
    state: Records,
    wheels: Records,
    states: Records,
    support: Floats,
    floor: Records,
    patches: Records,
    reference: Floats,
    faults: NDArray[np.int64],
    rng: np.random.Generator,
    body_log: Records,
    wheel_log: Records,
    said: NDArray[np.int64],
) -> tuple[int, int, float]:
    """Follow a reference (N, 9) from the present state and log each millisecond (docstring of `simulate_base`).

    `faults` (k, 3): tick, wheel, kind, in order of time. Returns the milliseconds it took, at most the logs' length;
    how it ended (`DONE`, `STOPPED`, `CUT_OFF`); the last phase on the reference, in samples.
    """
    m = len(wheels)
    b, base = body[0], state[0]
    rows, keeping = params.rows, params.keeping
    slip = slip_start()
    trust, weights, rims, gripping = np.ones(m), np.ones(m), np.zeros(m), np.zeros(m)
    still, calm, ice = np.zeros(m), False, True
    acceleration, share = np.full(3, np.nan), np.zeros((m, 3))
    allocation(rows, weights, share)
    fault, named, dead, jams, stood = 0, 0, 0, 0, 0
    phase, rate, goal, now = 0.0, 1.0, 1.0, np.zeros(9)
    for k in range(len(body_log)):
        if phase > len(reference) - 1:
            return k, DONE, phase
        if stood >= STANDING:
            return k, STOPPED, phase
        while fault < len(faults) and faults[fault, 0] <= k:
            _break_motor(states[faults[fault, 1]], faults[fault, 2])
            fault += 1
        gyro = base.w + sensors.gyro_bias + sensors.gyro_noise * rng.standard_normal()
        imu_x = base.ax + sensors.accelerometer_bias + sensors.accelerometer_noise * rng.standard_normal()
        imu_y = base.ay + sensors.accelerometer_bias + sensors.accelerometer_noise * rng.standard_normal()
        for i in range(m):
            rims[i] = _sense(wheels[i], states[i], sensors.current_noise * rng.standard_normal())
            gripping[i] = rims[i] - _creep(params.creep, params.push[i] * states[i].measured_current)
        acceleration[0], acceleration[1] = imu_x, imu_y
        if params.detect and not (calm and _square(params.residual, gripping) <= params.quiet):
            if calm:
                slip = _no_slip(params.inverse, still)
            slip, found = slip_step(params.slip, slip, gripping, gyro - base.gyro_bias, acceleration)
            base.status, base.flagged = found.status, found.named
            calm = params.quiet >= 0.0 and slip.level == 0 and slip.held_slack == 0.0
        still[:] = gripping
        lost = _watch_motors(params.watch, wheels, states, base, jams != 0) if params.compensate else 0
        if lost != dead or base.flagged != named:
            new, named, dead = lost != dead, base.flagged, lost
            jams = _set_weights(params.control_traction, states, named, trust, weights)
            allocation(rows, weights, share)
            if new and jams != 0:
                goal = 0.0
            elif new:
                rest = feasible_rate(
                    share, reference, int(phase), params.mass, params.inertia, params.reserve * params.max_force
                )
                goal = min(goal, rest)
        change = max(min((goal - rate) / keeping.dt, params.rate_change), -params.rate_change)
        reference_at(reference, phase, rate, change, now)
        twist = _estimate(params.estimate, rows, base, trust, rims, gyro, imu_x, imu_y)
        log_body(base, gyro, imu_x, imu_y, body_log[k])
        log_reference(now, rate, body_log[k])
        log_wheels(wheels, states, wheel_log[k])
        said[k, STATUS], said[k, FLAGGED], said[k, LOST], said[k, HELD] = base.status, base.flagged, lost, jams
        command, ahead = _keep_path(keeping, base, now)
        wanted = wanted_acceleration(keeping, command, twist, ahead)
        if rate <= 0.0:  # the base had to stop: hold the wheels
            command = wanted = Planar(0.0, 0.0, 0.0)
        force = Planar(params.mass * wanted.x, params.mass * wanted.y, params.inertia * wanted.turn)
        part = force_part(share, force, params.max_force)
        for i in range(m):
            wheel, own = wheels[i], states[i]
            own.rim_reference = ground_speed(rows, i, command)
            push = part * ground_speed(share, i, force)
            if params.control_traction:
                push = _control_traction(params.traction, wheel, own, ground_speed(rows, i, twist), push)
            _drive(wheel, own, push, ground_speed(rows, i, wanted))
            wheel_log[k, i].reference_speed = states[i].rim_reference / wheels[i].radius
        ice = _floor(floor, patches, base, wheels, states, ice)
        for _ in range(b.substeps):
            plant_step(b, base, wheels, states, support)
        phase += rate
        rate += keeping.dt * change
        stood = stood + 1 if rate <= 0.0 else 0
    return len(body_log), DONE if phase > len(reference) - 1 else CUT_OFF, phase


@njit(cache=True, error_model="numpy")
def drive_open(
    body: Records,
    state: Records,
    wheels: Records,
    states: Records,
    support: Floats,
    floor: Records,
    patches: Records,
    voltages: Floats,
    body_log: Records,
    wheel_log: Records,
) -> None:
    """Drive the motors with voltages (N, m), one row each millisecond, without any controller."""
    ice = True
    for k in range(len(voltages)):
        base = state[0]
        log_body(base, base.w, base.ax, base.ay, body_log[k])
        ice = _floor(floor, patches, base, wheels, states, ice)
        for i in range(len(wheels)):
            states[i].voltage = voltages[k, i]
            log_wheel(wheels[i], states[i], wheel_log[k, i])
        for _ in range(body[0].substeps):
            plant_step(body[0], base, wheels, states, support)


@njit(cache=True, error_model="numpy", forceinline=True)
def _break_motor(own: Any, kind: int) -> None:
    own.motor = kind
    if kind == BLOCKED:
        own.speed = 0.0
    if kind != RUNS:
        own.current = 0.0


@njit(cache=True, error_model="numpy", forceinline=True)
def _floor(floor: Records, patches: Records, base: Any, wheels: Records, states: Records, near: bool) -> bool:
    """Look up the material under each wheel, if a patch is near or was (`near`); whether one is."""
    c, s = math.cos(base.theta), math.sin(base.theta)
    base.cosine, base.sine = c, s
    was, near = near, False
    for k in range(len(patches)):
        patch = patches[k]
        reach = patch.reach + wheels[0].reach
        near = near or (abs(base.x - patch.x) <= reach and abs(base.y - patch.y) <= reach)
    if not (near or was):
        return False
    for i in range(len(wheels)):
        wheel = wheels[i]
        x, y = base.x + c * wheel.x - s * wheel.y, base.y + s * wheel.x + c * wheel.y
        find_material(floor, patches, x, y, states[i])
    return near


@njit(cache=True, error_model="numpy", forceinline=True)
def _sense(wheel: Any, own: Any, current_noise: float) -> float:
    """Encoder, observer and shunt of a wheel; its rim speed, m/s."""
    own.count = extend_counter(own.count, encoder_counter(wheel.encoder, wheel.gear.ratio * own.angle))
    before = TrackingState(own.seen_angle, own.seen_speed, own.seen_load)
    after = tracking_step(wheel.tracking, before, count_angle(wheel.encoder, own.count), 0.0)
    own.seen_angle, own.seen_speed, own.seen_load = after.angle, after.speed, after.load
    own.measured_current = own.current + current_noise
    own.modelled_current = wheel.armature.conductance * (own.voltage - wheel.armature.back_emf * after.speed)
    own.rim = wheel.radius * after.speed / wheel.gear.ratio
    return own.rim


@njit(cache=True, error_model="numpy", forceinline=True)
def _watch_motors(params: WatchParams, wheels: Records, states: Records, base: Any, held: bool) -> int:
    """Set (bit i: wheel i) of the motors that do not do as they are told; once lost they stay so.

    A jammed wheel holds the base (`held`), so that others may stand, too: they are not suspected of a jam any more.
    """
    lost = 0
    for i in range(len(wheels)):
        wheel, own = wheels[i], states[i]
        if own.lost == WORKS:
            reference = wheel.gear.ratio * own.rim_reference / wheel.radius
            explained = base.status != NO_SLIP and base.flagged != 1 << i
            after = watch_step(
                params, Suspicion(own.open, own.jam), own.measured_current, own.modelled_current, own.seen_speed,
                reference, explained,
            )  # fmt: skip
            own.open, own.jam = after.open, 0.0 if held else after.jam
            after = Suspicion(own.open, own.jam)
            own.lost = watch_verdict(params, after)
        if own.lost != WORKS:
            lost |= 1 << i
    return lost


@njit(cache=True, error_model="numpy", forceinline=True)
def _set_weights(traction: bool, states: Records, named: int, trust: Floats, weights: Floats) -> int:
    """Which wheels are believed (one without current turns freely) and asked for force; set of those that jam."""
    jams = 0
    for i in range(len(states)):
        slips, jammed = (named >> i) & 1 == 1, states[i].lost == JAMMED
        jams |= (1 << i) if jammed else 0
        trust[i] = 0.0 if slips or jammed else 1.0
        weights[i] = 0.0 if states[i].lost != WORKS else SLIPPING_WEIGHT if slips and traction else 1.0
    return jams


@njit(cache=True, error_model="numpy", forceinline=True)
def _estimate(
    params: EstimateParams,
    rows: Floats,
    base: Any,
    trust: Floats,
    rims: Floats,
    gyro: float,
    imu_x: float,
    imu_y: float,
) -> Planar:
    before = Planar(base.seen_vx, base.seen_vy, base.seen_w)
    twist, base.gyro_bias = estimate_step(
        params, rows, trust, rims, before, base.gyro_bias, gyro, Planar(imu_x, imu_y, 0.0)
    )
    pose = pose_step(Planar(base.seen_x, base.seen_y, base.seen_theta), twist, params.dt)
    base.seen_vx, base.seen_vy, base.seen_w = twist.x, twist.y, twist.turn
    base.seen_x, base.seen_y, base.seen_theta = pose.x, pose.y, pose.turn
    return twist


@njit(cache=True, error_model="numpy", forceinline=True)
def _keep_path(params: KeepingParams, base: Any, reference: Floats) -> tuple[Planar, Planar]:
    pose = Planar(base.seen_x, base.seen_y, base.seen_theta)
    integral = Planar(base.integral_x, base.integral_y, base.integral_theta)
    before = Planar(base.command_vx, base.command_vy, base.command_w)
    command, ahead, grown = keeping_step(params, reference, pose, base.seen_w, integral, before)
    base.command_vx, base.command_vy, base.command_w = command.x, command.y, command.turn
    base.integral_x, base.integral_y, base.integral_theta = grown.x, grown.y, grown.turn
    return command, ahead


@njit(cache=True, error_model="numpy", forceinline=True)
def _control_traction(params: TractionParams, wheel: Any, own: Any, ground: float, force: float) -> float:
    """Hold the commanded rim speed near the floor's; return the drive force (N) that is left."""
    own.cut = traction_step(params, own.cut, own.rim - ground, own.current_reference * wheel.gear.ratio)
    own.rim_reference = within_slip(params, own.rim_reference, ground)
    return own.cut * force


@njit(cache=True, error_model="numpy", forceinline=True)
def _drive(wheel: Any, own: Any, force: float, acceleration: float) -> None:
    """Speed loop and voltage of a wheel, fed forward the force (N) and acceleration (m/s2) of its rim."""
    if own.lost != WORKS:
        own.voltage, own.current_reference, own.integral = 0.0, 0.0, 0.0
        return
    ratio, r = wheel.gear.ratio, wheel.radius
    speed = ratio * own.rim_reference / r
    torque = (force * r + wheel.inertia * acceleration / r) / (ratio * wheel.gear.efficiency)
    ahead = (torque + friction_torque(wheel.friction, speed)) / wheel.torque_constant
    own.current_reference, own.integral = speed_step(wheel.speed_loop, own.integral, speed, own.seen_speed, ahead)
    supply = wheel.armature.max_voltage
    voltage = own.current_reference / wheel.armature.conductance + wheel.armature.back_emf * own.seen_speed
    own.voltage = min(max(voltage, -supply), supply)


@njit(cache=True, error_model="numpy", forceinline=True)
def _square(residual: Floats, rims: Floats) -> float:
    """Square sum, (m/s)^2, of what no twist explains of rim speeds."""
    total = 0.0
    for i in range(len(rims)):
        left = 0.0
        for j in range(len(rims)):
            left += residual[i, j] * rims[j]
        total += left * left
    return total


@njit(cache=True, error_model="numpy", forceinline=True)
def _creep(full: float, used: float) -> float:
    """Slip (m/s) of a gripping wheel that uses a part of its grip; half as much again with all of it.

    Nearly the magic formula's, which rises without bound towards the peak.
    """
    part = min(max(used, -1.0), 1.0)
    return full * part * (1.0 + 0.5 * part * part)


@njit(cache=True, error_model="numpy", forceinline=True)
def _no_slip(inverse: Floats, rims: Floats) -> SlipState:
    """Return the state that `slip_step` takes in silence: it trusts the twist of all wheels."""
    vx, vy, rw = 0.0, 0.0, 0.0
    for i in range(len(rims)):
        vx += inverse[0, i] * rims[i]
        vy += inverse[1, i] * rims[i]
        rw += inverse[2, i] * rims[i]
    return SlipState(vx, vy, rw, 0.0, 0.0, vx, vy, rw, 0.0, 0.0, 0, False, 0, 0, 0, 0, 0, False)
