"""Coupling between n driven wheels and the base: speeds by D, forces by C_alpha (specification 06.2; Rojas & Foerster).

In equations a twist is v = (vx, vy, R w), an acceleration a = (ax, ay, R wd) of base_link, m the rim speeds and f the
forces at the rims (torque over wheel radius): `m = D v`, `a = C_alpha f / M`, `I = alpha M R^2` about the centre of
mass. With that at the origin and no sliding constraint `C_alpha = diag(1, 1, 1/alpha) D^T`, else `base.dynamics` says
what.
Verbs take and give (vx, vy, w) in m/s and rad/s.
"""

from __future__ import annotations

import operator
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite, is_finite, shown, vectors
from holonom.errors import ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile.base.dynamics import drift, free_motions, inertia_over_mass, reaction
from holonom.mobile.base.wheel_base import WheelBase

__all__ = [
    "Coupling",
    "Wheels",
    "base_acceleration",
    "base_force",
    "base_twist",
    "coupling_at_rest",
    "coupling_of",
    "live_wheels",
    "omni_coupling",
    "rim_speeds",
    "wheel_forces",
]

Wheels = int | str | Iterable[int | str]
"""Driven wheels, each by its name or by its number from 0 on."""


@dataclass(frozen=True, slots=True)
class Coupling:
    """Coupling of n wheels, all that this chapter needs of a base.

    Attributes
    ----------
    velocity
        D (n, 3): rim speeds in m/s per (vx, vy, R w).
    radius
        R in m, the length that makes turning a speed.
    alpha
        Mass distribution, `I = alpha M R^2`: 1/2 for a disc, 1 for a ring.
    names
        Of the n wheels; "wheel 1" and so on unless given.
    com
        Centre of mass (2,) in base_link, m.
    sliding
        C (k, 3): sideways speeds, m/s, per (vx, vy, R w), of wheels that must not slide.

    Raises
    ------
    ShapeError, OutOfLimits, ModelError
    """

    velocity: Array
    radius: float = 1.0
    alpha: float = 1.0
    names: tuple[str, ...] = ()
    com: tuple[float, float] = (0.0, 0.0)
    sliding: Array = field(default_factory=lambda: np.empty((0, 3)))

    def __post_init__(self) -> None:
        D, C = np.array(finite("coupling D", self.velocity)), np.array(finite("coupling C", self.sliding))
        if C.ndim != 2 or C.shape[1] != 3:
            raise ShapeError(f"coupling C has shape {C.shape}; it must be (k, 3): a row per wheel that must not slide")
        x, y = vectors("coupling com", self.com, 2).tolist()
        C.setflags(write=False)
        object.__setattr__(self, "sliding", C)
        object.__setattr__(self, "com", (x, y))
        if D.ndim != 2 or D.shape[1] != 3:
            raise ShapeError(
                f"coupling D has shape {D.shape}; it must be (n, 3), finite: a row per wheel, (vx, vy, R w)"
            )
        if not len(D):
            raise ModelError("coupling D has no row; a drive needs at least one driven wheel")
        for name, value in (("radius", self.radius), ("alpha", self.alpha)):
            if not (is_finite(value) and value > 0.0):
                raise OutOfLimits(f"coupling: {name} is {shown(value)}; it must be a finite number above 0")
        names = tuple(self.names) or tuple(f"wheel {k + 1}" for k in range(len(D)))
        if len(set(names)) != len(D):
            raise ModelError(f"coupling D has {len(D)} rows and the names {list(names)}; state one of its own for each")
        object.__setattr__(self, "names", names)
        D.setflags(write=False)
        object.__setattr__(self, "velocity", D)

    @property
    def motions(self) -> Array:
        """S (3, k): orthonormal motions (vx, vy, R w) that the sliding rows leave free."""
        return free_motions(self.sliding)

    @property
    def reaction(self) -> Array:
        """(3, 3): (ax, ay, R wd) times the mass, per force (Fx, Fy, torque / R) on base_link."""
        return reaction(self.motions, inertia_over_mass(self.radius, self.alpha, np.array(self.com)))

    @property
    def force(self) -> Array:
        """C_alpha (3, n): (ax, ay, R wd) times the mass, per wheel force, at rest."""
        C: Array = self.reaction @ self.velocity.T
        return C

    def drift(self, twist: ArrayLike) -> Array:
        """Acceleration (..., 3) (ax, ay, R wd) that needs no force at a twist (vx, vy, w): see `base.dynamics`."""
        inertia = inertia_over_mass(self.radius, self.alpha, np.array(self.com))
        return drift(self.motions, inertia, np.array(self.com), _last("twist", twist, 3))

    @property
    def wheels(self) -> int:
        """Number n of driven wheels."""
        return len(self.velocity)


def omni_coupling(
    angles: ArrayLike, *, radius: float = 1.0, alpha: float = 1.0, levers: ArrayLike | None = None
) -> Coupling:
    """Couple omni wheels at any angles: rows `(-sin phi, cos phi, lever / R)` (specification 06.2).

    Parameters
    ----------
    angles
        phi (n,), rad: direction of each motor axis in base_link, counter-clockwise from x; the wheel drives along
        (-sin phi, cos phi).
    radius
        R in m.
    alpha
        Mass distribution, `I = alpha M R^2`.
    levers
        (n,) distance in m at which each wheel's line of drive passes the centre of mass; R each unless given.

    Raises
    ------
    ShapeError, OutOfLimits, ModelError
    """
    if not (is_finite(radius) and radius > 0.0):
        raise OutOfLimits(f"coupling: radius is {shown(radius)}; it must be a finite number above 0")
    phi = np.atleast_1d(finite("angles", angles))
    arm = np.full(phi.shape, radius) if levers is None else finite("levers", levers)
    if phi.ndim != 1 or arm.shape != phi.shape:
        raise ShapeError(f"angles have shape {phi.shape}, levers {arm.shape}; both must be (n,)")
    return Coupling(np.column_stack([-np.sin(phi), np.cos(phi), arm / radius]), radius, alpha)


def coupling_of(base: WheelBase | Coupling | ArrayLike) -> Coupling:
    """Coupling of the driven wheels of a base; an array is D (n, 3) of a base with R = 1 m and alpha = 1.

    Raises
    ------
    ShapeError, ModelError
    InputError
        A base that steers.
    """
    if isinstance(base, Coupling):
        return base
    if isinstance(base, WheelBase):
        if base.steered:
            return Coupling(base.velocity_coupling)  # which refuses it
        return coupling_at_rest(base)
    return Coupling(finite("coupling D", base))


def coupling_at_rest(base: WheelBase) -> Coupling:
    """Coupling of the driven wheels of a base whose steered wheels, if any, are at rest."""
    x, y = base.com.tolist()
    sliding = base.sliding_matrix() * [1.0, 1.0, 1.0 / base.radius]
    return Coupling(base.rest_coupling, base.radius, base.alpha, base.driven, (x, y), sliding)


def rim_speeds(base: WheelBase | Coupling | ArrayLike, twist: ArrayLike) -> Array:
    """Rim speeds (..., n), m/s, of a twist (..., 3) (vx, vy, w): `m = D v`.

    Raises
    ------
    ShapeError
    """
    c = coupling_of(base)
    m: Array = _last("twist", twist, 3) * [1.0, 1.0, c.radius] @ c.velocity.T
    return m


def base_twist(base: WheelBase | Coupling | ArrayLike, rims: ArrayLike) -> Array:
    """Twist (..., 3) (vx, vy, w) that explains rim speeds (..., n), m/s, best: `v = S (D S)^+ m`.

    Least squares among the motions S that drag no wheel; `D^+ m` where all do.

    Raises
    ------
    ShapeError
    """
    c = coupling_of(base)
    inverse = c.motions @ np.linalg.pinv(c.velocity @ c.motions)
    v: Array = _last("rims", rims, c.wheels) @ inverse.T / [1.0, 1.0, c.radius]
    return v


def base_force(base: WheelBase | Coupling | ArrayLike, forces: ArrayLike) -> Array:
    """Force and torque (..., 3) (Fx, Fy in N, torque in N m) of wheel forces (..., n), N: `D^T f`, torque times R.

    Power balance: `f . m = Fx vx + Fy vy + torque w` for every twist.

    Raises
    ------
    ShapeError
    """
    c = coupling_of(base)
    F: Array = _last("forces", forces, c.wheels) @ c.velocity * [1.0, 1.0, c.radius]
    return F


def base_acceleration(
    base: WheelBase | Coupling | ArrayLike, forces: ArrayLike, mass: float, *, twist: ArrayLike = (0.0, 0.0, 0.0)
) -> Array:
    """Acceleration (..., 3) (ax, ay in m/s2, wd in rad/s2) of wheel forces (..., n), N: `a = C_alpha f / M`.

    That of base_link, along its axes; at a `twist` (..., 3) also what turning does (`Coupling.drift`).

    Raises
    ------
    ShapeError, OutOfLimits
    """
    c = coupling_of(base)
    a: Array = _last("forces", forces, c.wheels) @ c.force.T / _mass(mass) + c.drift(twist)
    return a / [1.0, 1.0, c.radius]


def wheel_forces(
    base: WheelBase | Coupling | ArrayLike, acceleration: ArrayLike, mass: float, *,
    twist: ArrayLike = (0.0, 0.0, 0.0),
) -> Array:  # fmt: skip
    """Smallest wheel forces (..., n), N, for an acceleration (..., 3) (ax, ay, wd): `f = M C_alpha^+ a`.

    That of base_link, along its axes, at a `twist` (..., 3).

    Fewer than three independent wheels come as near as they can; `failed_motor.redistribute` says what is missed.

    Raises
    ------
    ShapeError, OutOfLimits
    """
    c = coupling_of(base)
    a = _last("acceleration", acceleration, 3) * [1.0, 1.0, c.radius]
    f: Array = _mass(mass) * (a - c.drift(twist)) @ np.linalg.pinv(c.force, rcond=1e-10).T
    return f


def live_wheels(coupling: Coupling, out: Wheels) -> NDArray[np.bool_]:
    """(n,) which wheels are left when those of `out` are not.

    Raises
    ------
    UnknownName
        No wheel has that name.
    OutOfLimits
        No wheel has that number.
    """
    live = np.ones(coupling.wheels, bool)
    for wheel in [out] if isinstance(out, str) or not isinstance(out, Iterable) else out:
        live[_number(coupling, wheel)] = False
    return live


def _number(coupling: Coupling, wheel: int | str) -> int:
    if isinstance(wheel, str):
        if wheel not in coupling.names:
            raise UnknownName("driven wheel", wheel, coupling.names)
        return coupling.names.index(wheel)
    last = coupling.wheels - 1
    try:
        number = -1 if isinstance(wheel, bool) else operator.index(wheel)
    except TypeError:
        number = -1
    if not 0 <= number <= last:
        raise OutOfLimits(
            f"wheel {wheel!r} is out, but there are wheels 0 to {last}: {', '.join(coupling.names)}; "
            "state one by its number or its name"
        )
    return number


def _last(name: str, values: ArrayLike, size: int) -> Array:
    array = finite(name, values)
    if array.shape[-1:] != (size,):
        raise ShapeError(f"{name} has shape {array.shape}; its last axis must be {size}")
    return array


def _mass(mass: float) -> float:
    if not (is_finite(mass) and mass > 0.0):
        raise OutOfLimits(f"mass is {shown(mass)} kg; it must be a finite number above 0")
    return mass
