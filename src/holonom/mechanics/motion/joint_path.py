"""Joint paths: where the joints go, without saying when. A SciPy piecewise polynomial, or anything like one."""

from __future__ import annotations

from math import factorial
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import MotionError, OutOfLimits, ShapeError

__all__ = ["JointPath", "check_smooth", "joint_spline", "place_of"]


_CORNER = 1e-6  # jump of the direction, relative to the largest slope, that counts as a corner
_STILL = 1e-9  # slope and bend, relative to the largest slope, that count as standing still


class JointPath(Protocol):
    """A path q(s) from `x[0]` to `x[-1]`, twice differentiable between the breakpoints `x` (as `scipy.interpolate`)."""

    @property
    def x(self) -> Array:
        """Breakpoints (k,), rising."""

    def __call__(self, s: Array, nu: int = 0, /) -> Array:
        """Derivative number `nu` by s at s (N,): (N, n)."""


def joint_spline(points: ArrayLike, *, degree: int = 3, s: ArrayLike | None = None) -> JointPath:
    """Interpolating spline through joint positions.

    Parameters
    ----------
    points
        (k, n), k >= 2; neighbours differ.
    degree
        3: speeds and accelerations are continuous along the path; 5: jerk and its rate too. Natural ends.
    s
        The path's parameter at the points (k,), rising; the chord length if not given.

    Raises
    ------
    ShapeError, OutOfLimits
    """
    from scipy.interpolate import CubicSpline, PPoly, make_interp_spline

    q = real_array("points", points)
    if q.ndim != 2 or q.shape[0] < 2 or not np.isfinite(q).all():
        raise ShapeError(f"points have shape {q.shape}; give at least two finite configurations, (k, n)")
    if degree not in (3, 5):
        raise OutOfLimits(f"degree {degree} of a joint spline: give 3 or 5")
    at = _chords(q) if s is None else real_array("s", s)
    if at.shape != q.shape[:1] or not np.isfinite(at).all() or not (np.diff(at) > 0.0).all():
        raise ShapeError(f"s of shape {at.shape} for {q.shape[0]} points; give one finite, rising number per point")
    with np.errstate(over="ignore"):
        steep = ~np.isfinite(np.diff(q, axis=0) / np.diff(at)[:, None]).all(axis=1)
    if steep.any():
        k = int(np.argmax(steep))
        raise ShapeError(f"from point {k} to {k + 1} s rises by {at[k + 1] - at[k]:g} only; no slope can be that steep")
    if degree == 3:
        path: JointPath = CubicSpline(at, q, bc_type="natural")
        return path
    free = [(3, np.zeros(q.shape[1])), (4, np.zeros(q.shape[1]))]
    try:
        with np.errstate(all="ignore"):
            spline = make_interp_spline(at, q, k=5, bc_type=(free, free))
    except (np.linalg.LinAlgError, ValueError):
        raise ShapeError(
            f"s of the points goes in steps from {np.diff(at).min():g} to {np.diff(at).max():g}, too uneven for a "
            "spline of degree 5; give points that are more alike, or degree=3"
        ) from None
    quintic: JointPath = PPoly([spline(at[:-1], m) / factorial(m) for m in range(5, -1, -1)], at)
    return quintic


def _chords(q: Array) -> Array:
    """Lengths from the first point, along the chords."""
    steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
    if not (steps > 0.0).all():
        k = int(np.argmin(steps))
        raise ShapeError(f"points {k} and {k + 1} are the same; leave one out")
    return np.concatenate([[0.0], np.cumsum(steps)])


def place_of(path: JointPath, s: float) -> str:
    """Where on the path, for messages."""
    share = (s - path.x[0]) / (path.x[-1] - path.x[0])
    return f"at {100.0 * share:.1f} % of the path, q = {np.array2string(path(np.array([s]))[0], precision=4)},"


def check_smooth(path: JointPath, s: Array) -> None:
    """Refuse a path with a corner at a breakpoint, or one that stands still at one of `s` (N,).

    Where a path turns back (dq/ds = 0, but not d2q/ds2) it runs on: only the joints' speeds are zero there.

    Raises
    ------
    MotionError
    """
    slope = path(s, 1)
    size, bend = np.abs(slope).max(), np.abs(path(s, 2)).max(axis=1) * (s[-1] - s[0])
    still = np.maximum(np.abs(slope).max(axis=1), bend) <= _STILL * size
    if still.any():
        raise MotionError(
            f"{place_of(path, float(s[np.argmax(still)]))} the path stands still (dq/ds = d2q/ds2 = 0); "
            "leave out repeated points, or give a parameter that runs on"
        )
    inner = path.x[1:-1]
    if inner.size == 0:
        return
    jump = np.abs(path(inner, 1) - path(inner - 1e-9 * np.diff(path.x[:-1]), 1)) / size
    if jump.max() > _CORNER:
        row, joint = np.unravel_index(int(np.argmax(jump)), jump.shape)
        raise MotionError(
            f"{place_of(path, float(inner[row]))} joint {joint + 1} turns a corner, which takes infinite acceleration; "
            "round it (joint_spline), or retime the parts between corners one by one"
        )
