"""Fly-by: the next segment starts while the last one brakes, their motions added in joint space."""

from __future__ import annotations

import numpy as np

from holonom.errors import MotionError
from holonom.mechanics.motion.trajectory import JointLimits, Trajectory, joined, remainder

__all__ = ["blend", "splice"]


_LONGEST = 20_000  # steps that an overlap lasts at most
_TRIALS = 33  # overlaps tried between the longest one and none
_SLACK = 1.0 + 1e-9  # forgives the rounding of sums that meet a limit exactly
_MEET = 1e-6  # largest gap (rad or m) between the end of one segment and the start of the next


def blend(first: Trajectory, second: Trajectory, limits: JointLimits) -> Trajectory:
    """Run `second` into the braking part of `first`.

    While they overlap, q = q1 + (q2 - q2 at its start), and speeds and accelerations add. The overlap begins
    where `first` begins to brake, at the earliest so that `first` has ended when `second` begins to brake (at
    most two segments overlap), and shrinks until the sums keep the joint limits; without overlap, the motion
    stops fully between the two.

    Parameters
    ----------
    first
        What has to be done first; only its last segment's braking part is touched.
    second
        A single segment from rest, as the planners return it, that starts where `first` ends; same `dt`.
    limits
        Joint limits that the sum has to keep.

    Returns
    -------
    Trajectory
        `begin` and `brake` are those of `second` in it, and so is `line`. A `second` without motion leaves
        `first` as it is.

    Raises
    ------
    MotionError
        `second` does not start where `first` ends, or is sampled at another rate.
    """
    _check_meeting(first, second, limits)
    if second.count == 1:
        return first
    return joined(first, second, _overlap(first, second, limits))


def splice(current: Trajectory, consumed: int, following: Trajectory, limits: JointLimits) -> Trajectory:
    """Blend a new segment into what remains of a running trajectory.

    Parameters
    ----------
    current
        The running trajectory.
    consumed
        How many of its samples are already used, 0 to N; they stay as they were. The result begins with
        sample number `consumed` (with the last one again, if all are used).
    following, limits
        As `second` and `limits` of `blend`.

    Returns
    -------
    Trajectory
        Replaces `current` from its sample `consumed` on, without a step in position or speed.

    Raises
    ------
    MotionError
        As `blend`; also a `consumed` outside 0 to N.
    """
    return blend(remainder(current, consumed), following, limits)


def _overlap(first: Trajectory, second: Trajectory, limits: JointLimits) -> int:
    """Longest tried overlap, in steps, whose sums keep the limits."""
    longest = min(first.count - 1 - first.brake, second.brake, _LONGEST)
    for lap in np.unique(np.linspace(longest, 0, _TRIALS).astype(int))[:0:-1]:
        if _keeps(first, second, int(lap), limits):
            return int(lap)
    return 0


def _keeps(first: Trajectory, second: Trajectory, lap: int, limits: JointLimits) -> bool:
    """Whether the sums keep the limits where the last `lap` steps of `first` meet the first of `second`."""
    end = first.count
    (q, qd, qdd), added = first.take(end - 1 - lap, end), second.take(0, lap + 1)
    qd = qd + added[1]
    if (np.abs(qd) > _SLACK * limits.speed).any():
        return False
    if (np.abs(qdd + added[2]) > _SLACK * limits.acceleration).any():
        return False
    # The trapezoid's acceleration jumps on samples, where it is given as zero; between them it shows here.
    if (np.abs(np.diff(qd, axis=0)) > _SLACK * limits.acceleration * first.dt).any():
        return False
    q = q + (added[0] - added[0, 0])
    return bool(((q >= limits.lower) & (q <= limits.upper)).all())


def _check_meeting(first: Trajectory, second: Trajectory, limits: JointLimits) -> None:
    if first.dt != second.dt:
        raise MotionError(f"segments sampled every {first.dt} s and {second.dt} s; plan both with one dt")
    gap = np.abs(first.end - second.take(0, 1)[0, 0])
    if (gap > _MEET).any():
        j = int(np.argmax(gap))
        unit = "rad" if limits.turns[j] else "m"
        raise MotionError(
            f"the motion of line {second.line} starts {gap[j]:.3g} {unit} of joint {j + 1} away "
            f"from the end of the one before (at most {_MEET:g} is allowed); plan it from there"
        )
