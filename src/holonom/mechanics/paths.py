"""Joints along a path of poses: one branch of the closed-form inverse, followed without a jump.

=======================  ======================================================================
`follow`                 from given joints along the path, as far as it goes, and why it ends
`feasible_branches`      the same from every branch of the first pose: which ones reach the end
=======================  ======================================================================

Branches are followed by continuity, not by name: where the wrist passes through its straight pose, `flip` becomes
`noflip` without a jump.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import InputError, ShapeError
from holonom.mechanics.arm.arm import Arm, IkResult, IkStatus
from holonom.mechanics.arm.nearest import joint_vectors
from holonom.mechanics.kernels.inverse.geometry import REACHED, pose_error
from holonom.model import outside

__all__ = ["BranchPath", "feasible_branches", "follow"]

JUMP = 0.5
"""Largest step of a joint between neighbouring poses (rad or m) that still counts as continuous."""
TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class BranchPath:
    """A branch along a path: its name at the start, q (reached, n), and why it ends there.

    `reached` poses were followed; `reason` is empty if that is all of them.
    """

    name: str
    q: Array
    reached: int
    reason: str

    @property
    def feasible(self) -> bool:
        """Whether the branch reaches the end."""
        return not self.reason


def follow(arm: Arm, T: ArrayLike, q0: ArrayLike, *, jump: float = JUMP) -> BranchPath:
    """Follow a path of poses from the solution nearest to q0 (`Arm.ik_nearest`), whole turns as q0 has them.

    Parameters
    ----------
    T : (N, 4, 4), T_wt (or points (N, 3), as for `Arm.ik`), dense: no joint has to step by more than `jump`.
    q0 : (n,) rad or m, in the limits.
    jump : rad or m.

    Returns
    -------
    The path as far as it is reachable, continuous and within the limits.

    Raises
    ------
    ShapeError, NotAPose, InputError
        T or q0 of another shape; no closed form for this arm.
    """
    start = joint_vectors("q0", q0, arm.limits.names)
    if start.ndim != 1:
        raise ShapeError(f"q0 must be of shape ({arm.n},); shape {start.shape} came")
    found = _solutions(arm, T, jump, start)
    first = arm.ik_nearest(np.asarray(T, dtype=float)[0], start)
    if first.status == IkStatus.UNREACHABLE:
        return BranchPath("", first.q[None][:0], 0, "pose 0 is out of reach")
    return _within_limits(arm, _tracked(arm, T, found, int(first.branch), first.q, jump))


def feasible_branches(arm: Arm, T: ArrayLike, *, jump: float = JUMP) -> list[BranchPath]:
    """Every branch that reaches the first pose, followed along the path; those that reach the end come first.

    Whole turns of a joint are chosen so that its whole way lies within the limits, where one does. Arguments and errors
    as for `follow`.
    """
    found = _solutions(arm, T, jump)
    starts = np.flatnonzero(found.status[0] != IkStatus.UNREACHABLE)
    paths = [_tracked(arm, T, found, int(k), found.q[0, k], jump) for k in starts]
    return sorted((_within_limits(arm, _best_turns(arm, p)) for p in paths), key=lambda p: (not p.feasible, -p.reached))


def _solutions(arm: Arm, T: ArrayLike, jump: float, q0: Array | None = None) -> IkResult:
    if not jump > 0.0:
        raise InputError(f"jump is {jump}; a positive step in rad or m is needed")
    found = arm.ik(T, q0)
    if found.q.ndim != 3 or not len(found.q):
        raise ShapeError(f"a path is (N, 4, 4) with N > 0; shape {np.shape(T)} came")
    return found


def _turned(arm: Arm, q: Array, reference: Array) -> Array:
    """The angles a whole number of turns away that are nearest to a reference."""
    turning = np.array([arm.model.joints[i].turns for i in arm.model.independent])
    return np.asarray(q + np.where(turning, TURN * np.round((reference - q) / TURN), 0.0))


def _tracked(arm: Arm, T: ArrayLike, found: IkResult, start: int, first: Array, jump: float) -> BranchPath:
    """The continuous way from one solution of the first pose, limits aside."""
    q = np.empty((len(found.q), arm.n))
    q[0] = first
    for i in range(1, len(q)):
        reached = found.status[i] != IkStatus.UNREACHABLE
        if not reached.any():
            return BranchPath(found.names[start], q[:i], i, f"pose {i} is out of reach")
        ways = _turned(arm, found.q[i, reached], q[i - 1])
        best = ways[np.argmin(np.abs(ways - q[i - 1]).max(-1))]
        if (found.status[i] >= IkStatus.SINGULAR).any():
            ahead = 2.0 * q[i - 1] - q[max(i - 2, 0)]
            best = _free_joints_kept(arm, np.asarray(T, dtype=float)[i], ahead, best)
        step = np.abs(best - q[i - 1])
        if step.max() > jump:
            joint = arm.limits.names[int(np.argmax(step))]
            return BranchPath(found.names[start], q[:i], i, f"joint {joint!r} would jump at pose {i}")
        q[i] = best
    return BranchPath(found.names[start], q, len(q), "")


def _free_joints_kept(arm: Arm, T: Array, near: Array, otherwise: Array) -> Array:
    """Where a joint is free, the solution nearest to where the joints were going: Newton's method, least steps."""
    rows = 6 if T.shape == (4, 4) else 3
    q = near
    for _ in range(8):
        J = arm.jacobian(q)[:rows]
        q = q + np.linalg.pinv(J, rcond=1e-6) @ pose_error(arm.fk(q), T, rows)
    return q if np.linalg.norm(pose_error(arm.fk(q), T, rows)) < REACHED else otherwise


def _best_turns(arm: Arm, path: BranchPath) -> BranchPath:
    """Whole turns that bring the middle of each joint's way nearest to the middle of its limits."""
    limits = arm.limits
    bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    middle = 0.5 * (path.q.min(0) + path.q.max(0))
    centre = 0.5 * (np.where(bounded, limits.lower, middle) + np.where(bounded, limits.upper, middle))
    return BranchPath(path.name, path.q + (_turned(arm, middle, centre) - middle), path.reached, path.reason)


def _within_limits(arm: Arm, path: BranchPath) -> BranchPath:
    """The path up to where a joint leaves its limits."""
    limits = arm.limits
    beyond = outside(path.q, limits.lower, limits.upper)
    if not beyond.any():
        return path
    i = int(np.argmax(beyond.any(1)))
    j = int(np.argmax(beyond[i]))
    reason = (
        f"joint {limits.names[j]!r} would leave its limits at pose {i}: {path.q[i, j]:.4g}; "
        f"they are {limits.lower[j]:.4g} to {limits.upper[j]:.4g}"
    )
    return BranchPath(path.name, path.q[:i], i, reason)
