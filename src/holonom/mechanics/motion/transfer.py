"""From one moving state to another in the least time, speeds, accelerations and jerks limited (Ruckig)."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import MissingExtra, MotionError, OutOfLimits, ShapeError
from holonom.mechanics.motion.trajectory import JointLimits, Trajectory, check_inside, joint_vector
from holonom.model import outside

__all__ = ["plan_transfer"]

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
        No motion within the limits; the message names the joint where one leaves its position limits.
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
    found = _solve(ruckig, first, last, limits, _jerks(jerk, n), dt)
    times = np.minimum(dt * np.arange(round(found.duration / dt) + 1), found.duration)
    q, qd, qdd = (np.array(part) for part in zip(*(found.at_time(float(t)) for t in times), strict=True))
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


def _solve(ruckig: Any, first: list[Array], last: list[Array], limits: JointLimits, jerk: Array, dt: float) -> Any:
    """Ruckig's trajectory, lengthened to whole samples."""
    wanted = ruckig.InputParameter(len(jerk))
    wanted.current_position, wanted.current_velocity, wanted.current_acceleration = (p.tolist() for p in first)
    wanted.target_position, wanted.target_velocity, wanted.target_acceleration = (p.tolist() for p in last)
    wanted.max_velocity, wanted.max_acceleration = limits.speed.tolist(), limits.acceleration.tolist()
    wanted.max_jerk = jerk.tolist()
    found = ruckig.Trajectory(len(jerk))
    for _ in range(2):  # first as fast as it goes, then in whole samples
        try:
            result = ruckig.Ruckig(len(jerk)).calculate(wanted, found)
        except ruckig.RuckigError as problem:
            raise MotionError(f"no motion between these states within the limits: {str(problem).strip()}") from None
        if result not in (ruckig.Result.Working, ruckig.Result.Finished) or not isfinite(found.duration):
            raise MotionError(f"no motion between these states within the limits: Ruckig answers {result}")
        wanted.minimum_duration = max(ceil(found.duration / dt - 1e-9), 1) * dt
    return found


def _check_way(q: Array, limits: JointLimits) -> None:
    beyond = outside(q, limits.lower, limits.upper)
    if beyond.any():
        j = int(np.argmax(beyond.any(axis=0)))
        worst = q[np.argmax(beyond[:, j]), j]
        raise MotionError(
            f"{limits.names[j]} would go to {worst:.6g} on the way; its limits are {limits.lower[j]:.6g} to "
            f"{limits.upper[j]:.6g} (rad or m): start slower, or take a way round"
        )
