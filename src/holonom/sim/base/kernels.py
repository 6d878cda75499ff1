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
from holonom.devices.motors.kernels import armature_step
from holonom.devices.transmission.kernels import stribeck
from holonom.numeric.contact_loads import pushing_loads_at
from holonom.numeric.small_kernels import solve_positive3, solve_positive4
from holonom.sim.base.climb_kernels import climb
from holonom.sim.base.contact_kernels import chosen, held, roller_forces, tyre_forces
from holonom.sim.base.lean_kernels import LeanParams, leaning_terms, leaning_weight
from holonom.sim.base.swing_kernels import cosine_sine, swing, swung, turn_on
from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH, any_of, largest, packed, total

__all__ = [
    "BLOCKED",
    "DEAD",
    "FROZEN",
    "OFF",
    "RUNS",
    "STUCK",
    "Supports",
    "break_motor",
    "plant_steps",
]

RUNS, DEAD, BLOCKED, STUCK, FROZEN, OFF = 0, 1, 2, 3, 4, 5
"""A motor that works, one without current that turns freely, one that is jammed; a steering motor that stays; an
encoder that counts no more; a wheel that turns on its axle no more, or is off."""

FLAGS = {"contract"}
FOOT = 1e-3  # m, half the length of a contact
JAMMED = 1e12  # kg m2
LOOSE = 1e-4  # of its grip that a wheel has left which is off
ROUNDING = 1e-12  # part of the weight: a wheel that carries nothing, give or take an ulp, has not lifted off

Integers = NDArray[np.int64]
Records = NDArray[np.void]


class Supports(NamedTuple):
    """How weight spreads over the wheels of a body: driven ones first, then castors and spheres."""

    passive: Array  # (k, 3) shares of weight and its moments, of the supports beside the driven wheels
    contacts: Array  # (m + k, 2) about the centre of mass, m
    loads: Array  # (m + k,) scratch, N
    middle: Array  # (2,) of the contacts, m


@loop(error_model="numpy", fastmath=FLAGS)
def break_motor(states: Any, lane: int, kind: int) -> None:
    """Give a wheel, a lane of its record, one of the states from `RUNS` to `OFF`."""
    if kind == STUCK:
        states.free[lane] = 0.0
        return
    if kind == FROZEN:
        states.counts[lane] = 0.0
        return
    if kind == OFF:
        states.grips[lane] = LOOSE
        states.material.peak[lane] *= LOOSE
        return
    states.conducts[lane] = 0.0 if kind == DEAD else 1.0
    states.jam[lane] = JAMMED if kind == BLOCKED else 0.0
    if kind == BLOCKED:
        states.speed[lane] = 0.0
    if kind != RUNS:
        states.current[lane] = 0.0


@loop(error_model="numpy", fastmath=FLAGS)
def plant_steps(
    body: Any, state: Any, wheels: Records, states: Records, supports: Supports, turning: int | None,
    lean: LeanParams | None, steps: Records | None,
) -> None:  # fmt: skip
    """Advance body and wheels by `body.substeps` steps of `body.dt`, in place.

    Four wheels are a record of `packed` numbers. `turning` is None where no wheel turns about its vertical axis, `lean`
    where the body does not balance, `steps` where the floor has none: what is there for those is not even compiled.
    """
    for _ in range(body.substeps):
        _step(body, state, wheels, states, supports, turning, lean, steps)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _step(
    body: Any, state: Any, wheels: Records, states: Records, supports: Supports, turning: int | None,
    lean: LeanParams | None, steps: Records | None,
) -> None:  # fmt: skip
    """Forces from the slip at the end of the step, to first order; wheels are eliminated, the body's 3 x 3 is left.

    A body that balances has its pitch beside them: its rate turns the rims as the wheels' own speeds do.
    """
    h = body.dt
    _weigh(body, state, wheels, states, supports, lean)
    xx, yy, ww = body.mass, body.mass, body.inertia
    xy = xw = yw = xp = yp = wp = pp = bp = 0.0
    bx, by, bw = h * body.mass * state.down_x, h * body.mass * state.down_y, 0.0
    if lean is not None:
        terms = leaning_terms(lean, state)
        xp, yw, ww, pp = body.mass * terms.up, body.mass * terms.ahead, terms.turning, terms.pitching
        bx, by, bw, bp = bx + h * terms.x, by + h * terms.y, h * terms.turn, h * terms.pitch
    if steps is not None:
        climb(steps, body, state, wheels, states)
        bx, by, bw = bx + h * state.push_x, by + h * state.push_y, bw + h * state.push_turn
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        torque, damping = _motor(wheel, own, h)
        along, across, kl, kx = _slip(wheel, own, state, turning, lean)
        if turning is not None:
            across, kx = swung(wheel, own, across, kx, h, state.w)
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
        if lean is not None:
            qp = -(ql * rl + qc * rx + wheel.coupled / h)
            bp += h * total(qp * pull - rl * along - rx * across)
            pp += total(hl * rl * rl + hc * rx * rx - g * qp * qp)
            xp -= total(hl * lx * rl + hc * cx * rx + g * qx * qp)
            yp -= total(hl * ly * rl + hc * cy * rx + g * qy * qp)
            wp -= total(hl * lw * rl + hc * cw * rx + g * qw * qp)
        own.torque, own.effective, own.yielding = torque, inertia, yielding
        own.along, own.across, own.along_stiffness, own.across_stiffness = along, across, kl, kx
    if lean is not None:
        dx, dy, dw, dp = solve_positive4((xx, yy, ww, xy, xw, yw), (xp, yp, wp, pp), (bx, by, bw, bp))
        _advance(body, state, wheels, states, dx, dy, dw, dp, turning, lean, steps)
    else:
        dx, dy, dw = solve_positive3(xx, yy, ww, xy, xw, yw, bx, by, bw)
        _advance(body, state, wheels, states, dx, dy, dw, 0.0, turning, lean, steps)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _weigh(
    body: Any, state: Any, wheels: Records, states: Records, supports: Supports, lean: LeanParams | None
) -> None:
    """Loads (N) from weight and the moments `-M a h` of acceleration; no wheel can pull on the floor.

    Where none carry both, the body tips: then those that would pull carry nothing.
    """
    weight, lever = body.mass * body.gravity, -body.mass * body.height
    tip_x, tip_y = lever * (state.ax - state.down_x), lever * (state.ay - state.down_y)
    if lean is not None:
        weight, tip_x, tip_y = leaning_weight(lean, body, state)
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
    friction, slope = _friction(wheel.friction, own, speed)
    motor = wheel.torque_constant * own.current - friction
    gain = select(motor * speed >= 0.0, wheel.gain, wheel.gain_back)  # as `devices.gear_torque`
    return gain * motor, ratio * gain * (electric + slope)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _friction(params: Any, own: Any, speed: Any) -> tuple[Any, Any]:
    """Return `devices.stiction_step` and its slope (N m s) at a motor speed; none where it slips."""
    grown, winding = stribeck(params.rise, params.per_stribeck, speed), params.winding * speed
    low, high = -grown * params.coulomb_negative, grown * params.coulomb_positive
    own.held = min(max(own.held + winding, low), high)
    wanted = own.held + winding
    held = min(max(wanted, low), high)
    return params.viscous * speed + held, params.viscous + select(abs(wanted - held) > 0.0, 0.0, params.winding)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _slip(wheel: Any, own: Any, state: Any, turning: int | None, lean: LeanParams | None) -> tuple[Any, Any, Any, Any]:
    """Forces on the base along and across (N), and their slopes over slip (N s/m), at the start of the step."""
    along = wheel.along_radius * own.speed - (own.along_x * state.vx + own.along_y * state.vy + own.along_arm * state.w)
    across = wheel.across_radius * own.speed - (
        own.across_x * state.vx + own.across_y * state.vy + own.across_arm * state.w
    )
    if turning is not None:
        across = across - wheel.lever * own.swing
    if lean is not None:  # wheels turn against the body, and with it
        along = along + wheel.along_radius * state.pitch_rate
        across = across + wheel.across_radius * state.pitch_rate
    own.slip = along
    tyre = wheel.rollers < 1.0
    forces = roller_forces(wheel, own, along, across)
    if any_of(tyre):
        forces = chosen(tyre, tyre_forces(own, along, across), forces)
    return forces


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _advance(
    body: Any, state: Any, wheels: Records, states: Records, dx: float, dy: float, dw: float, dp: float,
    turning: int | None, lean: LeanParams | None, steps: Records | None,
) -> None:  # fmt: skip
    """Forces at the end of the step, within the friction limit; speeds, energies and pose from them."""
    h = body.dt
    fx, fy, fw, fp, shared = body.mass * state.down_x, body.mass * state.down_y, 0.0, 0.0, 0.0
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        along, across = _settle_wheel(wheel, own, h, dx, dy, dw, dp, lean)
        if turning is not None:
            fw -= total(swing(wheel, own, across, h))
        fx += total(own.along_x * along + own.across_x * across)
        fy += total(own.along_y * along + own.across_y * across)
        fw += total(own.along_arm * along + own.across_arm * across)
        if lean is not None:
            rim = wheel.along_radius * along + wheel.across_radius * across
            part = wheel.coupled / own.effective
            fp -= total(rim + part * (own.torque - rim))
            shared += total(part * wheel.coupled)
    if steps is not None:
        fx, fy, fw = fx + state.push_x, fy + state.push_y, fw + state.push_turn
    if lean is not None:
        terms = leaning_terms(lean, state)
        fx, fy, fw, fp = fx + terms.x, fy + terms.y, fw + terms.turn, fp + terms.pitch
        state.pitch_acceleration = (fp - terms.up * fx) / (terms.pitching - shared - body.mass * terms.up * terms.up)
        state.aw = (fw - terms.ahead * fy) / (terms.turning - body.mass * terms.ahead * terms.ahead)
        state.ax = fx / body.mass - terms.up * state.pitch_acceleration
        state.ay = fy / body.mass - terms.ahead * state.aw
        _turn_wheels(wheels, states, h, state.pitch_acceleration)
    else:
        state.ax, state.ay, state.aw = fx / body.mass, fy / body.mass, fw / body.inertia
    dx, dy, dw = h * state.ax, h * state.ay, h * state.aw
    vx, vy, w = state.vx + 0.5 * dx, state.vy + 0.5 * dy, state.w + 0.5 * dw
    _book(state, wheels, states, h, vx, vy, w, turning, lean)
    if steps is not None:
        state.lifted -= h * (state.push_x * vx + state.push_y * vy + state.push_turn * w)
    if lean is not None:
        state.pitch_rate += h * state.pitch_acceleration
        state.pitch += h * state.pitch_rate
    _move(state, h, vx + 0.5 * dx, vy + 0.5 * dy, w + 0.5 * dw)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _turn_wheels(wheels: Records, states: Records, h: float, pitching: float) -> None:
    """Change of the wheels' speeds against a body that pitches, by the final forces."""
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        rim = wheel.along_radius * own.along + wheel.across_radius * own.across
        own.turn = h * (own.torque - rim - wheel.coupled * pitching) / own.effective


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _settle_wheel(
    wheel: Any, own: Any, h: float, dx: float, dy: float, dw: float, dp: float, lean: LeanParams | None
) -> tuple[Any, Any]:
    """Final forces of a wheel (N), and the change of its speed."""
    rl, rx = wheel.along_radius, wheel.across_radius
    kl, kx, torque = own.along_stiffness, own.across_stiffness, own.torque
    body_along = own.along_x * dx + own.along_y * dy + own.along_arm * dw
    body_across = own.across_x * dx + own.across_y * dy + own.across_arm * dw
    if lean is not None:
        body_along, body_across = body_along - rl * dp, body_across - rx * dp
        torque = torque - wheel.coupled * dp / h
    turn = own.yielding * (torque - rl * own.along - rx * own.across + kl * rl * body_along + kx * rx * body_across)
    along = own.along + kl * (rl * turn - body_along)
    across = own.across + kx * (rx * turn - body_across)
    limit = own.load * own.material.peak
    beyond = along * along + across * across > limit * limit
    if any_of(beyond):
        held_along, held_across = held(wheel, along, across, limit)
        along, across = select(beyond, held_along, along), select(beyond, held_across, across)
        turn = select(beyond, h * (torque - rl * along - rx * across) / own.effective, turn)
    own.along, own.across, own.turn = along, across, turn
    return along, across


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _book(
    state: Any, wheels: Records, states: Records, h: float, vx: float, vy: float, w: float, turning: int | None,
    lean: LeanParams | None,
) -> None:  # fmt: skip
    """Turn the wheels on, and add the step to the energies, at the mean speeds of the step."""
    for i in range(len(wheels)):
        wheel, own = packed(wheels[i]), packed(states[i])
        turn, along, across, supply = own.turn, own.along, own.across, wheel.armature.max_voltage
        ratio, speed = wheel.gear.ratio, own.speed + 0.5 * turn
        current = own.current - own.conducts * wheel.current_slope * ratio * turn
        rim, rim_across = wheel.along_radius * speed, wheel.across_radius * speed
        slip = rim - (own.along_x * vx + own.along_y * vy + own.along_arm * w)
        slip_across = rim_across - (own.across_x * vx + own.across_y * vy + own.across_arm * w)
        if lean is not None:
            pitching = state.pitch_rate + 0.5 * h * state.pitch_acceleration
            slip = slip + wheel.along_radius * pitching
            slip_across = slip_across + wheel.across_radius * pitching
            state.drag -= h * state.pitch_acceleration * total(wheel.coupled * speed)
        if turning is not None:
            slip_across = slip_across - wheel.lever * (own.swing - 0.5 * own.moment_slope)
            done = h * own.moment * (own.swing - 0.5 * own.moment_slope - w)
            state.supplied += total(wheel.servo * done)
            state.airgap += total(wheel.servo * done)
            state.drag -= total((1.0 - wheel.servo) * done)
            turn_on(wheel, own, h, w)
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
    a, b = cosine_sine(h * w)
    state.cosine, state.sine = a * c - b * s, a * s + b * c
    state.vx, state.vy, state.w = a * vx + b * vy, a * vy - b * vx, w
