"""Reference paths of a base at 1 kHz: a curve, a speed within acceleration limits, a heading."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import OutOfLimits, ShapeError
from holonom.machine.base.paths.pose_paths import Poses, joined, plan_segments
from holonom.machine.base.paths.timing import GRID, TICK, PathLimits, ReferencePath, in_time, squared_speeds
from holonom.machine.levels import Levels, interpolate
from holonom.mobile.curves import Curves, dubins, reeds_shepp
from holonom.registry import OWN, Method, Table, parameter

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

__all__ = [
    "HEADINGS",
    "PATHS",
    "PathLimits",
    "ReferencePath",
    "circle",
    "figure_of_eight",
    "plan_path",
    "rounded_square",
    "sampled",
    "waypoints",
]

KNOTS = 400  # of the spline through a closed curve


def circle(size: float) -> Array:
    """Points (k, 2) of a circle of diameter `size`, m, through the origin, counter-clockwise, closed."""
    u = _turn()
    return 0.5 * size * np.stack([np.sin(u), 1.0 - np.cos(u)], axis=1)


def figure_of_eight(size: float) -> Array:
    """Points (k, 2) of Gerono's lemniscate, `size` (m) long and half as wide, from its middle, closed."""
    u = _turn()
    return 0.5 * size * np.stack([np.sin(u), np.sin(u) * np.cos(u)], axis=1)


def rounded_square(size: float) -> Array:
    """Points (k, 2) of a square of side `size`, m, from the middle of its lower side, with round corners, closed.

    A superellipse of order 4, whose corners have no jump of curvature.
    """
    u = _turn() - 0.5 * math.pi
    c, s = np.cos(u), np.sin(u)
    r = 0.5 * size / (c**4 + s**4) ** 0.25
    return np.stack([r * c, r * s + 0.5 * size], axis=1)


def waypoints(points: ArrayLike, *, closed: bool = False) -> Array:
    """Return way points (k, 2), m, as a curve's points; a closed one ends at its first.

    Raises
    ------
    ShapeError
        Fewer than two points, points that are not finite, or the same one twice in a row.
    """
    p = np.array(points, float)
    if p.ndim != 2 or p.shape[1] != 2 or len(p) < 2 or not np.isfinite(p).all():
        raise ShapeError(f"waypoints have shape {p.shape}; they must be (k, 2) with k of at least 2, finite")
    if closed and not np.allclose(p[0], p[-1]):
        p = np.vstack([p, p[:1]])
    same = np.flatnonzero(np.hypot(*np.diff(p, axis=0).T) < 1e-9)
    if len(same):
        raise ShapeError(f"way points {same[0]} and {same[0] + 1} are the same; leave one out")
    return p


@dataclass(frozen=True, slots=True)
class ClosedCurve:
    """A closed curve of a size."""

    size: float = parameter(meaning="its length", unit="m", above=0.0, example=2.0)


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Places in their order; closed where the last is the first."""

    points: tuple[tuple[float, float], ...] = parameter(
        meaning="x and y of each", unit="m", example=((0.0, 0.0), (1.0, 0.0))
    )


_CURVES = "Lawrence, A Catalog of Special Plane Curves"
_SPLINES = "de Boor, A Practical Guide to Splines"

PATHS = Table(
    "paths",
    "shape of a path",
    "its points (k, 2), m; from pose to pose, `Curves`",
    {
        "circle": Method("through the origin, counter-clockwise", lambda p: circle(p.size), _CURVES, ClosedCurve),
        "figure_of_eight": Method(
            "Gerono's lemniscate, half as wide as long", lambda p: figure_of_eight(p.size), _CURVES, ClosedCurve
        ),
        "rounded_square": Method(
            "a superellipse of order 4, from the middle of its lower side",
            lambda p: rounded_square(p.size),
            _CURVES,
            ClosedCurve,
        ),
        "waypoints": Method("a cubic spline through places", lambda p: waypoints(p.points), _SPLINES, Waypoints),
        "dubins": Method(
            "shortest way forwards from pose to pose, for bases that cannot turn on the spot",
            lambda p: joined(dubins, p.poses, p.radius),
            "Dubins, Am. J. Math. 79, 1957",
            Poses,
        ),
        "reeds_shepp": Method(
            "shortest way forwards and backwards from pose to pose, with cusps",
            lambda p: joined(reeds_shepp, p.poses, p.radius),
            "Reeds & Shepp, Pacific J. Math. 145, 1990",
            Poses,
        ),
    },
)
"""What a base may drive along."""


def plan_path(
    points: ArrayLike | Curves,
    limits: PathLimits = PathLimits(),
    *,
    laps: int = 1,
    heading: str | None = None,
    start: float = 0.0,
    turns: float = 1.0,
    rest: float = 0.3,
) -> ReferencePath:
    """Drive along a curve from rest to rest, as fast as the limits allow.

    Parameters
    ----------
    points
        (k, 2) of the curve, m, in order; a cubic spline goes through them. Closed where the last is the first. Or
        segments from pose to pose (`mobile.reeds_shepp`): driven once, along their tangent or against it; at cusps and
        where curvature jumps the base stands for `rest`, so that wheels can steer.
    limits
        Speed and acceleration.
    laps
        How often a closed curve is driven.
    heading
        "fixed" (unless given), "tangent" (base_link's x along the path) or "rotating" (evenly over the way).
    start
        Heading at the start (rad): of "fixed" and "rotating"; against the tangent for "tangent".
    turns
        Turns of a "rotating" base per lap, counter-clockwise.
    rest
        s of standing at both ends.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName
    InputError
        Segments that are to be driven with another heading, with laps, or turned (`start`).

    Notes
    -----
    The speed is the largest under `hypot(dv/dt, v^2 kappa) <= acceleration` (forward and backward pass over the
    curvature), then smoothed in time twice over the rise time, so that the acceleration has no jumps.
    """
    if isinstance(points, Curves):
        return plan_segments(points, limits, rest, heading, laps, start)
    turned: Heading = HEADINGS.make("fixed" if heading is None else heading)
    p = waypoints(points)
    closed = bool(np.allclose(p[0], p[-1]))
    if laps < 1 or (laps > 1 and not closed):
        raise OutOfLimits(f"plan_path: {laps} laps of {'a closed' if closed else 'an open'} curve; allowed is 1, or "
                          "more of a closed one")  # fmt: skip
    curve, length = _by_length(p, closed)
    s = np.linspace(0.0, laps * length, GRID * laps + 1)
    v = squared_speeds(s, _curvature(curve, s, length), limits)
    distance, speed, gain = in_time(s, v, limits.rise_time, rest)
    angle = turned(curve, distance, length, start, turns)
    return _reference(curve, length, distance, speed, gain, angle)


def _turn() -> Array:
    return np.linspace(0.0, 2.0 * math.pi, KNOTS + 1)


def _by_length(p: Array, closed: bool) -> tuple[CubicSpline, float]:
    """Spline over its own length: chords first, then corrected by the length of that spline."""
    from scipy.interpolate import CubicSpline  # heavy: on first use

    if closed:
        p = np.vstack([p[:-1], p[:1]])
    kind = "periodic" if closed else "natural"
    u = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(p, axis=0).T))])
    curve = CubicSpline(u, p, bc_type=kind)
    fine = np.linspace(0.0, u[-1], 20 * GRID + 1)
    rate = np.hypot(*curve(fine, 1).T)
    s = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(fine))])
    even = np.interp(np.linspace(0.0, s[-1], KNOTS + 1), s, fine)
    again = curve(even)
    if closed:
        again[-1] = again[0]
    return CubicSpline(np.linspace(0.0, s[-1], KNOTS + 1), again, bc_type=kind), float(s[-1])


def _on(curve: CubicSpline, s: Array, length: float, order: int) -> Array:
    """Curve or a derivative of it (N, 2) at distances that may run over several laps of a closed one."""
    beyond = s % length if curve.extrapolate == "periodic" else length
    value: Array = curve(np.where(s > length, beyond, s), order)
    return value


def _curvature(curve: CubicSpline, s: Array, length: float) -> Array:
    d, dd = _on(curve, s, length, 1), _on(curve, s, length, 2)
    k: Array = (d[:, 0] * dd[:, 1] - d[:, 1] * dd[:, 0]) / np.hypot(*d.T) ** 3
    return k


def _fixed(curve: CubicSpline, s: Array, length: float, start: float, turns: float) -> Array:
    return np.stack([np.full_like(s, start), np.zeros_like(s), np.zeros_like(s)])


def _tangent(curve: CubicSpline, s: Array, length: float, start: float, turns: float) -> Array:
    d = _on(curve, s, length, 1)
    k = _curvature(curve, s, length)
    return np.stack([np.unwrap(np.arctan2(d[:, 1], d[:, 0])) + start, k, np.gradient(k, TICK)])


def _rotating(curve: CubicSpline, s: Array, length: float, start: float, turns: float) -> Array:
    rate = 2.0 * math.pi * turns / length
    return np.stack([start + rate * s, np.full_like(s, rate), np.zeros_like(s)])


Heading = Callable[["CubicSpline", Array, float, float, float], Array]

HEADINGS = Table(
    "headings",
    "heading",
    "a function of the curve: heading, its rate over the way, and that rate's change in time, (3, N)",
    {
        "fixed": Method("the same all the way", lambda _: _fixed, OWN),
        "tangent": Method("along the path", lambda _: _tangent, OWN),
        "rotating": Method("turning evenly over the way", lambda _: _rotating, OWN),
    },
)
"""Heading (rad), its rate over the way (rad/m) and that rate's change in time (rad/m/s): (3, N)."""


def _reference(curve: CubicSpline, length: float, s: Array, speed: Array, gain: Array, heading: Array) -> ReferencePath:
    d, dd = _on(curve, s, length, 1), _on(curve, s, length, 2)
    velocity = d * speed[:, None]
    acceleration = d * gain[:, None] + dd * (speed**2)[:, None]
    theta, rate, change = heading
    c, sn = np.cos(theta), np.sin(theta)

    def in_base(w: Array) -> Array:
        return np.stack([c * w[:, 0] + sn * w[:, 1], c * w[:, 1] - sn * w[:, 0]], axis=1)

    turn, turn_change = rate * speed, rate * gain + change * speed
    return ReferencePath(
        TICK * np.arange(len(s), dtype=np.float64),
        np.column_stack([_on(curve, s, length, 0), theta]),
        np.column_stack([in_base(velocity), turn]),
        np.column_stack([in_base(acceleration), turn_change]),
    )


def sampled(path: ReferencePath, levels: Levels) -> ReferencePath:
    """Return what a base's servos see of a path whose points come once each period of the supervisor.

    Between them they interpolate as `levels` says; twist and acceleration are those of what came of it.
    """
    ratio = round(levels.supervisor / TICK)
    if ratio <= 1:
        return path
    at = np.append(np.arange(0, len(path.pose) - 1, ratio), len(path.pose) - 1)
    rows = interpolate(path.pose[at[:-1]], ratio, levels.interpolation)
    last = interpolate(path.pose[at[-2:]], int(at[-1] - at[-2]), levels.interpolation)
    pose = np.vstack([rows, last[1:]])
    speed = np.gradient(pose, TICK, axis=0)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    rate = np.gradient(speed, TICK, axis=0)

    def in_base(w: Array) -> Array:
        return np.stack([c * w[:, 0] + s * w[:, 1], c * w[:, 1] - s * w[:, 0], w[:, 2]], axis=1)

    return ReferencePath(path.time, pose, in_base(speed), in_base(rate))
