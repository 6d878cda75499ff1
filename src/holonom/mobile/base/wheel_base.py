"""`WheelBase`: wheels under one body, with their stacked constraints and their inverse and forward model."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, is_number, shown, vectors
from holonom.errors import ModelError, OutOfLimits, ShapeError
from holonom.mobile.base import equations as base_equations
from holonom.mobile.base.castors import CastorRates, castor_rates
from holonom.mobile.base.drivable import Wedges, check_steerable, tightest_curve, wedges_of
from holonom.mobile.base.dynamics import distinct_rows, free_motions, inertia_over_mass, reaction
from holonom.mobile.base.mobility import check_movable, seen_twists
from holonom.mobile.base.refusals import beyond_steering, dragged_wheel, no_constant, undetermined
from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.base.wheel_set import body_inertia, known_suspension, named_wheels, not_below_zero, positive
from holonom.mobile.base.wheel_set import steering_groups as grouped
from holonom.mobile.equations.base_models import Layout
from holonom.mobile.equations.forward import DETERMINED
from holonom.mobile.evaluation import BaseEquation, product
from holonom.trace import Kernel, check_threads

__all__ = ["WheelBase"]

DRAG = 1e-6
"""Sideways speed of a wheel, m/s, below which a twist counts as one that drags nothing."""


class WheelBase:
    """Any set of wheels; twists are (vx, vy, w) in base_link (x forwards, y left), m/s and rad/s.

    Every verb broadcasts over leading axes and takes lists. Bases without steered wheels work with constant matrices;
    others evaluate equations that are compiled when a call brings some hundred samples (`kernel` hands them out).

    Parameters
    ----------
    wheels
        In the order of all rows. Nameless wheels are numbered.
    name
        What errors and figures call the base.
    radius
        R, m: scales turning, as R w beside vx and vy. None: root mean square distance of the wheels from the origin.
    alpha
        Mass distribution, yaw inertia about the centre of mass = alpha mass R^2: 1/2 a disc, 1 a ring.
    mass
        kg; None where it does not matter.
    com, com_height
        Centre of mass (x, y) in base_link and its height above the floor, m.
    inertia
        Instead of alpha, about the centre of mass, along the axes of base_link, kg m^2: (3, 3), (3,) its diagonal, or
        one number for every axis.
    suspension
        How weight comes to the wheels: "rigid" (least sum of squares of loads), or "rocker_bogie" (three wheels a
        side).
    balances
        Whether its body is an inverted pendulum on its axle.
    steering_groups
        Name -> names of steered wheels that one motor turns together, by the same angle. Wheels in none steer alone.
    notes
        What is to be said of where these numbers come from.

    Attributes
    ----------
    driven, steered, rolling_names, sliding_names : names of the m driven speeds, of the k steering angles, and of the
        rows of `rolling_matrix` and `sliding_matrix`.

    Raises
    ------
    ModelError
        No wheels, none driven, a name twice, a number that is none, groups that are not disjoint sets of steered
        wheels, or wheels that cannot roll together, at all or within their `max_steering` (names them).
    UnknownName
        A group names a wheel that there is not.
    """

    def __init__(
        self,
        wheels: Iterable[Wheel],
        *,
        name: str = "base",
        radius: float | None = None,
        alpha: float = 0.5,
        mass: float | None = None,
        com: Sequence[float] = (0.0, 0.0),
        com_height: float = 0.0,
        inertia: ArrayLike | None = None,
        suspension: str = "rigid",
        balances: bool = False,
        steering_groups: Mapping[str, Sequence[str]] | None = None,
        notes: Sequence[str] = (),
    ) -> None:
        self.name, self.wheels = name, named_wheels(name, wheels)
        spread = math.sqrt(sum(w.l**2 for w in self.wheels) / len(self.wheels)) or max(w.radius for w in self.wheels)
        self.radius = positive(name, "radius", spread if radius is None else radius)
        self.alpha = positive(name, "alpha", alpha)
        self.mass = None if mass is None else positive(name, "mass", mass)
        self.com = vectors("com", com, 2)
        self.com_height = not_below_zero(name, "com_height", com_height)
        self.inertia = body_inertia(name, inertia, alpha, self.mass, self.radius)
        if inertia is not None:
            self.alpha = float(self.inertia[2, 2]) / (self.mass or 1.0) / self.radius**2
        self.suspension, self.balances = known_suspension(suspension), bool(balances)
        groups = grouped(name, self.wheels, steering_groups or {})
        self.steered = tuple(groups)
        self.layout = Layout(self.wheels, tuple(groups.values()), self.radius)
        self.driven = tuple(w.name + s for w in self.wheels if w.driven for s in KINDS[w.kind].speeds(w))
        if not self.driven:
            raise ModelError(f"base {name!r} has no driven wheel; mark those with motors driven=True")
        check_movable(self.layout)
        self.rolling_names = tuple(w.name + s for w in self.wheels for s in KINDS[w.kind].speeds(w))
        self.sliding_names = tuple(w.name for w in self.wheels if KINDS[w.kind].sliding(w, 0.0, 1.0))
        self._driven_rows = np.array([n in self.driven for n in self.rolling_names])
        radii = [w.radius for w in self.wheels for _ in KINDS[w.kind].speeds(w)]
        self.wheel_radii: Array = np.array(radii)[self._driven_rows]
        self.notes = tuple(notes)
        self._equations: dict[str, BaseEquation] = {}
        if self.steered and min(self._max_steering) < 0.5 * math.pi:
            check_steerable(name, self._wedges)

    def __repr__(self) -> str:
        return f"WheelBase({self.name!r}, {len(self.wheels)} wheels, {len(self.driven)} driven)"

    def equation(self, name: str) -> BaseEquation:
        """Return a model as an equation over samples: "wheel_speeds", "free_wheel_speeds", "steering", ....

        See `base_equations.EQUATIONS`.
        """
        if name not in self._equations:
            self._equations[name] = base_equations.make(name, self.layout, len(self.driven))
        return self._equations[name]

    def kernel(self, name: str) -> Kernel:
        """Return the compiled form of `equation(name)`, for the fastest repeated calls and for compiled loops."""
        return self.equation(name).kernel

    def rolling_matrix(self, steering: ArrayLike | None = None) -> Array:
        """Rows (..., rows, 3) that times the twist give the rim speed r phid, m/s, of every wheel with a rolling row.

        `steering` (..., k) rad; None: at rest. Castors and passive spheres have none: `castor_rates`.
        """
        return self._matrix("rolling_rows", steering, len(self.rolling_names))

    def sliding_matrix(self, steering: ArrayLike | None = None) -> Array:
        """Rows (..., rows, 3) that times the twist give the sideways speed, m/s, of the wheels in `sliding_names`."""
        return self._matrix("sliding_rows", steering, len(self.sliding_names))

    def _matrix(self, name: str, steering: ArrayLike | None, rows: int) -> Array:
        angles = self._angles(steering)
        if rows == 0:
            return np.empty((*angles.shape[:-1], 0, 3))
        if not self.steered:
            constant = np.array(self.equation(name).equation([0.0])[0], dtype=float).reshape(rows, 3)
            return np.broadcast_to(constant, (*angles.shape[:-1], rows, 3)).copy()
        return self.equation(name)(angles)[0].reshape(*angles.shape[:-1], rows, 3)

    def _angles(self, steering: ArrayLike | None) -> Array:
        """Checked steering angles (..., k); those at rest for None."""
        return np.zeros(len(self.steered)) if steering is None else vectors("steering", steering, len(self.steered))

    def steering(
        self, twist: ArrayLike, current: ArrayLike | None = None, *, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Angles (..., k), rad against the wheels' rest, that put each steered axle through the centre of rotation.

        Parameters
        ----------
        twist : (..., 3).
        current : (..., k) rad. The angle is then the nearest to it modulo half turns (the wheel may roll backwards),
            and wheels whose contact stands still stay. None: wheels head where they roll, in (-pi, pi], and stay at 0.
            Wheels with `max_steering` take the half turn around their rest, whatever is current.

        A group that several wheels share takes the angle that drags them least. Driven castors stay as they are.

        Raises
        ------
        OutOfLimits
            A wheel would have to turn beyond its `max_steering`.
        ShapeError
        """
        if not self.steered:
            twists = vectors("twist", twist, 3)
            return np.zeros((*twists.shape[:-1], 0))
        given = (twist,) if current is None else (twist, current)
        found = self.equation("steering" if current is None else "steering_near")(*given, out=out, threads=threads)[0]
        refused = beyond_steering(self, found, self._max_steering)
        if refused is not None:
            raise refused
        return found

    @functools.cached_property
    def _max_steering(self) -> list[float]:
        limits = [[self.wheels[i].max_steering for i in g] for g in self.layout.groups]
        return [min((x for x in g if x is not None), default=math.inf) for g in limits]

    def wheel_speeds(
        self, twist: ArrayLike, steering: ArrayLike | None = None, *, tolerance: float = DRAG,
        out: Array | None = None, threads: int = 1,
    ) -> Array:  # fmt: skip
        """Inverse model: speeds (..., m) of `driven`, rad/s.

        Parameters
        ----------
        twist : (..., 3) m/s, rad/s.
        steering : (..., k) rad; None: the angles that `steering(twist)` gives.
        tolerance : sideways speed, m/s, at which a wheel counts as dragged.

        Raises
        ------
        OutOfLimits
            The twist would drag a wheel sideways (says which, how fast, in which row; `feasible` gives the nearest that
            does not) or steer it too far; or the tolerance is below zero.
        ShapeError
        """
        if not (is_number(tolerance) and tolerance >= 0.0):
            raise OutOfLimits(f"tolerance is {shown(tolerance)}; state a sideways speed in m/s, not below zero")
        if not self.steered:
            check_threads(threads)
            self._angles(steering)
            twists = vectors("twist", twist, 3)
            speeds, *drags = product(twists, self._inverse, out), twists @ self._sideways
        else:
            if steering is None and any(x < math.pi / 2 for x in self._max_steering):
                steering = self.steering(twist)
            given = (twist,) if steering is None else (twist, steering)
            name = "free_wheel_speeds" if steering is None else "wheel_speeds"
            speeds, *drags = self.equation(name)(*given, out=out, threads=threads)
        for drag in drags:
            if max(drag.max(initial=0.0), -drag.min(initial=0.0)) > tolerance:
                raise dragged_wheel(self, twist, steering, drag)
        return speeds

    def twist(
        self, speeds: ArrayLike, steering: ArrayLike | None = None, *, out: Array | None = None, threads: int = 1
    ) -> Array:
        """Forward model: twist (..., 3) that keeps the sliding constraints and fits the driven rims best, in m/s.

        Steered wheels whose axles do not meet in one point lead where they are dragged least.

        Parameters
        ----------
        speeds : (..., m) rad/s, in the order of `driven`.
        steering : (..., k) rad; None: at rest.

        Raises
        ------
        InputError
            The driven speeds do not determine the twist (at this steering).
        ShapeError
        """
        if not self.steered:
            check_threads(threads)
            self._angles(steering)
            return product(vectors("speeds", speeds, len(self.driven)), self._forward, out)
        angles = np.zeros(len(self.steered)) if steering is None else steering
        found, *measures = self.equation("twist")(speeds, angles, out=out, threads=threads)
        if any(determined.min(initial=1.0) < DETERMINED for determined in measures):
            raise undetermined(self)
        return found

    def residual(self, speeds: ArrayLike, steering: ArrayLike | None = None) -> Array:
        """Rim speeds (..., m), m/s, that no twist explains: measured minus those of `twist(speeds, steering)`."""
        twists = self.twist(speeds, steering)
        rows = self.rolling_matrix(steering)[..., self._driven_rows, :]
        rims = vectors("speeds", speeds, len(self.driven)) * self.wheel_radii
        return rims - np.einsum("...ri,...i->...r", rows, twists)

    def sliding(self, twist: ArrayLike, steering: ArrayLike | None = None) -> Array:
        """Sideways speed (..., rows), m/s, of each wheel in `sliding_names`; `steering` None: at rest."""
        return np.einsum("...ri,...i->...r", self.sliding_matrix(steering), vectors("twist", twist, 3))

    def feasible(self, twist: ArrayLike, steering: ArrayLike | None = None) -> Array:
        """Nearest twist (..., 3), in (vx, vy, R w), that drags no wheel.

        `steering` (..., k) holds the wheels there; None lets them steer: fixed wheels are obeyed first, and limits of
        steering (`max_steering`) kept, then steered ones are turned to what is left, then what shared steering cannot
        follow is taken away.
        """
        twists = vectors("twist", twist, 3)
        if steering is None and self.steered:
            scale = np.array([1.0, 1.0, self.radius])
            twists = (self._wedges.nearest((twists * scale).reshape(-1, 3)) / scale).reshape(twists.shape)
            steering = self.steering(twists)
        return self._projected(twists, self.sliding_matrix(steering))

    @property
    def turning_radius(self) -> float:
        """Radius, m, of the tightest curve that the origin of base_link can drive to either side.

        0 where it turns on the spot, infinite where it cannot turn.
        """
        return tightest_curve(self._wedges, self.radius)

    @functools.cached_property
    def _wedges(self) -> Wedges:
        return wedges_of(self.layout, self._max_steering, self.sliding_names, self.sliding_matrix(), self.radius)

    def _projected(self, twists: Array, C1: Array) -> Array:
        """The part of twists (..., 3) that rows (..., n, 3) do not see, square in (vx, vy, R w)."""
        if C1.shape[-2] == 0:
            return twists.copy()
        seen = seen_twists(self.radius, C1)
        scale = np.array([1.0, 1.0, self.radius])
        scaled = twists * scale
        return (scaled - np.einsum("...ki,...kj,...j->...i", seen, seen, scaled)) / scale

    def castor_rates(self, twist: ArrayLike, turned: ArrayLike | None = None) -> CastorRates:
        """How the castors follow a twist (..., 3): see `castors.castor_rates`."""
        return castor_rates(self, twist, turned)

    @staticmethod
    def desaturate(speeds: ArrayLike, max_speed: float) -> Array:
        """Scale wheel speeds (..., m) down together so that none exceeds `max_speed`: the direction of travel stays.

        Any unit. Source: WPILib `desaturateWheelSpeeds`.
        """
        if not (is_number(max_speed) and max_speed > 0.0):
            raise OutOfLimits(f"max_speed is {shown(max_speed)}; state a number above zero")
        wanted = finite("speeds", speeds)
        if wanted.ndim == 0 or wanted.shape[-1] == 0:
            raise ShapeError(f"speeds has shape {wanted.shape}; (..., m) is needed, one per wheel")
        return wanted * (max_speed / np.maximum(np.abs(wanted).max(axis=-1, keepdims=True), max_speed))

    # matrices of specification 6.2

    @property
    def velocity_coupling(self) -> Array:
        """D (m, 3): rim speeds, m/s, per (vx, vy, R w); rows (-sin phi_i, cos phi_i, 1) of omni wheels.

        Raises
        ------
        InputError
            The base steers, so that D is no constant: `rolling_matrix(steering)`.
        """
        if self.steered:
            raise no_constant(self)
        return self.rest_coupling

    @property
    def rest_coupling(self) -> Array:
        """D (m, 3) with the steered wheels at rest."""
        return self.rolling_matrix()[self._driven_rows] * np.array([1.0, 1.0, 1.0 / self.radius])

    @property
    def steerable(self) -> Array:
        """(3, 3): a twist to the nearest one that drags no fixed wheel."""
        return self._wedges.projector

    @property
    def force_coupling(self) -> Array:
        """C_alpha (3, m): (ax, ay, R wd) = C_alpha f / mass for rim forces f, N, at rest.

        diag(1, 1, 1/alpha) D^T where the centre of mass lies at the origin and no wheel must not slide sideways.
        """
        motions = free_motions(self.sliding_matrix() * np.array([1.0, 1.0, 1.0 / self.radius]))
        return reaction(motions, inertia_over_mass(self.radius, self.alpha, self.com)) @ self.velocity_coupling.T

    @property
    def velocity_coupling_inverse(self) -> Array:
        """D^+ (3, m): (vx, vy, R w) = D^+ m for rim speeds m; without the sliding constraints (`twist` keeps those)."""
        return np.asarray(np.linalg.pinv(self.velocity_coupling, rcond=1e-10), dtype=np.float64)

    @property
    def force_coupling_inverse(self) -> Array:
        """C_alpha^+ (m, 3): rim forces f = mass C_alpha^+ (ax, ay, R wd), the smallest that do it."""
        return np.asarray(np.linalg.pinv(self.force_coupling, rcond=1e-10), dtype=np.float64)

    # constant models, transposed and C-contiguous: a product with rows of samples is then three times faster

    @functools.cached_property
    def _inverse(self) -> Array:
        """(3, m): rows of twists times this are wheel speeds."""
        return np.ascontiguousarray((self.rolling_matrix()[self._driven_rows] / self.wheel_radii[:, None]).T)

    @functools.cached_property
    def _sideways(self) -> Array:
        """(3, axles): rows of twists times this are sideways speeds, one for all wheels on one axle.

        A lone one stands twice: a product with one column takes BLAS longer than with two.
        """
        rows = distinct_rows(self.sliding_matrix())
        return np.ascontiguousarray(np.repeat(rows, 2 if len(rows) == 1 else 1, axis=0).T)

    @functools.cached_property
    def _forward(self) -> Array:
        """(m, 3): rows of wheel speeds times this are twists, `S (D S)^+` with S the motions that drag no wheel."""
        scale = np.array([1.0, 1.0, 1.0 / self.radius])
        S = free_motions(self.sliding_matrix() * scale)
        seen = (self.rolling_matrix()[self._driven_rows] * scale) @ S
        if np.linalg.matrix_rank(seen, tol=1e-7) < S.shape[1]:
            raise undetermined(self)
        return np.ascontiguousarray((scale[:, None] * (S @ np.linalg.pinv(seen)) * self.wheel_radii).T)
