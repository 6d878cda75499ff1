"""A base with dead motors: forces without them, what is still reachable, what blocked wheels allow (spec 06.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike
from scipy import optimize

from holonom.arrays import Array, is_finite, real_array, shown, vectors
from holonom.errors import OutOfLimits, ShapeError, UnknownName
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.coupling import Coupling, Wheels, coupling_of, live_wheels

__all__ = [
    "Actuation",
    "Reach",
    "Redistribution",
    "actuation",
    "allocation",
    "feasible_twist",
    "motors_hold_all",
    "possible_twists",
    "redistribute",
]

Base = WheelBase | Coupling | ArrayLike
_RANK = 1e-9
_MET = 1e-6  # of the acceleration asked for: what may be missed where it counts as met
_FIRST = 1e4  # weight of what is kept over what is given up
_WEIGHTS = {"rotation": (_FIRST, _FIRST, 1.0), "translation": (1.0, 1.0, _FIRST), "together": (1.0, 1.0, 1.0)}


class Reach(IntEnum):
    """Whether a demand is met: fully; not, for want of force; not, because the wheels left cannot push there."""

    MET = 0
    LIMITED = 1
    UNREACHABLE = 2


@dataclass(frozen=True, slots=True)
class Redistribution:
    """Wheel forces without the dead motors.

    Attributes
    ----------
    status
        Met, or what stands against it.
    forces
        (n,) N; 0 for dead motors.
    acceleration
        (3,) ax, ay (m/s2), wd (rad/s2) that they give.
    missed
        (3,) demanded less given, component by component.
    """

    status: Reach
    forces: Array
    acceleration: Array
    missed: Array


@dataclass(frozen=True, slots=True)
class Actuation:
    """What the motors left can still do.

    Attributes
    ----------
    rank
        3: fully actuated, every acceleration can be had (within the limits).
    reachable
        (3, rank) orthonormal directions of (ax, ay, R wd) that can be had.
    lost
        (3, 3 - rank) and those that cannot.
    """

    rank: int
    reachable: Array
    lost: Array


def redistribute(
    base: Base, acceleration: ArrayLike, mass: float, *, out: Wheels = (), limits: ArrayLike = math.inf,
    least: Literal["norm", "peak"] = "norm", give_up: Literal["rotation", "translation", "together"] = "rotation",
) -> Redistribution:  # fmt: skip
    """Forces of the wheels left for an acceleration of the base, or for what comes nearest to it.

    Parameters
    ----------
    base
        A base, its coupling, or D (n, 3).
    acceleration
        (3,) ax, ay (m/s2), wd (rad/s2) in base_link.
    mass
        kg.
    out
        Driven wheels whose motors are dead and that roll freely, by name or number.
    limits
        Greatest |force| of a wheel, N: scalar or (n,).
    least
        Which of the forces that do it: least square sum (least heat), or least largest share of its limit.
    give_up
        What is missed first where not all can be had: the turning, the translation, or all three by their square sum
        in (ax, ay, R wd). What is kept is met as nearly as possible before the other is looked at.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName

    Notes
    -----
    Bounded least squares (`scipy.optimize.lsq_linear`), then least forces: least distance programming (Lawson & Hanson,
    ch. 23) or a linear program.
    """
    coupling = coupling_of(base)
    a, high = _demand(acceleration, coupling), _force_limits(limits, coupling.wheels)
    if give_up not in _WEIGHTS:
        raise UnknownName("component to give up", give_up, _WEIGHTS)
    if least not in ("norm", "peak"):
        raise UnknownName("measure of forces", least, ("norm", "peak"))
    if not (is_finite(mass) and mass > 0.0):
        raise OutOfLimits(f"mass is {shown(mass)} kg; it must be a finite number above 0")
    live = live_wheels(coupling, out)
    C = coupling.force[:, live] / mass
    nearest = _nearest(C, a, high[live], give_up)
    forces = np.zeros(coupling.wheels)
    forces[live] = _least_norm(C, nearest, high[live]) if least == "norm" else _least_peak(C, nearest, high[live])
    given = C @ forces[live]
    return Redistribution(_status(C, a, given), forces, given / _scale(coupling), (a - given) / _scale(coupling))


def allocation(base: Base, *, out: Wheels = ()) -> Array:
    """Matrix (n, 3) from (Fx, Fy, torque / R), N, to the least wheel forces without dead motors: their row is 0.

    For control loops; `D^T` times it is 1 while the base is fully actuated, else the projection on what is reachable.
    Force that wheels take up which must not slide sideways is asked of no motor.

    Raises
    ------
    OutOfLimits, UnknownName
    """
    coupling = coupling_of(base)
    live = live_wheels(coupling, out)
    A = np.zeros((coupling.wheels, 3))
    S = coupling.motions
    A[live] = np.linalg.pinv((coupling.velocity[live] @ S).T, rcond=_RANK) @ S.T
    return A


def actuation(base: Base, *, out: Wheels = ()) -> Actuation:
    """Rank and directions of acceleration that motors still give when those of `out` are dead and roll freely.

    How strong each direction of the plane is: `force_envelope(..., out=out)`.

    Raises
    ------
    OutOfLimits, UnknownName
    """
    coupling = coupling_of(base)
    live = live_wheels(coupling, out)
    if not live.any():
        return Actuation(0, np.empty((3, 0)), np.eye(3))
    C = coupling.force[:, live]
    reachable = scipy.linalg.orth(C, rcond=_RANK)
    return Actuation(reachable.shape[1], reachable, scipy.linalg.null_space(C.T, rcond=_RANK))


def motors_hold_all(base: Base, dead: int) -> bool:
    """Whether a base without some motors can still accelerate every way that its wheels let it move.

    Parameters
    ----------
    dead
        Set of driven wheels, bit i for wheel i.
    """
    coupling = coupling_of(base)
    out = [k for k in range(coupling.wheels) if (dead >> k) & 1]
    return actuation(coupling, out=out).rank == coupling.motions.shape[1]


def possible_twists(base: Base, *, blocked: Wheels = ()) -> Array:
    """Twists (3, k) (vx, vy in m/s, w in rad/s) that blocked wheels allow, orthonormal in (vx, vy, R w), by column.

    A blocked wheel's rim stands still while its rollers roll: `D_i v = 0`, one direction less for each independent
    one, and so does each that must not slide: `C v = 0`. A motor that is dead while its wheel rolls takes none away.

    Raises
    ------
    OutOfLimits, UnknownName
    """
    coupling = coupling_of(base)
    held = np.vstack([coupling.velocity[~live_wheels(coupling, blocked)], coupling.sliding])
    free = scipy.linalg.null_space(held, rcond=_RANK) if len(held) else np.eye(3)
    twists: Array = free / _scale(coupling)[:, None]
    return twists


def feasible_twist(base: Base, twist: ArrayLike, *, blocked: Wheels = ()) -> Array:
    """Twist (..., 3) nearest to a demanded one, by (vx, vy, R w), among those that blocked wheels allow.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName
    """
    scale = _scale(coupling_of(base))
    wanted = vectors("twist", twist, 3)
    free = possible_twists(base, blocked=blocked) * scale[:, None]
    nearest: Array = wanted * scale @ free @ free.T / scale
    return nearest


def _nearest(C: Array, a: Array, high: Array, give_up: str) -> Array:
    """Force (n,) within limits whose acceleration comes nearest to a (3,), what is kept first."""
    if not C.shape[1]:
        return np.zeros(0)
    weight = np.array(_WEIGHTS[give_up])
    free: Array = np.linalg.pinv(weight[:, None] * C, rcond=_RANK / _FIRST) @ (weight * a)
    if (np.abs(free) <= high).all():
        return free
    unit = np.where(np.isfinite(high), high, max(1.0, float(np.abs(free).max())))
    bound = np.where(np.isfinite(high), 1.0, np.inf)
    movable = high > 0.0
    forces = np.zeros(len(high))
    if movable.any():
        found = optimize.lsq_linear(
            (weight[:, None] * C * unit)[:, movable], weight * a, (-bound[movable], bound[movable]), method="bvls"
        )
        forces[movable] = found.x * unit[movable]
    return forces


def _least_norm(C: Array, forces: Array, high: Array) -> Array:
    """Forces of least square sum within limits that give the same acceleration."""
    N = scipy.linalg.null_space(C, rcond=_RANK) if C.shape[1] else np.zeros((0, 0))
    if not N.shape[1]:
        return forces
    least: Array = forces - N @ (N.T @ forces)
    if (np.abs(least) <= high).all():
        return least
    bounded = np.isfinite(high)
    G = np.vstack([N[bounded], -N[bounded]])
    h = np.concatenate([-high[bounded] - least[bounded], least[bounded] - high[bounded]])
    scale = float(np.abs(h).max())
    E = np.vstack([G.T, h / scale])
    target = np.zeros(len(E))
    target[-1] = 1.0
    dual, _ = optimize.nnls(E, target)
    r = E @ dual - target
    if abs(r[-1]) < 1e-12:  # at the edge of what the limits allow: nothing is left to choose
        return forces
    return np.clip(least - N @ (r[:-1] / r[-1]) * scale, -high, high)


def _least_peak(C: Array, forces: Array, high: Array) -> Array:
    """Forces that give the same acceleration with the least largest share of the limits (of 1 N where unlimited)."""
    n = C.shape[1]
    share = np.where(np.isfinite(high), high, 1.0)
    size = float(np.abs(forces).max(initial=0.0))
    if size == 0.0:
        return forces
    ends = np.column_stack([np.vstack([np.eye(n), -np.eye(n)]), -np.concatenate([share, share])])
    found = optimize.linprog(
        np.append(np.zeros(n), 1.0), A_ub=ends, b_ub=np.zeros(2 * n), A_eq=np.column_stack([C, np.zeros(3)]),
        b_eq=C @ forces / size, bounds=[(None, None)] * n + [(0.0, None)],
    )  # fmt: skip
    return np.clip(found.x[:-1] * size, -high, high) if found.status == 0 else forces


def _status(C: Array, a: Array, given: Array) -> Reach:
    allowed = _MET * max(float(np.abs(a).max()), 1e-12)
    if np.abs(a - given).max() <= allowed:
        return Reach.MET
    unlimited = C @ (np.linalg.pinv(C, rcond=_RANK) @ a) if C.shape[1] else np.zeros(3)
    return Reach.LIMITED if np.abs(a - unlimited).max() <= allowed else Reach.UNREACHABLE


def _scale(coupling: Coupling) -> Array:
    return np.array([1.0, 1.0, coupling.radius])


def _demand(acceleration: ArrayLike, coupling: Coupling) -> Array:
    a = vectors("acceleration", acceleration, 3)
    if a.ndim != 1:
        raise ShapeError(f"acceleration has shape {a.shape}; (3,) is needed: ax, ay, wd")
    return a * _scale(coupling)


def _force_limits(limits: ArrayLike, n: int) -> Array:
    high = real_array("force limits", limits)
    if high.shape not in ((), (n,)) or not (high >= 0.0).all():
        raise ShapeError(f"force limits are {high}; they must be a number or ({n},) of them in N, none below 0")
    return np.broadcast_to(high, (n,))
