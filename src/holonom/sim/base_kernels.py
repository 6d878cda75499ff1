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

from holonom.devices.kernels import armature_step, gear_torque

__all__ = ["BLOCKED", "DEAD", "GRAVITY", "RUNS", "find_material", "plant_step", "slip_friction"]

RUNS, DEAD, BLOCKED = 0, 1, 2
"""A motor that works, one without current that turns freely, one that is jammed."""

GRAVITY = 9.80665
ROLLER_SMOOTHING = 0.01  # m/s, below which roller drag goes over into its opposite
LEAST_SLIP = 1e-9  # m/s, keeps the direction of slip defined
HALF_PI = 0.5 * math.pi
JAMMED = 1e12  # kg m2

Floats = NDArray[np.float64]
Records = NDArray[np.void]


@njit(cache=True, error_model="numpy", forceinline=True)
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


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def plant_step(body: Any, state: Any, wheels: Records, states: Records, support: Floats) -> None:
    """Advance body and wheels by one step of `body.dt`, in place; in place.

    `support` spreads the weight and its moments over the wheels on the floor, (k, 3): the driven ones first.
    """
    h = body.dt
    _loads(body, state, states, support)
    xx = yy = body.mass
    ww = body.inertia
    xy = xw = yw = 0.0
    bx = by = bw = 0.0
    for i in range(len(wheels)):
        wheel, own = wheels[i], states[i]
        _motor(wheel, own, h)
        _slip(wheel, own, state)
        kl, kx = own.along_stiffness, own.across_stiffness
        rl, rx = wheel.along_radius, wheel.across_radius
        own.yielding = h / (_effective_inertia(wheel, own, h) + h * (kl * rl * rl + kx * rx * rx))
        qx = kl * rl * wheel.along_x + kx * rx * wheel.across_x
        qy = kl * rl * wheel.along_y + kx * rx * wheel.across_y
        qw = kl * rl * wheel.along_arm + kx * rx * wheel.across_arm
        pull = own.yielding * (own.torque - rl * own.along - rx * own.across)
        bx += h * (wheel.along_x * own.along + wheel.across_x * own.across + qx * pull)
        by += h * (wheel.along_y * own.along + wheel.across_y * own.across + qy * pull)
        bw += h * (wheel.along_arm * own.along + wheel.across_arm * own.across + qw * pull)
        g = h * own.yielding
        xx += h * (kl * wheel.along_x * wheel.along_x + kx * wheel.across_x * wheel.across_x) - g * qx * qx
        yy += h * (kl * wheel.along_y * wheel.along_y + kx * wheel.across_y * wheel.across_y) - g * qy * qy
        ww += h * (kl * wheel.along_arm * wheel.along_arm + kx * wheel.across_arm * wheel.across_arm) - g * qw * qw
        xy += h * (kl * wheel.along_x * wheel.along_y + kx * wheel.across_x * wheel.across_y) - g * qx * qy
        xw += h * (kl * wheel.along_x * wheel.along_arm + kx * wheel.across_x * wheel.across_arm) - g * qx * qw
        yw += h * (kl * wheel.along_y * wheel.along_arm + kx * wheel.across_y * wheel.across_arm) - g * qy * qw
    dx, dy, dw = _solve(xx, yy, ww, xy, xw, yw, bx, by, bw)
    _advance(body, state, wheels, states, dx, dy, dw)


@njit(cache=True, error_model="numpy", forceinline=True)
def _loads(body: Any, state: Any, states: Records, support: Floats) -> None:
    """Wheel loads (N) from weight and the moments `-M a h` of acceleration; a wheel cannot pull on the floor."""
    weight = body.mass * GRAVITY
    tip_x, tip_y = -body.mass * body.height * state.ax, -body.mass * body.height * state.ay
    total = 0.0
    for i in range(len(support)):
        load = max(support[i, 0] * weight + support[i, 1] * tip_x + support[i, 2] * tip_y, 0.0)
        total += load
        if i < len(states):
            states[i].load = load
    for i in range(len(states)):
        states[i].load *= weight / total


@njit(cache=True, error_model="numpy", forceinline=True)
def _motor(wheel: Any, own: Any, h: float) -> None:
    """Current at the end of the step, torque on the wheel, and how torque falls with wheel speed (N m s)."""
    ratio = wheel.gear.ratio
    speed = ratio * own.speed
    electric = 0.0
    before = own.current
    if own.motor == DEAD:
        own.current = 0.0
    else:
        own.current = armature_step(wheel.armature, before, own.voltage, speed)
        electric = (
            wheel.torque_constant * wheel.armature.back_emf * wheel.armature.conductance * (1.0 - wheel.armature.decay)
        )
    friction, slope = _friction(wheel.friction, speed)
    motor = wheel.torque_constant * own.current - friction
    own.torque = gear_torque(wheel.gear, motor, speed)
    efficiency = wheel.gear.efficiency if motor * speed >= 0.0 else 1.0 / wheel.gear.efficiency
    own.damping = ratio * ratio * efficiency * (electric + slope)


@njit(cache=True, error_model="numpy", forceinline=True)
def _friction(params: Any, speed: float) -> tuple[float, float]:
    """Return `devices.friction_torque` and its slope (N m s) at a motor speed."""
    coulomb = params.coulomb_positive if speed > 0.0 else params.coulomb_negative
    smooth = params.smoothing * params.smoothing
    inverse = 1.0 / math.sqrt(speed * speed + smooth)
    part = coulomb * inverse
    return params.viscous * speed + part * speed, params.viscous + part * smooth * inverse * inverse


@njit(cache=True, error_model="numpy", forceinline=True)
def _effective_inertia(wheel: Any, own: Any, h: float) -> float:
    return JAMMED if own.motor == BLOCKED else wheel.inertia + h * own.damping


@njit(cache=True, error_model="numpy", forceinline=True)
def _slip(wheel: Any, own: Any, state: Any) -> None:
    """Slip speeds, forces on the base and their slopes at the start of the step."""
    along = wheel.along_radius * own.speed - (
        wheel.along_x * state.vx + wheel.along_y * state.vy + wheel.along_arm * state.w
    )
    across = wheel.across_radius * own.speed - (
        wheel.across_x * state.vx + wheel.across_y * state.vy + wheel.across_arm * state.w
    )
    own.slip, own.across_slip = along, across
    if wheel.rollers:
        mu, slope = slip_friction(own.material, along)
        own.along, own.along_stiffness = own.load * mu, own.load * slope
        drag = own.load * min(wheel.roller_drag, own.material.peak)
        inverse = 1.0 / math.sqrt(across * across + ROLLER_SMOOTHING * ROLLER_SMOOTHING)
        own.across = drag * inverse * across
        own.across_stiffness = drag * inverse * (ROLLER_SMOOTHING * inverse) ** 2
    else:
        total = math.sqrt(along * along + across * across) + LEAST_SLIP
        mu, _ = slip_friction(own.material, total)
        secant = own.load * mu / total
        own.along, own.across = secant * along, secant * across
        own.along_stiffness = own.across_stiffness = secant


@njit(cache=True, error_model="numpy", forceinline=True)
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


@njit(cache=True, error_model="numpy", forceinline=True)
def _advance(body: Any, state: Any, wheels: Records, states: Records, dx: float, dy: float, dw: float) -> None:
    """Forces at the end of the step, within the friction limit; speeds, energies and pose from them."""
    h = body.dt
    fx = fy = fw = 0.0
    for i in range(len(wheels)):
        wheel, own = wheels[i], states[i]
        _settle_wheel(wheel, own, h, dx, dy, dw)
        fx += wheel.along_x * own.along + wheel.across_x * own.across
        fy += wheel.along_y * own.along + wheel.across_y * own.across
        fw += wheel.along_arm * own.along + wheel.across_arm * own.across
    dx, dy, dw = h * fx / body.mass, h * fy / body.mass, h * fw / body.inertia
    vx, vy, w = state.vx + 0.5 * dx, state.vy + 0.5 * dy, state.w + 0.5 * dw
    for i in range(len(wheels)):
        wheel, own = wheels[i], states[i]
        speed = own.speed + 0.5 * own.torque  # `torque` now holds the change of speed
        along = wheel.along_radius * speed - (wheel.along_x * vx + wheel.along_y * vy + wheel.along_arm * w)
        across = wheel.across_radius * speed - (wheel.across_x * vx + wheel.across_y * vy + wheel.across_arm * w)
        _book(wheel, own, state, h, speed, own.along * along + own.across * across)
        own.speed += own.torque
        own.angle += h * own.speed
    state.ax, state.ay = fx / body.mass, fy / body.mass
    _move(state, h, vx + 0.5 * dx, vy + 0.5 * dy, w + 0.5 * dw)


@njit(cache=True, error_model="numpy", forceinline=True)
def _settle_wheel(wheel: Any, own: Any, h: float, dx: float, dy: float, dw: float) -> None:
    """Final forces of a wheel, and the change of its speed (left in `torque`)."""
    rl, rx = wheel.along_radius, wheel.across_radius
    kl, kx = own.along_stiffness, own.across_stiffness
    body_along = wheel.along_x * dx + wheel.along_y * dy + wheel.along_arm * dw
    body_across = wheel.across_x * dx + wheel.across_y * dy + wheel.across_arm * dw
    push = own.torque - rl * own.along - rx * own.across + kl * rl * body_along + kx * rx * body_across
    turn = own.yielding * push
    own.along += kl * (rl * turn - body_along)
    own.across += kx * (rx * turn - body_across)
    limit = own.load * own.material.peak
    if own.along * own.along + own.across * own.across > limit * limit:
        _hold(wheel, own, limit)
        turn = h * (own.torque - rl * own.along - rx * own.across) / _effective_inertia(wheel, own, h)
    own.current -= _current_drop(wheel, own, turn)
    own.torque = turn


@njit(cache=True, error_model="numpy")
def _hold(wheel: Any, own: Any, limit: float) -> None:
    """Hold the force of a wheel to the friction limit (N); rollers get what the drive leaves."""
    if wheel.rollers:
        own.along = min(max(own.along, -limit), limit)
        room = math.sqrt(limit * limit - own.along * own.along)
        own.across = min(max(own.across, -room), room)
    else:
        part = limit / math.sqrt(own.along * own.along + own.across * own.across)
        own.along *= part
        own.across *= part


@njit(cache=True, error_model="numpy", forceinline=True)
def _current_drop(wheel: Any, own: Any, turn: float) -> float:
    """Current (A) that back-emf takes as the wheel turns faster by `turn` (rad/s) in this step."""
    if own.motor == DEAD:
        return 0.0
    armature = wheel.armature
    return armature.conductance * (1.0 - armature.decay) * armature.back_emf * wheel.gear.ratio * turn


@njit(cache=True, error_model="numpy", forceinline=True)
def _book(wheel: Any, own: Any, state: Any, h: float, speed: float, ground: float) -> None:
    """Add a step to the energies: supply, armature heat, air gap, friction of motor and gear, floor."""
    airgap = wheel.torque_constant * own.current * wheel.gear.ratio * speed
    kinetic = wheel.inertia * own.torque * speed
    to_floor = (own.along * wheel.along_radius + own.across * wheel.across_radius) * speed
    state.airgap += h * airgap
    state.drag += h * (airgap - to_floor) - kinetic
    state.ground += h * ground
    if own.motor != DEAD:
        supply = min(max(own.voltage, -wheel.armature.max_voltage), wheel.armature.max_voltage)
        state.supplied += h * supply * own.current
        state.heat += h * own.current * own.current / wheel.armature.conductance


@njit(cache=True, error_model="numpy", forceinline=True)
def _move(state: Any, h: float, vx: float, vy: float, w: float) -> None:
    """Pose from the new velocity (still in the old axes), which keeps its direction while base_link turns."""
    c, s = math.cos(state.theta), math.sin(state.theta)
    state.x += h * (c * vx - s * vy)
    state.y += h * (s * vx + c * vy)
    state.theta += h * w
    half = 0.5 * h * w
    t = half * (1.0 + half * half / 3.0)  # tangent
    n = 1.0 / (1.0 + t * t)
    a, b = n * (1.0 - t * t), 2.0 * n * t
    state.vx, state.vy, state.w = a * vx + b * vy, a * vy - b * vx, w
