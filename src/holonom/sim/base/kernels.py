"""A millisecond of a base's plant, compiled: motors, wheels, slip on the floor, the rigid body, sensors.

The slip force is stiff: a wheel of 0.1 kg at its rim follows the floor within a fraction of a millisecond. Force is
therefore taken as `F + k ds`, with the slope k of the slip curve (where it rises) and the slip at the end of the
step, the motor torque as `T - c dphid`; wheels are eliminated, a symmetric 3 x 3 system is left (linearly implicit
Euler; Hairer & Wanner, Solving ODEs II, IV.7). Forces are then held to the friction limit, and speeds follow from
the forces, so that mechanical energy balances to rounding.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.kernels import armature_step
from holonom.numeric.contact_loads import pushing_loads_at
from holonom.numeric.small_kernels import solve_positive3
from holonom.trace.code.compiled import arctan, select, sincos_half_turn
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH, any_of, largest, packed, total

__all__ = [
    "BLOCKED",
    "DEAD",
    "RUNS",
    "STUCK",
    "Supports",
    "break_motor",
    "plant_steps",
    "slip_friction",
]

RUNS, DEAD, BLOCKED, STUCK = 0, 1, 2, 3
"""A motor that works, one without current that turns freely, one that is jammed; a steering motor that stays."""

FLAGS = {"contract"}
ROLLER_SMOOTHING = 0.01  # m/s, below which roller drag goes over into its opposite
LEAST_SLIP = 1e-9  # m/s, keeps the direction of slip defined
FOOT = 1e-3  # m, half the length of a contact
JAMMED = 1e12  # kg m2
ROUNDING = 1e-12  # part of the weight: a wheel that carries nothing, give or take an ulp, has not lifted off

Integers = NDArray[np.int64]
Records = NDArray[np.void]


class Supports(NamedTuple):
    """How weight spreads over the wheels of a body: driven ones first, then castors and spheres."""

    passive: Array  # (k, 3) shares of weight and its moments, of the supports beside the driven wheels
    contacts: Array  # (m + k, 2) about the centre of mass, m
    loads: Array  # (m + k,) scratch, N
    middle: Array  # (2,) of the contacts, m


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def slip_friction(material: Any, slip: Any) -> tuple[Any, Any]:
    """Friction coefficient and its slope (s/m) at a slip speed (m/s): `D sin(C atan(B s))`; 0 where it falls."""
    x = material.stiffness * abs(slip)
    sine, cosine = sincos_half_turn(material.shape * arctan(x))
    steepest = material.peak * material.shape * material.stiffness
    return math.copysign(material.peak * sine, slip), steepest / (1.0 + x * x) * max(cosine, 0.0)


@loop(error_model="numpy", fastmath=FLAGS)
def break_motor(states: Any, lane: int, kind: int) -> None:
    """Give the motors of a wheel, a lane of its record, one of the states `RUNS`, `DEAD`, `BLOCKED`, `STUCK`."""
    if kind == STUCK:
        states.free[lane] = 0.0
        return
    states.conducts[lane] = 0.0 if kind == DEAD else 1.0
    states.jam[lane] = JAMMED if kind == BLOCKED else 0.0
    if kind == BLOCKED:
        states.speed[lane] = 0.0
    if kind != RUNS:
        states.current[lane] = 0.0


@loop(error_model="numpy", fastmath=FLAGS)
def plant_steps(
    body: Any, state: Any, wheels: Records, states: Records, supports: Supports, turning: int | None
) -> None:
    """Advance body and wheels by `body.substeps` steps of `body.dt`, in place.

    Four wheels are a record of `packed` numbers. `turning` is None where no wheel turns about its vertical axis: what
    is there for those is then not even compiled.
    """
    for _ in range(body.substeps):
        _step(body, state, wheels, states, supports, turning)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _step(body: Any, state: Any, wheels: Records, states: Records, supports: Supports, turning: int | None) -> None:
    """Forces from the slip at the end of the step, to first order; wheels are eliminated, the body's 3 x 3 is left."""
    h = body.dt
    _weigh(body, state, wheels, states, supports)
    xx = yy = body.mass
    ww = body.inertia
    xy = xw = yw = 0.0
    bx, by, bw = h * body.mass * state.down_x, h * body.mass * state.down_y, 0.0
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        torque, damping = _motor(wheel, own, h)
        along, across, kl, kx = _slip(wheel, own, state, turning)
        if turning is not None:
            across, kx = _swung(wheel, own, across, kx, h, state.w)
            bw -= h * total(own.moment)
        lx, ly, lw = own.along_x, own.along_y, own.along_arm
        cx, cy, cw = own.across_x, own.across_y, own.across_arm
        rl, rx = wheel.along_radius, wheel.across_radius
        inertia = wheel.inertia + h * damping + own.jam
        yielding = h / (inertia + h * (kl * rl * rl + kx * rx * rx))
        ql, qc = kl * rl, kx * rx
        qx, qy, qw = ql * lx + qc * cx, ql * ly + qc * cy, ql * lw + qc * cw
        pull = yielding * (torque - rl * along - rx * across)
        bx += h * total(lx * along + cx * across + qx * pull)
        by += h * total(ly * along + cy * across + qy * pull)
        bw += h * total(lw * along + cw * across + qw * pull)
        g, hl, hc = h * yielding, h * kl, h * kx
        xx += total(hl * lx * lx + hc * cx * cx - g * qx * qx)
        yy += total(hl * ly * ly + hc * cy * cy - g * qy * qy)
        ww += total(hl * lw * lw + hc * cw * cw - g * qw * qw)
        xy += total(hl * lx * ly + hc * cx * cy - g * qx * qy)
        xw += total(hl * lx * lw + hc * cx * cw - g * qx * qw)
        yw += total(hl * ly * lw + hc * cy * cw - g * qy * qw)
        own.torque, own.effective, own.yielding = torque, inertia, yielding
        own.along, own.across, own.along_stiffness, own.across_stiffness = along, across, kl, kx
    dx, dy, dw = solve_positive3(xx, yy, ww, xy, xw, yw, bx, by, bw)
    _advance(body, state, wheels, states, dx, dy, dw, turning)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _weigh(body: Any, state: Any, wheels: Records, states: Records, supports: Supports) -> None:
    """Loads (N) from weight and the moments `-M a h` of acceleration; no wheel can pull on the floor.

    Where none carry both, the body tips: then those that would pull carry nothing.
    """
    weight, lever = body.mass * body.gravity, -body.mass * body.height
    tip_x, tip_y = lever * (state.ax - state.down_x), lever * (state.ay - state.down_y)
    least, passive = 0.0, supports.passive
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        own.load = wheel.share * weight + wheel.share_x * tip_x + wheel.share_y * tip_y
        least = min(least, -largest(-own.load))
    for i in range(len(passive)):
        least = min(least, passive[i, 0] * weight + passive[i, 1] * tip_x + passive[i, 2] * tip_y)
    state.light = 0
    if least < -ROUNDING * weight:
        _lift(weight, tip_x, tip_y, state, wheels, states, supports)


@loop(error_model="numpy", fastmath=FLAGS)
def _lift(
    weight: float, tip_x: float, tip_y: float, state: Any, wheels: Records, states: Records, supports: Supports
) -> None:
    """Loads where some wheel has lifted off, or all that is left where the body tips."""
    contacts, loads = supports.contacts, supports.loads
    stands = pushing_loads_at(contacts, weight, tip_x, tip_y, loads)
    if not stands:  # the force may pass through the far end of a tyre's contact
        x, y = supports.middle[0] - tip_x / weight, supports.middle[1] - tip_y / weight
        inwards = weight * FOOT / math.sqrt(x * x + y * y)
        stands = pushing_loads_at(contacts, weight, tip_x + inwards * x, tip_y + inwards * y, loads)
    if stands:
        for i in range(len(contacts) - len(supports.passive)):
            states[i // WIDTH].load[i % WIDTH] = loads[i]
        return
    state.light, carried = 1, 0.0
    for i in range(len(states)):
        own = packed(states[i])
        own.load = max(own.load, 0.0)
        carried += total(own.load)
    for i in range(len(states)):
        own = packed(states[i])
        own.load *= weight / max(carried, weight)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _motor(wheel: Any, own: Any, h: float) -> tuple[Any, Any]:
    """Current at the end of the step, torque on the wheel, and how torque falls with wheel speed (N m s)."""
    ratio = wheel.gear.ratio
    speed = ratio * own.speed
    own.current = own.conducts * armature_step(wheel.armature, own.current, own.voltage, speed)
    electric = own.conducts * wheel.torque_constant * wheel.current_slope
    friction, slope = _friction(wheel.friction, speed)
    motor = wheel.torque_constant * own.current - friction
    gain = select(motor * speed >= 0.0, wheel.gain, wheel.gain_back)  # as `devices.gear_torque`
    return gain * motor, ratio * gain * (electric + slope)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _friction(params: Any, speed: Any) -> tuple[Any, Any]:
    """Return `devices.friction_torque` and its slope (N m s) at a motor speed."""
    coulomb = select(speed > 0.0, params.coulomb_positive, params.coulomb_negative)
    smooth = params.smoothing * params.smoothing
    inverse = 1.0 / math.sqrt(speed * speed + smooth)
    part = coulomb * inverse
    return params.viscous * speed + part * speed, params.viscous + part * smooth * inverse * inverse


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _slip(wheel: Any, own: Any, state: Any, turning: int | None) -> tuple[Any, Any, Any, Any]:
    """Forces on the base along and across (N), and their slopes over slip (N s/m), at the start of the step."""
    along = wheel.along_radius * own.speed - (own.along_x * state.vx + own.along_y * state.vy + own.along_arm * state.w)
    across = wheel.across_radius * own.speed - (
        own.across_x * state.vx + own.across_y * state.vy + own.across_arm * state.w
    )
    if turning is not None:
        across = across - wheel.lever * own.swing
    own.slip = along
    tyre = wheel.rollers < 1.0
    forces = _roller_forces(wheel, own, along, across)
    if any_of(tyre):
        forces = _chosen(tyre, _tyre_forces(own, along, across), forces)
    return forces


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _roller_forces(wheel: Any, own: Any, along: Any, across: Any) -> tuple[Any, Any, Any, Any]:
    """Friction along, bearing drag across; forces and slopes."""
    mu, slope = slip_friction(own.material, along)
    drag = own.load * min(wheel.roller_drag, own.material.peak)
    inverse = 1.0 / math.sqrt(across * across + ROLLER_SMOOTHING * ROLLER_SMOOTHING)
    part = ROLLER_SMOOTHING * inverse
    return own.load * mu, drag * inverse * across, own.load * slope, drag * inverse * part * part


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _tyre_forces(own: Any, along: Any, across: Any) -> tuple[Any, Any, Any, Any]:
    """Friction in the direction of slip; forces, and their secants instead of slopes."""
    slip = math.sqrt(along * along + across * across) + LEAST_SLIP
    mu, _ = slip_friction(own.material, slip)
    secant = own.load * mu / slip
    return secant * along, secant * across, secant, secant


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _chosen(which: Any, a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, Any, Any, Any]:
    return select(which, a[0], b[0]), select(which, a[1], b[1]), select(which, a[2], b[2]), select(which, a[3], b[3])


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _advance(
    body: Any, state: Any, wheels: Records, states: Records, dx: float, dy: float, dw: float, turning: int | None
) -> None:
    """Forces at the end of the step, within the friction limit; speeds, energies and pose from them."""
    h = body.dt
    fx, fy, fw = body.mass * state.down_x, body.mass * state.down_y, 0.0
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        along, across = _settle_wheel(wheel, own, h, dx, dy, dw)
        if turning is not None:
            fw -= total(_swing(wheel, own, across, h))
        fx += total(own.along_x * along + own.across_x * across)
        fy += total(own.along_y * along + own.across_y * across)
        fw += total(own.along_arm * along + own.across_arm * across)
    state.ax, state.ay, state.aw = fx / body.mass, fy / body.mass, fw / body.inertia
    dx, dy, dw = h * state.ax, h * state.ay, h * state.aw
    vx, vy, w = state.vx + 0.5 * dx, state.vy + 0.5 * dy, state.w + 0.5 * dw
    _book(state, wheels, states, h, vx, vy, w, turning)
    _move(state, h, vx + 0.5 * dx, vy + 0.5 * dy, w + 0.5 * dw)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _settle_wheel(wheel: Any, own: Any, h: float, dx: float, dy: float, dw: float) -> tuple[Any, Any]:
    """Final forces of a wheel (N), and the change of its speed."""
    rl, rx = wheel.along_radius, wheel.across_radius
    kl, kx, torque = own.along_stiffness, own.across_stiffness, own.torque
    body_along = own.along_x * dx + own.along_y * dy + own.along_arm * dw
    body_across = own.across_x * dx + own.across_y * dy + own.across_arm * dw
    turn = own.yielding * (torque - rl * own.along - rx * own.across + kl * rl * body_along + kx * rx * body_across)
    along = own.along + kl * (rl * turn - body_along)
    across = own.across + kx * (rx * turn - body_across)
    limit = own.load * own.material.peak
    beyond = along * along + across * across > limit * limit
    if any_of(beyond):
        held_along, held_across = _held(wheel, along, across, limit)
        along, across = select(beyond, held_along, along), select(beyond, held_across, across)
        turn = select(beyond, h * (torque - rl * along - rx * across) / own.effective, turn)
    own.along, own.across, own.turn = along, across, turn
    return along, across


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _swung(wheel: Any, own: Any, across: Any, stiffness: Any, h: float, w: float) -> tuple[Any, Any]:
    """Force across and its slope as the base feels them, with the turn about the vertical axis eliminated.

    `J dpsi = h (d F + T)` where F falls by k d dpsi and the torque T of motor or bearing by its own slope.
    """
    motor, lever = wheel.steering, wheel.lever
    turning = own.swing - w
    rate = min(max((own.asked - own.motor) / motor.lag, -motor.max_rate), motor.max_rate) * own.free
    gap = own.motor - own.turned
    wound = math.copysign(max(abs(gap) - motor.half_backlash, 0.0), gap)
    taut = select(abs(gap) >= motor.half_backlash, wheel.servo, 0.0)
    pull = taut * (motor.stiffness * wound + motor.damping * (rate - turning))
    held = min(max(pull, -motor.max_torque), motor.max_torque)
    slope = select(abs(pull) < motor.max_torque, taut * (motor.damping + h * motor.stiffness), 0.0)
    bearing = (1.0 - wheel.servo) * wheel.pivot_drag
    own.moment, own.moment_slope = held - bearing * turning, slope + bearing
    own.motor_rate = rate
    own.motor += h * rate
    give = h / (motor.inertia + h * (own.moment_slope + stiffness * lever * lever))
    lost = stiffness * lever * give
    return across - lost * (lever * across + own.moment), stiffness - lost * stiffness * lever


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _swing(wheel: Any, own: Any, across: Any, h: float) -> Any:
    """Turn a wheel's rate about its vertical axis on, by the final force across; return the torque (N m) on it."""
    inertia = wheel.steering.inertia
    change = h * (wheel.lever * across + own.moment) / (inertia + h * own.moment_slope)
    own.moment -= own.moment_slope * change
    own.moment_slope = change  # from here on the change of rate, which the step's mean rate is half of
    own.swing += wheel.turns * change
    return wheel.turns * own.moment


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _turn(wheel: Any, own: Any, h: float, w: float) -> None:
    """Turn a wheel on about its vertical axis, with the directions of its forces."""
    angle = h * wheel.turns * (own.swing - w)
    own.turned += angle
    c, s = _cosine_sine(angle)
    x, y = c * own.along_x - s * own.along_y, s * own.along_x + c * own.along_y
    length = 1.5 - 0.5 * (x * x + y * y)
    x, y = length * x, length * y
    own.along_x, own.along_y, own.along_arm = x, y, wheel.x * y - wheel.y * x
    own.across_x, own.across_y = select(wheel.turns > 0.0, -y, own.across_x), select(wheel.turns > 0.0, x, own.across_y)
    own.across_arm = wheel.x * own.across_y - wheel.y * own.across_x


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _held(wheel: Any, along: Any, across: Any, limit: Any) -> tuple[Any, Any]:
    """Forces held to the friction limit (N); rollers get what the drive leaves."""
    rolls = wheel.rollers > 0.0
    part = limit / math.sqrt(along * along + across * across)
    drive = min(max(along, -limit), limit)
    room = math.sqrt((limit - drive) * (limit + drive))  # never below 0, contracted or not
    return select(rolls, drive, part * along), select(rolls, min(max(across, -room), room), part * across)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _book(
    state: Any, wheels: Records, states: Records, h: float, vx: float, vy: float, w: float, turning: int | None
) -> None:
    """Turn the wheels on, and add the step to the energies, at the mean speeds of the step."""
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        turn, along, across, supply = own.turn, own.along, own.across, wheel.armature.max_voltage
        ratio, speed = wheel.gear.ratio, own.speed + 0.5 * turn
        current = own.current - own.conducts * wheel.current_slope * ratio * turn
        rim, rim_across = wheel.along_radius * speed, wheel.across_radius * speed
        slip = rim - (own.along_x * vx + own.along_y * vy + own.along_arm * w)
        slip_across = rim_across - (own.across_x * vx + own.across_y * vy + own.across_arm * w)
        if turning is not None:
            slip_across = slip_across - wheel.lever * (own.swing - 0.5 * own.moment_slope)
            done = h * own.moment * (own.swing - 0.5 * own.moment_slope - w)
            state.supplied += total(wheel.servo * done)
            state.airgap += total(wheel.servo * done)
            state.drag -= total((1.0 - wheel.servo) * done)
            _turn(wheel, own, h, w)
        work = wheel.torque_constant * current * ratio * speed
        state.supplied += h * total(current * min(max(own.voltage, -supply), supply))
        state.heat += h * total(current * current / wheel.armature.conductance)
        state.airgap += h * total(work)
        state.ground += h * total(along * slip + across * slip_across)
        state.drag += total(h * (work - along * rim - across * rim_across) - wheel.inertia * turn * speed)
        own.current = current
        own.speed += turn
        own.angle += h * own.speed


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _move(state: Any, h: float, vx: float, vy: float, w: float) -> None:
    """Pose from the new velocity (still in the old axes), which keeps its direction while base_link turns."""
    c, s = state.cosine, state.sine
    state.x += h * (c * vx - s * vy)
    state.y += h * (s * vx + c * vy)
    state.theta += h * w
    a, b = _cosine_sine(h * w)
    state.cosine, state.sine = a * c - b * s, a * s + b * c
    state.vx, state.vy, state.w = a * vx + b * vy, a * vy - b * vx, w


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _cosine_sine(angle: Any) -> tuple[Any, Any]:
    """Cosine and sine of the turn of one step, by their series; exact to rounding below 0.1 rad."""
    z = angle * angle
    cosine = 1.0 - z / 2.0 * (1.0 - z / 12.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0)))
    return cosine, angle * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0))))
