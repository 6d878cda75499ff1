"""Time-optimal retiming of a joint path under limits of speed, acceleration and torque."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import MotionError, OutOfLimits, ShapeError
from holonom.mechanics.motion.joint_path import JointPath, check_smooth, place_of
from holonom.mechanics.motion.trajectory import JointLimits, Trajectory, check_count
from holonom.model import outside

__all__ = ["DynamicArm", "retime"]


_SLACK = 1e-6  # excess over a limit, between samples too, that counts as kept
_PASSES = 12
_SETTLE = 4  # passes that settle the friction's dependence on the speed before margins change


class DynamicArm(Protocol):
    """What torque limits need of an arm."""

    def gravity(self, q: Array) -> Array:
        """Holding torques (..., n)."""

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array, *, friction: bool | None = None) -> Array:
        """Torques (..., n) of a motion."""


@dataclass(frozen=True, slots=True)
class _Bounds:
    """Limits (n,) each; torque is infinite where none is asked for."""

    speed: Array
    acceleration: Array
    torque: Array


@dataclass(frozen=True, slots=True)
class _Course:
    """The path on the grid s (N,): derivatives (N, n), and torque = a u + b x + g + friction, where an arm is given."""

    s: Array
    q: Array
    slope: Array
    curve: Array
    a: Array | None = None
    b: Array | None = None
    g: Array | None = None


@dataclass(frozen=True, slots=True)
class _Profile:
    """Times (N,), ds/dt (N,) and d2s/dt2 (N - 1,) over the grid s (N,)."""

    s: Array
    time: Array
    rate: Array
    u: Array


def retime(
    path: JointPath,
    limits: JointLimits,
    *,
    arm: DynamicArm | None = None,
    torque: ArrayLike | None = None,
    dt: float = 1e-3,
    grid: int = 2000,
    line: int = 0,
) -> Trajectory:
    """Run along a joint path in the least time, from rest to rest.

    Parameters
    ----------
    path
        As from `joint_spline`: any SciPy piecewise polynomial with values (n,) and a continuous direction.
    limits
        Positions that the path must keep; speeds and accelerations to be used. Accelerations may be infinite for
        joints whose torque is limited.
    arm, torque
        With both, the joints' torques (N m or N) stay within `torque` (n,) too, friction included.
    dt
        Time between samples (s).
    grid
        Intervals of the path on which the limits are set up; breakpoints are added.
    line
        Source line to carry along.

    Returns
    -------
    Trajectory
        Some joint is at one of its limits nearly everywhere. The time is lengthened to whole samples, and limits are
        kept between samples too, to one part in a million. Accelerations jump, at the ends also.

    Raises
    ------
    OutOfLimits
        A limit that is zero, negative or missing: names the joint.
    MotionError
        A corner, a path that stands still or leaves the position limits, torques that cannot hold the arm: names
        joint and place. More samples than can be held.

    Notes
    -----
    Reachability analysis: H. Pham and Q.-C. Pham, IEEE Trans. Robotics 34 (2018) 645; see `retime_kernels`. Viscous
    friction depends on ds/dt, not its square: it is taken from the profile before, until both agree.
    """
    count = path(path.x[:1]).shape[1]
    if (arm is None) != (torque is None):
        raise OutOfLimits("arm= and torque= go together: limits (n,) of the torques, such as arm.limits.torque")
    bounds = _bounds(limits, torque, count)
    s = np.union1d(np.linspace(path.x[0], path.x[-1], grid + 1), path.x)
    s = s[np.concatenate([[True], np.diff(s) > 1e-9 * (s[-1] - s[0])])]
    check_smooth(path, s)
    course = _course(path, s, arm)
    _check_positions(path, course, limits)
    if arm is not None:
        _check_holding(path, course, bounds)
    margins, rate = np.ones((3, s.shape[0])), np.zeros(s.shape[0])
    for k in range(_PASSES):
        friction = None if arm is None else _friction(arm, course, rate)
        profile = _solve(path, course, bounds, margins, friction)
        trajectory = _sampled(path, profile, dt, line)
        excess = _excess(path, profile, bounds, arm, trajectory)
        if (excess <= 1.0 + _SLACK).all():
            return trajectory
        rate = profile.rate
        if arm is None or k >= _SETTLE:
            margins /= np.where(excess > 1.0, excess + 0.1 * _SLACK, 1.0)
    raise MotionError(
        f"the limits of speed, acceleration and torque are passed by the factors {excess.max(axis=1)} between the "
        f"{grid} intervals of the grid; give a finer one (grid=)"
    )


def _bounds(limits: JointLimits, torque: ArrayLike | None, n: int) -> _Bounds:
    strength = np.full(n, np.inf) if torque is None else real_array("torque", torque)
    values = {"speed": limits.speed, "acceleration": limits.acceleration, "torque": strength}
    for name, value in values.items():
        if np.shape(value) != (n,):
            raise ShapeError(f"{name} limits have shape {np.shape(value)}; the path has {n} joints, give ({n},)")
        if not (value > 0.0).all():
            j = int(np.argmin(value > 0.0))
            raise OutOfLimits(f"{name} limit of {limits.names[j]} is {value[j]:g}; retiming needs a positive one")
    for j in range(n):
        if np.isinf(limits.speed[j]) or (np.isinf(limits.acceleration[j]) and np.isinf(strength[j])):
            raise OutOfLimits(
                f"{limits.names[j]} has speed limit {limits.speed[j]:g}, acceleration limit "
                f"{limits.acceleration[j]:g} and torque limit {strength[j]:g}; "
                "give a finite speed, and a finite acceleration or torque"
            )
    return _Bounds(limits.speed, limits.acceleration, strength)


def _course(path: JointPath, s: Array, arm: DynamicArm | None) -> _Course:
    q, slope, curve = path(s), path(s, 1), path(s, 2)
    if arm is None:
        return _Course(s, q, slope, curve)
    g, still = arm.gravity(q), np.zeros_like(q)
    a = arm.inverse_dynamics(q, still, slope, friction=False) - g
    b = arm.inverse_dynamics(q, slope, curve, friction=False) - g
    return _Course(s, q, slope, curve, a, b, g)


def _friction(arm: DynamicArm, course: _Course, rate: Array) -> Array:
    """Friction torques (N, n) at the speeds of a profile; at its ends those of the slowest motion."""
    qd, still = course.slope * np.maximum(rate, 1e-9)[:, None], np.zeros_like(course.q)
    friction: Array = arm.inverse_dynamics(course.q, qd, still, friction=True)
    return friction - arm.inverse_dynamics(course.q, qd, still, friction=False)


def _check_positions(path: JointPath, course: _Course, limits: JointLimits) -> None:
    beyond = outside(course.q, limits.lower, limits.upper)
    if beyond.any():
        row, j = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
        raise MotionError(
            f"{place_of(path, float(course.s[row]))} {limits.names[j]} is outside its limits {limits.lower[j]:.6g} to "
            f"{limits.upper[j]:.6g}; lead the path another way"
        )


def _check_holding(path: JointPath, course: _Course, bounds: _Bounds) -> None:
    assert course.g is not None
    use = np.abs(course.g) / bounds.torque
    if use.max() >= 1.0:
        row, j = np.unravel_index(int(np.argmax(use)), use.shape)
        raise MotionError(
            f"{place_of(path, float(course.s[row]))} joint {j + 1} needs {abs(course.g[row, j]):.4g} against gravity; "
            f"its torque limit is {bounds.torque[j]:.4g} (N m or N): lead the path another way or lighten the load"
        )


def _solve(path: JointPath, course: _Course, bounds: _Bounds, margins: Array, friction: Array | None) -> _Profile:
    from holonom.mechanics.motion.retime_kernels import controllable, fastest

    s, count = course.s, course.s.shape[0]
    a, b, c = _rows(course, bounds, margins, friction)
    with np.errstate(divide="ignore"):
        top = (margins[0] * np.min(bounds.speed / np.abs(course.slope), axis=1)) ** 2
    lower, upper, x, u = np.zeros(count), np.zeros(count), np.zeros(count), np.zeros(count - 1)
    scratch = np.empty((3, 2 * a.shape[1] + 2))
    stuck = controllable(s, a, b, c, top, lower, upper, scratch)
    if stuck >= 0 or lower[0] > 0.0:
        raise MotionError(
            f"{place_of(path, float(s[max(stuck, 0)]))} no speed keeps the limits and can still be braked to rest; "
            "raise the torque limits or lead the path another way"
        )
    fastest(s, a, b, c, lower, upper, x, u, scratch)
    rate = np.sqrt(x)
    time = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (rate[1:] + rate[:-1]))])
    return _Profile(s, time, rate, u)


def _rows(course: _Course, bounds: _Bounds, margins: Array, friction: Array | None) -> tuple[Array, Array, Array]:
    """a u + b x <= c for both signs of every finite acceleration and torque limit, scaled to c of about 1."""
    moves = np.isfinite(bounds.acceleration)
    limit = bounds.acceleration[moves]
    a, b = course.slope[:, moves] / limit, course.curve[:, moves] / limit
    c = np.ones_like(a) * margins[1][:, None]
    parts = [(a, b, c), (-a, -b, c)]
    if friction is not None:
        assert course.a is not None
        assert course.b is not None
        assert course.g is not None
        works = np.isfinite(bounds.torque)
        limit, rest = bounds.torque[works], (course.g + friction)[:, works]
        a, b, rest = course.a[:, works] / limit, course.b[:, works] / limit, rest / limit
        most = margins[2][:, None]
        parts += [(a, b, most - rest), (-a, -b, most + rest)]
    joined = [np.ascontiguousarray(np.concatenate(p, axis=1)) for p in zip(*parts, strict=True)]
    return joined[0], joined[1], joined[2]


def _sampled(path: JointPath, profile: _Profile, dt: float, line: int) -> Trajectory:
    """The motion every `dt`, slowed so that it ends on a sample."""
    check_count(float(profile.time[-1]), dt)
    count = max(ceil(profile.time[-1] / dt - 1e-9), 1)
    q, qd, qdd = _at(path, profile, np.linspace(0.0, profile.time[-1], count + 1), count * dt / profile.time[-1])
    return Trajectory(dt, q, qd, qdd, line, brake=count)


def _excess(
    path: JointPath, profile: _Profile, bounds: _Bounds, arm: DynamicArm | None, trajectory: Trajectory
) -> Array:
    """How many times speed, acceleration and torque limits are passed around every grid point: (3, N).

    Looked for at the samples, between them and inside every interval of the grid.
    """
    inside = profile.time[:-1, None] + np.diff(profile.time)[:, None] * np.array([0.001, 0.25, 0.5, 0.75, 0.999])
    fine = np.linspace(0.0, profile.time[-1], 2 * len(trajectory.q) - 1)
    time = np.concatenate([inside.ravel(), fine])
    q, qd, qdd = _at(path, profile, time, 1.0)
    found = np.zeros((3, time.shape[0]))
    found[0] = (np.abs(qd) / bounds.speed).max(axis=1)
    found[1] = (np.abs(qdd) / bounds.acceleration).max(axis=1)
    if arm is not None:
        slow = trajectory.duration / profile.time[-1]
        found[2] = (np.abs(arm.inverse_dynamics(q, qd / slow, qdd / slow**2)) / bounds.torque).max(axis=1)
    i = np.clip(np.searchsorted(profile.time, time, side="right") - 1, 0, profile.u.shape[0] - 1)
    worst = np.zeros((3, profile.time.shape[0]))
    for k in range(3):
        np.maximum.at(worst[k], i, found[k])
        np.maximum.at(worst[k], i + 1, found[k])
    return worst


def _at(path: JointPath, profile: _Profile, time: Array, stretch: float) -> tuple[Array, Array, Array]:
    """q, qd, qdd (N, n) at times (N,) of the profile, run `stretch` times slower."""
    i = np.clip(np.searchsorted(profile.time, time, side="right") - 1, 0, profile.u.shape[0] - 1)
    t, u = time - profile.time[i], profile.u[i]
    s = np.clip(profile.s[i] + t * (profile.rate[i] + 0.5 * u * t), profile.s[0], profile.s[-1])
    rate = np.maximum(profile.rate[i] + u * t, 0.0)
    ends = time >= profile.time[-1]
    s[ends], rate[ends] = profile.s[-1], 0.0
    slope = path(s, 1)
    qdd = path(s, 2) * (rate * rate)[:, None] + slope * u[:, None]
    return path(s), slope * (rate / stretch)[:, None], qdd / stretch**2
