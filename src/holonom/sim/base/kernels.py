"""One step of a base's plant, compiled: motors, wheels, slip on the floor and the rigid body, semi-implicit.

The slip force is stiff: a wheel of 0.1 kg at its rim follows the floor within a fraction of a millisecond. Force is
therefore taken as `F + k ds`, with the slope k of the slip curve (where it rises) and the slip at the end of the
step, the motor torque as `T - c dphid`; wheels are eliminated, a symmetric 3 x 3 system is left (linearly implicit
Euler; Hairer & Wanner, Solving ODEs II, IV.7). Forces are then held to the friction limit, and speeds follow from
the forces, so that mechanical energy balances to rounding.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from holonom.devices.kernels import armature_step

__all__ = ["BLOCKED", "DEAD", "GRAVITY", "RUNS", "find_material", "plant_step", "slip_friction"]

RUNS, DEAD, BLOCKED = 0, 1, 2
"""A motor that works, one without current that turns freely, one that is jammed."""

FLAGS = {"contract"}
GRAVITY = 9.80665
ROLLER_SMOOTHING = 0.01  # m/s, below which roller drag goes over into its opposite
LEAST_SLIP = 1e-9  # m/s, keeps the direction of slip defined
HALF_PI = 0.5 * math.pi
JAMMED = 1e12  # kg m2

Floats = NDArray[np.float64]
Records = NDArray[np.void]


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def slip_friction(material: Any, slip: float) -> tuple[float, float]:
    """Friction coefficient and its slope (s/m) at a slip speed (m/s): `D sin(C atan(B s))`; 0 where it falls."""
    x = material.stiffness * slip
    angle = material.shape * math.atan(x)
    sine = math.sin(angle)
    if abs(angle) >= HALF_PI:
        return material.peak * sine, 0.0
    cosine = math.sqrt(max(1.0 - sine * sine, 0.0))
    slope = material.peak * material.shape * material.stiffness * cosine / (1.0 + x * x)
    return material.peak * sine, slope


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def find_material(floor: Records, patches: Records, x: float, y: float, wheel: Any) -> None:
    """Set the material under a wheel at (x, y), m in the world; the last patch counts."""
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
    wheel.material.stiffness = material.stiffness
    wheel.material.shape = material.shape
    wheel.material.peak = material.peak


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def plant_step(body: Any, state: Any, wheels: Records, states: Records, support: Floats) -> None:
    """Advance body and wheels by one step of `body.dt`, in place.

    `support` spreads the weight and its moments over the wheels on the floor, (k, 3): the driven ones first.
    """
    h = body.dt
    weight, lever = body.mass * GRAVITY, -body.mass * body.height
    tip_x, tip_y, carried = lever * state.ax, lever * state.ay, 0.0
    for i in range(len(support)):
        carried += _support(support, i, weight, tip_x, tip_y)
    part = weight / carried
    xx = yy = body.mass
    ww = body.inertia
    xy = xw = yw = 0.0
    bx = by = bw = 0.0
    for i in range(len(wheels)):
        wheel, own = wheels[i], states[i]
        own.load = part * _support(support, i, weight, tip_x, tip_y)
        torque, damping = _motor(wheel, own, h)
        along, across, kl, kx = _slip(wheel, own, state)
        lx, ly, lw = wheel.along_x, wheel.along_y, wheel.along_arm
        cx, cy, cw = wheel.across_x, wheel.across_y, wheel.across_arm
        rl, rx = wheel.along_radius, wheel.across_radius
        inertia = JAMMED if own.motor == BLOCKED else wheel.inertia + h * damping
        yielding = h / (inertia + h * (kl * rl * rl + kx * rx * rx))
        ql, qc = kl * rl, kx * rx
        qx, qy, qw = ql * lx + qc * cx, ql * ly + qc * cy, ql * lw + qc * cw
        pull = yielding * (torque - rl * along - rx * across)
        bx += h * (lx * along + cx * across + qx * pull)
        by += h * (ly * along + cy * across + qy * pull)
        bw += h * (lw * along + cw * across + qw * pull)
        g, hl, hc = h * yielding, h * kl, h * kx
        xx += hl * lx * lx + hc * cx * cx - g * qx * qx
        yy += hl * ly * ly + hc * cy * cy - g * qy * qy
        ww += hl * lw * lw + hc * cw * cw - g * qw * qw
        xy += hl * lx * ly + hc * cx * cy - g * qx * qy
        xw += hl * lx * lw + hc * cx * cw - g * qx * qw
        yw += hl * ly * lw + hc * cy * cw - g * qy * qw
        own.torque, own.effective, own.yielding = torque, inertia, yielding
        own.along, own.across, own.along_stiffness, own.across_stiffness = along, across, kl, kx
    dx, dy, dw = _solve(xx, yy, ww, xy, xw, yw, bx, by, bw)
    _advance(body, state, wheels, states, dx, dy, dw)


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _support(support: Floats, i: int, weight: float, tip_x: float, tip_y: float) -> float:
    """Load (N) of a wheel from weight and the moments `-M a h` of acceleration; it cannot pull on the floor."""
    return max(support[i, 0] * weight + support[i, 1] * tip_x + support[i, 2] * tip_y, 0.0)


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _motor(wheel: Any, own: Any, h: float) -> tuple[float, float]:
    """Current at the end of the step, torque on the wheel, and how torque falls with wheel speed (N m s)."""
    ratio = wheel.gear.ratio
    speed = ratio * own.speed
    current, electric = 0.0, 0.0
    if own.motor != DEAD:
        current = armature_step(wheel.armature, own.current, own.voltage, speed)
        electric = wheel.torque_constant * wheel.current_slope
    own.current = current
    friction, slope = _friction(wheel.friction, speed)
    motor = wheel.torque_constant * current - friction
    gain = wheel.gain if motor * speed >= 0.0 else wheel.gain_back  # as `devices.gear_torque`
    return gain * motor, ratio * gain * (electric + slope)


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _friction(params: Any, speed: float) -> tuple[float, float]:
    """Return `devices.friction_torque` and its slope (N m s) at a motor speed."""
    coulomb = params.coulomb_positive if speed > 0.0 else params.coulomb_negative
    smooth = params.smoothing * params.smoothing
    inverse = 1.0 / math.sqrt(speed * speed + smooth)
    part = coulomb * inverse
    return params.viscous * speed + part * speed, params.viscous + part * smooth * inverse * inverse


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _slip(wheel: Any, own: Any, state: Any) -> tuple[float, float, float, float]:
    """Forces on the base along and across (N), and their slopes over slip (N s/m), at the start of the step."""
    along = wheel.along_radius * own.speed - (
        wheel.along_x * state.vx + wheel.along_y * state.vy + wheel.along_arm * state.w
    )
    across = wheel.across_radius * own.speed - (
        wheel.across_x * state.vx + wheel.across_y * state.vy + wheel.across_arm * state.w
    )
    own.slip = along
    load, material = own.load, own.material
    if wheel.rollers:
        mu, slope = slip_friction(material, along)
        drag = load * min(wheel.roller_drag, material.peak)
        inverse = 1.0 / math.sqrt(across * across + ROLLER_SMOOTHING * ROLLER_SMOOTHING)
        part = ROLLER_SMOOTHING * inverse
        return load * mu, drag * inverse * across, load * slope, drag * inverse * part * part
    total = math.sqrt(along * along + across * across) + LEAST_SLIP
    mu, _ = slip_friction(material, total)
    secant = load * mu / total
    return secant * along, secant * across, secant, secant


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _solve(
    xx: float, yy: float, ww: float, xy: float, xw: float, yw: float, bx: float, by: float, bw: float
) -> tuple[float, float, float]:
    """Solve a symmetric positive 3 x 3 system by elimination."""
    f, g = xy / xx, xw / xx
    yy -= f * xy
    yw -= f * xw
    ww -= g * xw
    by -= f * bx
    bw -= g * bx
    e = yw / yy
    w = (bw - e * by) / (ww - e * yw)
    y = (by - yw * w) / yy
    return (bx - xy * y - xw * w) / xx, y, w


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _advance(body: Any, state: Any, wheels: Records, states: Records, dx: float, dy: float, dw: float) -> None:
    """Forces at the end of the step, within the friction limit; speeds, energies and pose from them."""
    h = body.dt
    fx = fy = fw = 0.0
    for i in range(len(wheels)):
        wheel, own = wheels[i], states[i]
        along, across = _settle_wheel(wheel, own, h, dx, dy, dw)
        fx += wheel.along_x * along + wheel.across_x * across
        fy += wheel.along_y * along + wheel.across_y * across
        fw += wheel.along_arm * along + wheel.across_arm * across
    state.ax, state.ay = fx / body.mass, fy / body.mass
    dx, dy, dw = h * state.ax, h * state.ay, h * fw / body.inertia
    vx, vy, w = state.vx + 0.5 * dx, state.vy + 0.5 * dy, state.w + 0.5 * dw
    _book(state, wheels, states, h, vx, vy, w)
    _move(state, h, vx + 0.5 * dx, vy + 0.5 * dy, w + 0.5 * dw)


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _settle_wheel(wheel: Any, own: Any, h: float, dx: float, dy: float, dw: float) -> tuple[float, float]:
    """Final forces of a wheel (N), and the change of its speed."""
    rl, rx = wheel.along_radius, wheel.across_radius
    kl, kx, along, across, torque = own.along_stiffness, own.across_stiffness, own.along, own.across, own.torque
    body_along = wheel.along_x * dx + wheel.along_y * dy + wheel.along_arm * dw
    body_across = wheel.across_x * dx + wheel.across_y * dy + wheel.across_arm * dw
    turn = own.yielding * (torque - rl * along - rx * across + kl * rl * body_along + kx * rx * body_across)
    along += kl * (rl * turn - body_along)
    across += kx * (rx * turn - body_across)
    limit = own.load * own.material.peak
    if along * along + across * across > limit * limit:
        along, across = _held(wheel.rollers, along, across, limit)
        turn = h * (torque - rl * along - rx * across) / own.effective
    own.along, own.across, own.turn = along, across, turn
    return along, across


@njit(cache=True, error_model="numpy", fastmath=FLAGS)
def _held(rollers: int, along: float, across: float, limit: float) -> tuple[float, float]:
    """Forces held to the friction limit (N); rollers get what the drive leaves."""
    if rollers:
        along = min(max(along, -limit), limit)
        room = math.sqrt((limit - along) * (limit + along))  # never below 0, contracted or not
        return along, min(max(across, -room), room)
    part = limit / math.sqrt(along * along + across * across)
    return part * along, part * across


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _book(state: Any, wheels: Records, states: Records, h: float, vx: float, vy: float, w: float) -> None:
    """Turn the wheels on, and add the step to the energies, at the mean speeds of the step."""
    supplied = heat = airgap = drag = ground = 0.0
    for i in range(len(wheels)):
        wheel, own = wheels[i], states[i]
        turn, before, along, across, current = own.turn, own.speed, own.along, own.across, own.current
        ratio, speed = wheel.gear.ratio, before + 0.5 * turn
        if own.motor != DEAD:
            current -= wheel.current_slope * ratio * turn
            supplied += current * min(max(own.voltage, -wheel.armature.max_voltage), wheel.armature.max_voltage)
            heat += current * current / wheel.armature.conductance
        rim, rim_across = wheel.along_radius * speed, wheel.across_radius * speed
        slip = rim - (wheel.along_x * vx + wheel.along_y * vy + wheel.along_arm * w)
        slip_across = rim_across - (wheel.across_x * vx + wheel.across_y * vy + wheel.across_arm * w)
        work = wheel.torque_constant * current * ratio * speed
        airgap += work
        ground += along * slip + across * slip_across
        drag += h * (work - along * rim - across * rim_across) - wheel.inertia * turn * speed
        own.current, own.speed = current, before + turn
        own.angle += h * (before + turn)
    state.supplied += h * supplied
    state.heat += h * heat
    state.airgap += h * airgap
    state.drag += drag
    state.ground += h * ground


@njit(cache=True, error_model="numpy", fastmath=FLAGS, forceinline=True)
def _move(state: Any, h: float, vx: float, vy: float, w: float) -> None:
    """Pose from the new velocity (still in the old axes), which keeps its direction while base_link turns."""
    c, s = state.cosine, state.sine
    state.x += h * (c * vx - s * vy)
    state.y += h * (s * vx + c * vy)
    state.theta += h * w
    half = 0.5 * h * w
    t = half * (1.0 + half * half / 3.0)  # tangent
    n = 1.0 / (1.0 + t * t)
    a, b = n * (1.0 - t * t), 2.0 * n * t
    state.cosine, state.sine = a * c - b * s, a * s + b * c
    state.vx, state.vy, state.w = a * vx + b * vy, a * vy - b * vx, w
