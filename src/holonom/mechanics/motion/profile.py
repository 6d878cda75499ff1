"""Scalar time laws s(t) from 0 to 1, at rest at both ends, in the least time that their family allows.

A law rises to its top speed over a ramp, cruises, and falls again as the mirror image of the rise. The rise
is a polynomial of the ramp's fraction x; a new family is one more line in the table `PROFILES`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf, isfinite, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyder, polyint, polyval
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import OutOfLimits
from holonom.registry import Method, Table

__all__ = ["PROFILES", "Grid", "GridSamples", "Law", "LawSamples", "Rise", "grid_of", "on_grid", "sample", "time_law"]


@dataclass(frozen=True, slots=True)
class Rise:
    """How the speed rises from 0 to 1 while x goes from 0 to 1.

    Attributes
    ----------
    speed
        Coefficients of the polynomial f(x), lowest power first; f(0) = 0, f(1) = 1, f never falls.
        Where f(x) + f(1 - x) = 1, the fall of one motion and the rise of an equal one sum to a constant.
    slope, curvature
        Largest |f'| and |f''| on [0, 1]; the curvature is infinite where f' jumps at an end.
    cruises
        Whether the law holds its top speed for a while once a longer ramp is not needed.
    """

    speed: tuple[float, ...]
    slope: float
    curvature: float
    cruises: bool

    @property
    def area(self) -> float:
        """Integral of f over [0, 1]."""
        return sum(c / (k + 1) for k, c in enumerate(self.speed))


_TRAPEZOID = Rise(speed=(0.0, 1.0), slope=1.0, curvature=inf, cruises=True)
_SCURVE = Rise(speed=(0.0, 0.0, 3.0, -2.0), slope=1.5, curvature=6.0, cruises=True)
# s = 10 u^3 - 15 u^4 + 6 u^5 over the whole time; its speed up to u = 1/2 is (x (2 - x))^2, x = 2 u.
_QUINTIC = Rise(speed=(0.0, 0.0, 4.0, -4.0, 1.0), slope=8 / sqrt(27), curvature=8.0, cruises=False)
_MOST = 1e18
"""Samples that can be numbered."""
_BOOK = "Biagiotti, Melchiorri, Trajectory Planning for Automatic Machines and Robots, ch. 2, 3"

PROFILES: Final = Table(
    "profiles",
    "motion profile",
    "its `Rise`",
    {
        "trapezoid": Method("constant acceleration, cruise, constant braking", lambda _: _TRAPEZOID, _BOOK),
        "scurve": Method("speed rises along a cubic; jerk limited", lambda _: _SCURVE, _BOOK),
        "quintic": Method("one polynomial of degree 5 for the whole way", lambda _: _QUINTIC, _BOOK),
    },
)


@dataclass(frozen=True, slots=True)
class Law:
    """A time law: a ramp (s), a cruise (s) and the mirrored ramp, over which s goes from 0 to 1."""

    rise: Rise
    ramp: float
    cruise: float

    @property
    def duration(self) -> float:
        """Time from rest to rest (s)."""
        return 2.0 * self.ramp + self.cruise


class LawSamples(NamedTuple):
    """Values of a law, each of the shape of the times: s (1), ds (1/s), dds (1/s^2)."""

    s: Array
    ds: Array
    dds: Array


class GridSamples(NamedTuple):
    """Samples of a law at equal steps, each (N,), and the index at which it begins to brake."""

    law: LawSamples
    brake: int


def time_law(
    distance: float,
    speed: float,
    acceleration: float,
    jerk: float = inf,
    *,
    profile: str = "scurve",
) -> Law:
    """Fastest law of a family over a distance.

    Parameters
    ----------
    distance
        Length of the motion, not negative, in any unit U. Zero gives a law of duration zero.
    speed, acceleration, jerk
        Largest speed (U/s), acceleration (U/s^2) and jerk (U/s^3), positive. Only the jerk may be infinite.
    profile
        A name in `PROFILES`.

    Returns
    -------
    Law
        Where the distance is too short for the full speed, the ramps meet and there is no cruise.

    Raises
    ------
    UnknownName
        No such profile.
    OutOfLimits
        A limit that is not positive, or a finite jerk asked of a profile whose acceleration jumps.

    Notes
    -----
    The ramp to speed v takes ``max(slope v / a, sqrt(curvature v / j))``; the duration falls with v as long
    as both ramps fit into the distance, so the fastest law has the largest v that fits.
    """
    rise: Rise = PROFILES.make(profile)
    _check(distance, speed, acceleration, jerk, profile)
    if distance == 0.0:
        return Law(rise, 0.0, 0.0)
    both = 2.0 * rise.area
    per_speed = rise.slope / acceleration
    per_root = rise.curvature / jerk if isfinite(jerk) else 0.0
    top = min(speed, sqrt(distance / (both * per_speed)))
    if per_root > 0.0:
        top = min(top, float(np.cbrt((distance / both) ** 2 / per_root)))
    if not rise.cruises:
        return Law(rise, distance / (both * top), 0.0)
    ramp = max(per_speed * top, sqrt(per_root * top))
    return Law(rise, ramp, max(distance / top - both * ramp, 0.0))


def sample(law: Law, t: ArrayLike) -> LawSamples:
    """Exact values of a law at times (s); before its start and after its end it is at rest.

    Where the acceleration jumps (the trapezoid's corners), it is given as zero: the corner belongs to the
    rest or the cruise beside it, and at a peak without cruise zero is the mean of both sides.
    """
    time = np.clip(np.asarray(t, dtype=np.float64), 0.0, law.duration)
    if law.duration == 0.0:
        return LawSamples(np.ones_like(time), np.zeros_like(time), np.zeros_like(time))
    falling = time > 0.5 * law.duration
    near = np.where(falling, law.duration - time, time)
    x = np.minimum(near / law.ramp, 1.0)
    top = 1.0 / (2.0 * law.rise.area * law.ramp + law.cruise)
    f = np.asarray(law.rise.speed)
    covered = top * (law.ramp * polyval(x, polyint(f)) + np.maximum(near - law.ramp, 0.0))
    slope = np.where((x > 0.0) & (x < 1.0), polyval(x, polyder(f)), 0.0) * (top / law.ramp)
    return LawSamples(
        np.where(falling, 1.0 - covered, covered),
        top * polyval(x, f),
        np.where(falling, -slope, slope),
    )


@dataclass(frozen=True, slots=True)
class Grid:
    """A law whose ramp and cruise are whole multiples of `dt` (s), `ramp` and `cruise` of them; samples on demand."""

    rise: Rise
    ramp: int
    cruise: int
    dt: float

    @property
    def count(self) -> int:
        """Number of samples."""
        return 2 * self.ramp + self.cruise + 1

    @property
    def brake(self) -> int:
        """Index of the sample at which it begins to brake."""
        return self.ramp + self.cruise

    def at(self, samples: ArrayLike) -> LawSamples:
        """Exact values at samples by their numbers, whole or not."""
        if self.ramp == 0:
            return sample(Law(self.rise, 0.0, 0.0), samples)
        unit = sample(Law(self.rise, float(self.ramp), float(self.cruise)), samples)  # in units of dt: exact
        return LawSamples(unit.s, unit.ds / self.dt, unit.dds / self.dt**2)


def grid_of(law: Law, dt: float) -> Grid:
    """Lengthen the ramp and the cruise of a law to whole multiples of `dt` (s).

    The lengthened law keeps every limit of `law`, ends on its last sample, and starts to brake on a sample.

    Raises
    ------
    OutOfLimits
        A law that lasts longer than samples can be numbered.
    """
    if law.duration == 0.0:
        return Grid(law.rise, 0, 0, dt)
    if not law.duration / dt < _MOST:
        raise OutOfLimits(f"the motion would last {law.duration:g} s in steps of {dt:g} s; give a greater speed")
    # The 1e-9 of a sample forgives the rounding of a ratio that should be whole.
    return Grid(law.rise, max(1, ceil(law.ramp / dt - 1e-9)), ceil(law.cruise / dt - 1e-9), dt)


def on_grid(law: Law, dt: float) -> GridSamples:
    """Samples every `dt` (s) of a law whose ramp and cruise are lengthened to multiples of `dt`; see `grid_of`."""
    grid = grid_of(law, dt)
    return GridSamples(grid.at(np.arange(grid.count)), grid.brake)


def _check(distance: float, speed: float, acceleration: float, jerk: float, profile: str) -> None:
    if not 0.0 <= distance < inf:
        raise OutOfLimits(f"distance {distance}: give a finite length, not negative")
    if not speed > 0.0:
        raise OutOfLimits(f"speed limit {speed}: give a positive one")
    if not 0.0 < acceleration < inf:
        raise OutOfLimits(f"acceleration limit {acceleration}: give a positive, finite one")
    if not jerk > 0.0:
        raise OutOfLimits(f"jerk limit {jerk}: give a positive one, or infinity for none")
    if isfinite(jerk) and not isfinite(PROFILES.make(profile).curvature):
        smooth = ", ".join(name for name in PROFILES if isfinite(PROFILES.make(name).curvature))
        raise OutOfLimits(f"profile {profile!r} cannot keep a jerk limit of {jerk}; use {smooth}")
