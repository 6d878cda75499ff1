"""From one moving state to another in the least time, speeds, accelerations and jerks limited (Ruckig)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import MissingExtra, MotionError, OutOfLimits, ShapeError
from holonom.mechanics.motion.trajectory import (
    JointLimits,
    Trajectory,
    check_count,
    check_inside,
    joint_vector,
    limits_of,
)
from holonom.model import outside
from holonom.model.joint_values import written

__all__ = ["plan_transfer"]

LONG = 100.0
"""s: Ruckig's tolerances are absolute and its durations end at 7600, so longer motions are given in another unit."""

State = Sequence[ArrayLike]


def plan_transfer(
    start: State, goal: State, limits: JointLimits, *, jerk: ArrayLike, dt: float = 1e-3, line: int = 0
) -> Trajectory:
    """Least-time motion between two states, all joints arriving together; not straight in joint space.

    Parameters
    ----------
    start, goal
        (q,), (q, qd) or (q, qd, qdd), each (n,); what is left out is zero. A goal may still move.
    limits
        Joint limits; positions are checked along the whole motion.
    jerk
        Largest jerk, one number or (n,), rad/s^3 or m/s^3.
    dt
        Time between samples (s); the motion ends on one.
    line
        Source line to carry along.

    Raises
    ------
    OutOfLimits, ShapeError
        A limit or state that is none.
    MotionError
        No motion within the limits; the message names the joint whose goal cannot be, or that leaves its position
        limits. More samples than can be held.
    InputError
        Ruckig is not installed (extra "motion").

    Notes
    -----
    L. Berscheid and T. Kroeger, "Jerk-limited real-time trajectory generation with arbitrary target states", RSS 2021.
    """
    ruckig, n = _ruckig(), limits.lower.shape[0]
    first, last = _state("start", start, n), _state("goal", goal, n)
    check_inside(last[0], limits)
    _check_rates(limits)
    jerks = _jerks(jerk, n)
    _check_goal(last, limits, jerks)
    pieces, duration = _solve(ruckig, first, last, limits, jerks, dt)
    check_count(duration, dt)
    times = np.minimum(dt * np.arange(round(duration / dt) + 1), duration)
    q, qd, qdd = _sampled(pieces, times)
    q[0], q[-1] = first[0], last[0]
    _check_way(q, limits)
    return Trajectory(dt, q, qd, qdd, line, brake=len(times) - 1)


def _ruckig() -> Any:
    try:
        import ruckig
    except ImportError:
        raise MissingExtra("plan_transfer", "Ruckig", "motion") from None
    return ruckig


def _state(name: str, state: State, n: int) -> list[Array]:
    if not 1 <= len(state) <= 3:
        raise ShapeError(f"{name} has {len(state)} parts; give (q,), (q, qd) or (q, qd, qdd)")
    parts = [joint_vector(f"{name} {part}", value, n) for part, value in zip(("q", "qd", "qdd"), state, strict=False)]
    return parts + [np.zeros(n)] * (3 - len(parts))


def _jerks(jerk: ArrayLike, n: int) -> Array:
    given = real_array("jerk", jerk)
    if given.shape not in ((), (n,)) or not (given > 0.0).all() or not np.isfinite(given).all():
        raise OutOfLimits(f"jerk {jerk!r}: give a positive, finite one, or ({n},) of them")
    return np.broadcast_to(given, (n,))


def _check_rates(limits: JointLimits) -> None:
    for name, values in (("speed", limits.speed), ("acceleration", limits.acceleration)):
        if not (values > 0.0).all() or not np.isfinite(values).all():
            j = int(np.argmin((values > 0.0) & np.isfinite(values)))
            raise OutOfLimits(f"{name} limit of {limits.names[j]} is {values[j]:g}; give a positive, finite one")


def _check_goal(last: list[Array], limits: JointLimits, jerk: Array) -> None:
    """A goal that moves must be within the limits, and just before and after it too: v + a |a| / (2 j) beside v."""
    _, v, a = last
    fastest = np.maximum(np.abs(v), np.abs(v) + np.where(v * a < 0.0, a * a / (2.0 * jerk), 0.0))
    for what, value, limit in (("acceleration", np.abs(a), limits.acceleration), ("speed", fastest, limits.speed)):
        beyond = value > limit * (1.0 + 1e-9)
        if beyond.any():
            j = int(np.argmax(beyond))
            raise MotionError(
                f"no motion between these states within the limits: at the goal {limits.names[j]} has speed {v[j]:g} "
                f"and acceleration {a[j]:g}, so it needs {what} {value[j]:g}; its limit is {limit[j]:g}"
            )


@dataclass(frozen=True, slots=True)
class _Pieces:
    """Of a joint, the times from which on its jerk is constant, and q, qd, qdd, jerk (4, k) there."""

    start: Array
    state: Array


def _solve(
    ruckig: Any, first: list[Array], last: list[Array], limits: JointLimits, jerk: Array, dt: float
) -> tuple[list[_Pieces], float]:
    """Ruckig's trajectory, lengthened to whole samples; its unit of time is a second over `rate`."""
    rate = _rate(first, last, limits)
    units = [1.0, 1.0 / rate, 1.0 / rate**2]
    wanted = ruckig.InputParameter(len(jerk))
    wanted.current_position, wanted.current_velocity, wanted.current_acceleration = _scaled(first, units)
    wanted.target_position, wanted.target_velocity, wanted.target_acceleration = _scaled(last, units)
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = _scaled(
        [limits.speed, limits.acceleration, jerk], [1.0 / rate, 1.0 / rate**2, 1.0 / rate**3]
    )
    found = ruckig.Trajectory(len(jerk))
    for _ in range(2):  # first as fast as it goes, then in whole samples
        try:
            result = ruckig.Ruckig(len(jerk)).calculate(wanted, found)
        except (ruckig.RuckigError, ValueError):  # the latter: a result that it has no name for
            result = None
        if result not in (ruckig.Result.Working, ruckig.Result.Finished) or not isfinite(found.duration):
            far = ", ".join(f"{a:g} to {b:g}" for a, b in zip(first[0], last[0], strict=True))
            raise MotionError(
                f"no motion between these states within the limits was found (positions {far}): "
                "what is asked is too long, or too short, for speeds, accelerations and jerks of this size"
            )
        wanted.minimum_duration = max(ceil(found.duration / rate / dt - 1e-9), 1) * dt * rate
    scales = np.array([1.0, rate, rate**2, rate**3])[:, None]
    pieces = [_pieces(profile) for profile in found.profiles[0]]
    return [_Pieces(p.start / rate, p.state * scales) for p in pieces], found.duration / rate


def _rate(first: list[Array], last: list[Array], limits: JointLimits) -> float:
    """1, or the power of two that brings a motion of more than `LONG` seconds to about that many units."""
    speed = limits.speed + np.abs(first[1]) + np.abs(last[1])
    with np.errstate(over="ignore"):
        longest = float(np.max(np.abs(last[0] - first[0]) / limits.speed + speed / limits.acceleration))
    return 2.0 ** -min(ceil(np.log2(longest / LONG)), 64) if LONG < longest < np.inf else 1.0


def _scaled(parts: list[Array], units: list[float]) -> list[list[float]]:
    return [(unit * part).tolist() for part, unit in zip(parts, units, strict=True)]


def _pieces(profile: Any) -> _Pieces:
    """Of one joint: what brakes it into its limits, the seven phases, and what stays at the end."""
    brake = profile.brake
    durations = [*brake.t, *profile.t]
    ends = [profile.p[7], profile.v[7], profile.a[7], 0.0]
    rows = [[*b, *p[:7]] for b, p in ((brake.p, profile.p), (brake.v, profile.v), (brake.a, profile.a))]
    state = np.array([*rows, [*brake.j, *profile.j]])
    used = np.array(durations) > 0.0
    start = np.concatenate([[0.0], np.cumsum(np.array(durations)[used])])
    return _Pieces(start, np.column_stack([state[:, used], ends]))


def _sampled(pieces: list[_Pieces], times: Array) -> tuple[Array, Array, Array]:
    """q, qd, qdd (N, n) at times (N,)."""
    q, qd, qdd = (np.empty((len(times), len(pieces))) for _ in range(3))
    for i, joint in enumerate(pieces):
        at = np.searchsorted(joint.start, times, side="right") - 1
        p, v, a, j = joint.state[:, at]
        t = times - joint.start[at]
        q[:, i], qd[:, i] = p + t * (v + t * (a / 2.0 + t * j / 6.0)), v + t * (a + t * j / 2.0)
        qdd[:, i] = a + t * j
    return q, qd, qdd


def _check_way(q: Array, limits: JointLimits) -> None:
    beyond = outside(q, limits.lower, limits.upper)
    if beyond.any():
        j = int(np.argmax(beyond.any(axis=0)))
        worst = q[np.argmax(beyond[:, j]), j]
        raise MotionError(
            f"{limits.names[j]} would go to {written(worst, limits.turns[j])} on the way; {limits_of(limits, j)}: "
            "start slower, or take a way round"
        )
