"""The body of an inverted pendulum in the plant, compiled: what its pitch adds to masses, forces and loads.

With phi the pitch about the axle (forwards positive), s(phi) and u(phi) how far the centre of mass is ahead of the axle
and above it, accelerations (ax, ay) of the axle's middle along base_link and the yaw inertia I(phi):

    M (ax + u phidd)                 = Fx + M (s phid^2 + s w^2)
    M (ay + s wd)                    = Fy - 2 M u w phid
    (I + M s^2) wd + M s ay          = N - 2 M s u w phid - I' w phid
    (J + M (s^2 + u^2)) phidd + M u ax = Q + M g s + M s u w^2 + I' w^2 / 2

by Lagrange in the turning axes (Pathak, Franch & Agrawal, IEEE Trans. Robotics 21(3), 2005; Kim & Kwon, Int. J.
Control, Automation and Systems 13, 2015). Wheels turn against the body: a motor's torque is none on the pitch, the
force F of a rim is `-r F`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = ["LeanParams", "LeanTerms", "leaning_terms", "leaning_weight"]

FLAGS = {"contract"}
LEAST = 1e-6  # part of the weight that is left of it where the body would pull its wheels off the floor


class LeanParams(NamedTuple):
    """A body on its axle: kg; centre of mass upright, m; inertia about it along body axes, kg m2."""

    mass: float
    ahead: float  # of the axle
    rise: float  # above it
    axle: float  # height of the axle
    roll: float  # Jxx
    pitch: float  # Jyy, with wheels and rotors that turn with the body
    yaw: float  # Jzz
    product: float  # Jxz
    gravity: float  # m/s2, into the floor
    limit: float  # rad of pitch beyond which it has fallen


class LeanTerms(NamedTuple):
    """At a pitch: where the centre of mass is (m), inertias (kg m2), forces and torques of gravity and of motion."""

    ahead: float
    up: float
    turning: float
    pitching: float
    x: float
    y: float
    turn: float
    pitch: float


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def leaning_terms(lean: LeanParams, state: Any) -> LeanTerms:
    """What the pitch adds at a state of the body; gravity along a slope pulls at the centre of mass."""
    sine, cosine = sincos(state.pitch)
    s = lean.rise * sine + lean.ahead * cosine
    u = lean.rise * cosine - lean.ahead * sine
    inertia = lean.roll * sine * sine + lean.yaw * cosine * cosine - 2.0 * lean.product * sine * cosine
    change = 2.0 * ((lean.roll - lean.yaw) * sine * cosine - lean.product * (cosine * cosine - sine * sine))
    M, w, rate = lean.mass, state.w, state.pitch_rate
    return LeanTerms(
        s,
        u,
        inertia + M * s * s,
        lean.pitch + M * (s * s + u * u),
        M * s * (rate * rate + w * w),
        -2.0 * M * u * w * rate,
        M * s * state.down_y - (2.0 * M * s * u + change) * w * rate,
        M * (lean.gravity * s + u * state.down_x + s * u * w * w) + 0.5 * change * w * w,
    )


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def leaning_weight(lean: LeanParams, body: Any, state: Any) -> tuple[float, float, float]:
    """Weight (N) on the wheels with what the body's rise and fall adds, and its moments of acceleration (N m).

    By the accelerations of the step before; gyroscopic moments about the way ahead are left out.
    """
    sine, cosine = sincos(state.pitch)
    s = lean.rise * sine + lean.ahead * cosine
    u = lean.rise * cosine - lean.ahead * sine
    rising = -s * state.pitch_acceleration - u * state.pitch_rate * state.pitch_rate
    weight = lean.mass * max(lean.gravity + rising, LEAST * lean.gravity)
    across = state.ay + s * state.aw + 2.0 * u * state.w * state.pitch_rate - state.down_y
    return weight, 0.0, -lean.mass * (lean.axle + u) * across
