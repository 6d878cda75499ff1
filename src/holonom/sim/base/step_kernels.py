"""A millisecond of a simulated base, compiled: the floor under its wheels, steps of the plant, what breaks, sensors."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.drive_signals import WheelSignals
from holonom.devices.encoders.kernels import EncoderParams, encoder_counter
from holonom.numeric.small_kernels import solve_positive3
from holonom.sim.base.kernels import Supports, break_motor, plant_steps
from holonom.sim.base.lean_kernels import LeanParams
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH, load, packed, store

__all__ = ["BasePlantParams", "SensorParams", "advance", "base_acceleration", "find_material", "sense"]

FLAGS = {"contract"}
TICK = 1e-3  # s, of a step
HELD = 1e6  # weight of wheels that must not slide, beside those that roll
SOFT = 1e-12  # added to normal equations, which wheels at standstill may leave singular
TIPS = 10  # ms for which nothing carries a base that has tipped over
Integers = NDArray[np.int64]
Records = NDArray[np.void]


class SensorParams(NamedTuple):
    """Gyro and accelerometer: standard deviation of a sample, offset; shunt: standard deviation."""

    gyro_noise: float
    gyro_bias: float
    accelerometer_noise: float
    accelerometer_bias: float
    current_noise: float


class BasePlantParams(NamedTuple):
    """A base on its floor, with its sensors and what breaks."""

    body: Records  # (1,)
    wheels: Records  # (n,) fours
    supports: Supports
    floor: Records
    patches: Records
    faults: Integers  # (f, 3) tick, wheel, kind, in order of time
    sensors: SensorParams
    turning: int | None  # None: no wheel turns about its vertical axis
    lean: LeanParams | None  # None: the body does not balance
    steps: Records | None  # None: the floor has none
    ideal: bool  # wheels turn as they are told, and do not slip
    forward: Array  # (3, 4 n) twist (vx, vy, w) of the centre of mass per wheel speed where nothing slips


@loop(error_model="numpy", forceinline=True)
def advance(params: BasePlantParams, state: Records, states: Records, signals: WheelSignals, noise: Array) -> None:
    """One millisecond under the voltages of `signals`, then what the sensors read, in it.

    `noise` (3 + 4 n,) are standard normal numbers: gyro, accelerometers, shunts; two more where the body balances.
    """
    body = state[0]
    if params.ideal:
        _follow(params, body, states, signals)
        sense(params, state, states, signals, noise)
        return
    near = _floor(params.floor, params.patches, body, params.wheels, states, body.near != 0)
    body.near = 1 if near else 0
    for i in range(len(states)):
        packed(states[i]).voltage = load(signals.voltages, i)
    known = params.body[0]
    body.down_x = body.cosine * known.slope_x + body.sine * known.slope_y
    body.down_y = body.cosine * known.slope_y - body.sine * known.slope_x
    if params.turning is not None:
        _ask(params.wheels, states, signals.steering)
    plant_steps(known, body, params.wheels, states, params.supports, params.turning, params.lean, params.steps)
    body.tick += 1
    body.tipping = body.tipping + 1 if body.light != 0 else max(body.tipping - 1, 0)
    if body.tipping >= TIPS and body.tipped == 0:
        body.tipped = body.tick
    _fall(params.lean, body)
    sense(params, state, states, signals, noise)


@loop(error_model="numpy", forceinline=True)
def sense(params: BasePlantParams, state: Records, states: Records, signals: WheelSignals, noise: Array) -> None:
    """What breaks now breaks; then counters (16 bit), currents (A), turning rate (rad/s) and acceleration (m/s2)."""
    body, sensors = state[0], params.sensors
    while body.fault < len(params.faults) and params.faults[body.fault, 0] <= body.tick:
        wheel = params.faults[body.fault, 1]
        break_motor(states[wheel // WIDTH], wheel % WIDTH, params.faults[body.fault, 2])
        body.fault += 1
    signals.inertial[0] = body.w + sensors.gyro_bias + sensors.gyro_noise * noise[0]
    ax, ay = base_acceleration(params.body[0], body)
    ax, ay = ax - body.down_x, ay - body.down_y  # at rest on a slope they show it
    ax = _sense_pitch(params.lean, sensors, body, signals, noise, ax)
    signals.inertial[1] = ax + sensors.accelerometer_bias + sensors.accelerometer_noise * noise[1]
    signals.inertial[2] = ay + sensors.accelerometer_bias + sensors.accelerometer_noise * noise[2]
    for i in range(len(states)):
        wheel, own = params.wheels[i], states[i]
        for lane in range(WIDTH):
            encoder = EncoderParams(wheel.encoder.counts_per_rad[lane], wheel.encoder.resolution[lane])
            own.shown[lane] += own.counts[lane] * (own.angle[lane] - own.shown[lane])
            counter = encoder_counter(encoder, wheel.gear.ratio[lane] * own.shown[lane])
            signals.counters[i * WIDTH + lane] = counter
        store(signals.currents, i, packed(own).current + sensors.current_noise * load(noise[3:], i))
        if params.turning is not None:
            turned = packed(wheel).steering.step * (np.floor(packed(own).turned / packed(wheel).steering.step) + 0.5)
            store(signals.turned, i, packed(wheel).turns * turned)


@loop(error_model="numpy", forceinline=True)
def _sense_pitch(
    lean: LeanParams | None, sensors: SensorParams, body: Any, signals: WheelSignals, noise: Array, ax: float
) -> float:
    """What an IMU at the axle, which pitches with the body, reads beside: rate of pitch, acceleration along its z.

    Returns the acceleration along its x.
    """
    if lean is None:
        return ax
    s, c = sincos(body.pitch)
    signals.inertial[0] += body.w * (c - 1.0)
    last = len(noise) - 2
    signals.inertial[3] = body.pitch_rate + sensors.gyro_bias + sensors.gyro_noise * noise[last]
    up = s * ax + c * lean.gravity
    signals.inertial[4] = up + sensors.accelerometer_bias + sensors.accelerometer_noise * noise[last + 1]
    return c * ax - s * lean.gravity


@loop(error_model="numpy", forceinline=True)
def _fall(lean: LeanParams | None, body: Any) -> None:
    """A body that balances and leans too far has fallen."""
    if lean is None:
        return
    if abs(body.pitch) >= lean.limit and body.tipped == 0:
        body.tipped = body.tick


@loop(error_model="numpy", forceinline=True)
def _ask(wheels: Records, states: Records, steering: Array) -> None:
    """Hand angles to the steering motors, within their stops."""
    for i in range(len(states)):
        wheel, own = packed(wheels[i]), packed(states[i])
        own.asked = min(max(load(steering, i), -wheel.steering.limit), wheel.steering.limit)


@loop(error_model="numpy", forceinline=True)
def base_acceleration(known: Any, body: Any) -> tuple[float, float]:
    """Acceleration of base_link along its axes, m/s2: where its accelerometers are."""
    x, y, square = known.com_x, known.com_y, body.w * body.w
    return body.ax + body.aw * y + square * x, body.ay - body.aw * x + square * y


@loop(error_model="numpy", forceinline=True)
def _follow(params: BasePlantParams, body: Any, states: Records, signals: WheelSignals) -> None:
    """Wheels turn as they are told for a millisecond, and the base as they turn, on an arc."""
    if params.turning is not None:
        _follow_steered(params, body, states, signals)
        return
    vx = vy = w = 0.0
    for i in range(len(signals.speeds)):
        own, lane = states[i // WIDTH], i % WIDTH
        speed = signals.speeds[i]
        own.speed[lane] = speed
        own.angle[lane] += TICK * speed
        vx += params.forward[0, i] * speed
        vy += params.forward[1, i] * speed
        w += params.forward[2, i] * speed
    _arc(body, vx, vy, w)


@loop(error_model="numpy", forceinline=True)
def _follow_steered(params: BasePlantParams, body: Any, states: Records, signals: WheelSignals) -> None:
    """The same where wheels steer: each turns as fast as its motor can, then the twist that fits all of them best."""
    a = np.zeros((3, 3))
    b = np.zeros(3)
    row = np.zeros(3)
    reach = params.wheels[0].reach[0]
    for i in range(len(signals.speeds)):
        wheel, own, lane = params.wheels[i // WIDTH], states[i // WIDTH], i % WIDTH
        if wheel.reach[lane] == 0.0 or (wheel.turns[lane] > 0.0 and wheel.servo[lane] == 0.0):
            continue  # filling, and castors, which follow
        angle = 0.0
        if wheel.turns[lane] > 0.0:
            limit, most = wheel.steering.limit[lane], TICK * wheel.steering.max_rate[lane] * own.free[lane]
            asked = min(max(signals.steering[i], -limit), limit)
            part = 1.0 if wheel.lever[lane] == 0.0 else TICK / wheel.steering.lag[lane]  # castors are asked for rates
            angle = min(max(part * (asked - own.turned[lane]), -most), most)
            own.turned[lane] += angle
            own.motor[lane] = own.turned[lane]
            s, c = sincos(angle)
            x, y = own.along_x[lane], own.along_y[lane]
            own.along_x[lane], own.along_y[lane] = c * x - s * y, s * x + c * y
            own.across_x[lane], own.across_y[lane] = -own.along_y[lane], own.along_x[lane]
        if wheel.torque_constant[lane] > 0.0:
            speed = signals.speeds[i]
            own.speed[lane] = speed
            own.angle[lane] += TICK * speed
            x, y = own.along_x[lane], own.along_y[lane]
            row[0], row[1], row[2] = x, y, (wheel.x[lane] * y - wheel.y[lane] * x) / reach
            _fit(a, b, row, wheel.along_radius[lane] * speed, 1.0)
        if wheel.rollers[lane] == 0.0:
            x, y = own.across_x[lane], own.across_y[lane]
            lever = wheel.lever[lane]  # of a driven castor, whose motor swings it
            row[0], row[1], row[2] = x, y, (wheel.x[lane] * y - wheel.y[lane] * x + lever) / reach
            _fit(a, b, row, -lever * angle / TICK, HELD if lever == 0.0 else 1.0)
    vx, vy, w = solve_positive3(
        a[0, 0] + SOFT, a[1, 1] + SOFT, a[2, 2] + SOFT, a[0, 1], a[0, 2], a[1, 2], b[0], b[1], b[2]
    )
    _arc(body, vx, vy, w / reach)


@loop(error_model="numpy", forceinline=True)
def _fit(a: Array, b: Array, row: Array, speed: float, weight: float) -> None:
    """Add a row that times the twist should be a speed to normal equations."""
    for j in range(3):
        b[j] += weight * row[j] * speed
        for k in range(3):
            a[j, k] += weight * row[j] * row[k]


@loop(error_model="numpy", forceinline=True)
def _arc(body: Any, vx: float, vy: float, w: float) -> None:
    """Go on for a millisecond with a twist of the centre of mass."""
    body.ax, body.ay = (vx - body.vx) / TICK - w * vy, (vy - body.vy) / TICK + w * vx
    body.aw = (w - body.w) / TICK
    s, c = sincos(body.theta + 0.5 * TICK * w)
    body.x += TICK * (c * vx - s * vy)
    body.y += TICK * (s * vx + c * vy)
    body.theta += TICK * w
    body.vx, body.vy, body.w = vx, vy, w
    body.tick += 1


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


@loop(error_model="numpy", fastmath=FLAGS)
def find_material(floor: Records, patches: Records, x: float, y: float, states: Any, lane: int) -> None:
    """Set the material under a wheel, a lane of its record, at (x, y), m in the world; the last patch counts."""
    found = -1
    for k in range(len(patches)):
        patch = patches[k]
        dx, dy = x - patch.x, y - patch.y
        if patch.round:
            inside = dx * dx + dy * dy <= patch.half_length * patch.half_length
        else:
            along = patch.cosine * dx + patch.sine * dy
            across = patch.cosine * dy - patch.sine * dx
            inside = abs(along) <= patch.half_length and abs(across) <= patch.half_width
        if inside:
            found = k
    material = floor[0] if found < 0 else patches[found].material
    states.material.stiffness[lane] = material.stiffness
    states.material.shape[lane] = material.shape
    states.material.peak[lane] = material.peak * states.grips[lane]
