"""The loop of a whole base, compiled: sensors, estimate, path keeping, wheel loops each millisecond, the plant between.

What the controller knows comes from encoders, shunts, gyro and accelerometers only; true states and faults are the
plant's. Records in `records.py`, what is done wheel by wheel in `wheel_kernels.py`, loops' steps in
`control.base_kernels`, slip detection in `mobile.drive.slip_kernels`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.control.base_kernels import (
    EstimateParams,
    KeepingParams,
    Planar,
    TractionParams,
    WatchParams,
    estimate_step,
    feasible_rate,
    keeping_step,
    pose_step,
    reference_at,
    wanted_acceleration,
)
from holonom.mobile.drive.slip_kernels import SlipParams, SlipState, slip_start, slip_step
from holonom.sim.base.kernels import break_motor, find_material, plant_steps
from holonom.sim.base.log_kernels import log_body, log_reference, log_wheels
from holonom.sim.base.records import FLAGGED, HELD, LOST, STATUS
from holonom.sim.base.wheel_kernels import (
    control_traction,
    creep,
    drive_wheels,
    driven_part,
    rim_force,
    rim_speed,
    sense,
    set_weights,
    share_force,
    watch_motors,
)
from holonom.trace.compiled import sincos
from holonom.trace.loops import loop
from holonom.trace.simd import WIDTH, load, packed, store

__all__ = ["CUT_OFF", "DONE", "STOPPED", "LoopParams", "SensorParams", "drive_open", "run_loop"]

DONE, STOPPED, CUT_OFF = 0, 1, 2
"""How a run ends: at the path's end, stopped by a jammed wheel, out of time because it is driven too slowly."""
STANDING = 500  # ms after which a base that had to stop is done
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
    push: Floats  # (m,) part of its grip that a motor pushes with per ampere; zeros up to whole fours
    creep: float  # m/s that a wheel slips with all its grip, were it to grow linearly
    mass: float
    inertia: float
    max_force: float  # N that one wheel is asked for, along its rim
    reserve: float  # part of it that a slowed-down path may need
    rate_change: float  # 1/s, how fast the path may be slowed down
    detect: bool  # slip detection: leave the slipping wheel out of estimate and allocation
    control_traction: bool
    compensate: bool  # watch the motors, allocate without the dead


@loop(error_model="numpy")
def run_loop(
    params: LoopParams,
    sensors: SensorParams,
    body: Records,
    state: Records,
    wheels: Records,
    states: Records,
    passive: Floats,
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
    m, lanes = len(params.rows), WIDTH * len(wheels)
    base = state[0]
    rows, keeping = params.rows, params.keeping
    slip = slip_start()
    trust, weights, noise, rims, gripping = np.ones(m), np.ones(m), np.zeros(lanes), np.zeros(lanes), np.zeros(lanes)
    still, calm, ice = np.zeros(lanes), False, True
    acceleration, share = np.full(3, np.nan), np.zeros((m, 3))
    share_force(rows, weights, share, states)
    fault, named, dead, jams, stood = 0, 0, 0, 0, 0
    phase, rate, goal, now = 0.0, 1.0, 1.0, np.zeros(9)
    for k in range(len(body_log)):
        if phase > len(reference) - 1:
            return k, DONE, phase
        if stood >= STANDING:
            return k, STOPPED, phase
        while fault < len(faults) and faults[fault, 0] <= k:
            wheel = faults[fault, 1]
            break_motor(states[wheel // WIDTH], wheel % WIDTH, faults[fault, 2])
            fault += 1
        gyro = base.w + sensors.gyro_bias + sensors.gyro_noise * rng.standard_normal()
        imu_x = base.ax + sensors.accelerometer_bias + sensors.accelerometer_noise * rng.standard_normal()
        imu_y = base.ay + sensors.accelerometer_bias + sensors.accelerometer_noise * rng.standard_normal()
        for i in range(m):
            noise[i] = sensors.current_noise * rng.standard_normal()
        for i in range(len(wheels)):
            own = packed(states[i])
            sense(wheels[i], states[i], load(noise, i))
            store(rims, i, own.rim)
            store(gripping, i, own.rim - creep(params.creep, load(params.push, i) * own.measured_current))
        acceleration[0], acceleration[1] = imu_x, imu_y
        if params.detect and not (calm and _square(params.residual, gripping) <= params.quiet):
            if calm:
                slip = _no_slip(params.inverse, still)
            slip, found = slip_step(params.slip, slip, gripping[:m], gyro - base.gyro_bias, acceleration)
            base.status, base.flagged = found.status, found.named
            calm = params.quiet >= 0.0 and slip.level == 0 and slip.held_slack == 0.0
        still[:] = gripping
        lost = watch_motors(params.watch, wheels, states, m, base, jams != 0) if params.compensate else 0
        if lost != dead or base.flagged != named:
            new, named, dead = lost != dead, base.flagged, lost
            jams = set_weights(params.control_traction, states, named, trust, weights)
            share_force(rows, weights, share, states)
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
        part = driven_part(states, force, params.max_force)
        for i in range(len(wheels)):
            wheel, own = packed(wheels[i]), packed(states[i])
            own.rim_reference = rim_speed(wheel, command)
            push = part * rim_force(own, force)
            if params.control_traction:
                push = control_traction(params.traction, wheel, own, rim_speed(wheel, twist), push)
            drive_wheels(wheel, own, push, rim_speed(wheel, wanted))
            packed(wheel_log[k, i]).reference_speed = own.rim_reference / wheel.radius
        ice = _floor(floor, patches, base, wheels, states, ice)
        plant_steps(body[0], base, wheels, states, passive)
        phase += rate
        rate += keeping.dt * change
        stood = stood + 1 if rate <= 0.0 else 0
    return len(body_log), DONE if phase > len(reference) - 1 else CUT_OFF, phase


@loop(error_model="numpy")
def drive_open(
    body: Records,
    state: Records,
    wheels: Records,
    states: Records,
    passive: Floats,
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
        for i in range(voltages.shape[1]):
            states[i // WIDTH].voltage[i % WIDTH] = voltages[k, i]
        log_wheels(wheels, states, wheel_log[k])
        plant_steps(body[0], base, wheels, states, passive)


@loop(error_model="numpy", forceinline=True)
def _floor(floor: Records, patches: Records, base: Any, wheels: Records, states: Records, near: bool) -> bool:
    """Look up the material under each wheel, if a patch is near or was (`near`); whether one is."""
    s, c = sincos(base.theta)
    base.cosine, base.sine = c, s
    was, near = near, False
    for k in range(len(patches)):
        patch = patches[k]
        reach = patch.reach + wheels[0].reach[0]
        near = near or (abs(base.x - patch.x) <= reach and abs(base.y - patch.y) <= reach)
    if not (near or was):
        return False
    for i in range(len(wheels)):
        for lane in range(WIDTH):
            x, y = wheels[i].x[lane], wheels[i].y[lane]
            find_material(floor, patches, base.x + c * x - s * y, base.y + s * x + c * y, states[i], lane)
    return near


@loop(error_model="numpy", forceinline=True)
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


@loop(error_model="numpy", forceinline=True)
def _keep_path(params: KeepingParams, base: Any, reference: Floats) -> tuple[Planar, Planar]:
    pose = Planar(base.seen_x, base.seen_y, base.seen_theta)
    integral = Planar(base.integral_x, base.integral_y, base.integral_theta)
    before = Planar(base.command_vx, base.command_vy, base.command_w)
    command, ahead, grown = keeping_step(params, reference, pose, base.seen_w, integral, before)
    base.command_vx, base.command_vy, base.command_w = command.x, command.y, command.turn
    base.integral_x, base.integral_y, base.integral_theta = grown.x, grown.y, grown.turn
    return command, ahead


@loop(error_model="numpy", forceinline=True)
def _square(residual: Floats, rims: Floats) -> float:
    """Square sum, (m/s)^2, of what no twist explains of rim speeds."""
    total = 0.0
    for i in range(len(residual)):
        left = 0.0
        for j in range(len(residual)):
            left += residual[i, j] * rims[j]
        total += left * left
    return total


@loop(error_model="numpy", forceinline=True)
def _no_slip(inverse: Floats, rims: Floats) -> SlipState:
    """Return the state that `slip_step` takes in silence: it trusts the twist of all wheels."""
    vx, vy, rw = 0.0, 0.0, 0.0
    for i in range(inverse.shape[1]):
        vx += inverse[0, i] * rims[i]
        vy += inverse[1, i] * rims[i]
        rw += inverse[2, i] * rims[i]
    return SlipState(vx, vy, rw, 0.0, 0.0, vx, vy, rw, 0.0, 0.0, 0, False, 0, 0, 0, 0, 0, False)
