"""Forces between a wheel and the floor, compiled: slip curve, rollers, tyres, and the limit of friction."""

from __future__ import annotations

import math
from typing import Any

from holonom.trace.code.compiled import arctan, select, sincos_half_turn
from holonom.trace.code.loops import loop

__all__ = ["chosen", "held", "roller_forces", "slip_friction", "tyre_forces"]

FLAGS = {"contract"}
ROLLER_SMOOTHING = 0.01  # m/s, below which roller drag goes over into its opposite
LEAST_SLIP = 1e-9  # m/s, keeps the direction of slip defined


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def slip_friction(material: Any, slip: Any) -> tuple[Any, Any]:
    """Friction coefficient and its slope (s/m) at a slip speed (m/s): `D sin(C atan(B s))`; 0 where it falls."""
    x = material.stiffness * abs(slip)
    sine, cosine = sincos_half_turn(material.shape * arctan(x))
    steepest = material.peak * material.shape * material.stiffness
    return math.copysign(material.peak * sine, slip), steepest / (1.0 + x * x) * max(cosine, 0.0)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def roller_forces(wheel: Any, own: Any, along: Any, across: Any) -> tuple[Any, Any, Any, Any]:
    """Friction along, bearing drag across; forces and slopes."""
    mu, slope = slip_friction(own.material, along)
    drag = own.load * min(wheel.roller_drag, own.material.peak)
    inverse = 1.0 / math.sqrt(across * across + ROLLER_SMOOTHING * ROLLER_SMOOTHING)
    part = ROLLER_SMOOTHING * inverse
    return own.load * mu, drag * inverse * across, own.load * slope, drag * inverse * part * part


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def tyre_forces(own: Any, along: Any, across: Any) -> tuple[Any, Any, Any, Any]:
    """Friction in the direction of slip; forces, and their secants instead of slopes."""
    slip = math.sqrt(along * along + across * across) + LEAST_SLIP
    mu, _ = slip_friction(own.material, slip)
    secant = own.load * mu / slip
    return secant * along, secant * across, secant, secant


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def chosen(which: Any, a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, Any, Any, Any]:
    """Of two wheels' forces and slopes, lane by lane, those of a where `which`, else those of b."""
    return select(which, a[0], b[0]), select(which, a[1], b[1]), select(which, a[2], b[2]), select(which, a[3], b[3])


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def held(wheel: Any, along: Any, across: Any, limit: Any) -> tuple[Any, Any]:
    """Forces held to the friction limit (N); rollers get what the drive leaves."""
    rolls = wheel.rollers > 0.0
    part = limit / math.sqrt(along * along + across * across)
    drive = min(max(along, -limit), limit)
    room = math.sqrt((limit - drive) * (limit + drive))  # never below 0, contracted or not
    return select(rolls, drive, part * along), select(rolls, min(max(across, -room), room), part * across)
