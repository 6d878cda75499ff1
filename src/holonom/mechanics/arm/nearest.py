"""The branch of a closed-form inverse that is nearest to given joints: what `Arm.ik_nearest` calls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, angles, real_array
from holonom.errors import NotAPose, ShapeError
from holonom.mechanics.arm.members import Reference, approached, nearest_members, whole_turns
from holonom.mechanics.kernels.inverse.geometry import pose_error
from holonom.mechanics.kernels.inverse.result import IkNearest, IkResult, IkStatus
from holonom.mechanics.kernels.protocol import SolvedArm
from holonom.mechanics.loops.nearest import LOCAL, NEAR, STATUSES, STEEP, nearest_of_rows, nearest_point, nearest_pose
from holonom.model import outside
from holonom.spatial import check_pose
from holonom.trace import check_threads, share

__all__ = ["Nearest", "joint_vectors", "joint_weights"]

CHUNK = 1024
"""Rows that are solved together, so that a batch takes little more memory than its result."""


def joint_vectors(name: str, q: ArrayLike, names: tuple[str, ...]) -> Array:
    """`q` as finite joint vectors (..., n).

    Raises
    ------
    ShapeError, NotFinite, OutOfLimits
        Another shape; something that is no finite number, or an angle beyond 1e15 rad, named with its joint and row.
    """
    return angles(name, q, len(names), [f"joint {name!r}" for name in names])


def joint_weights(weights: ArrayLike | None, n: int) -> Array:
    """What a joint's difference counts (n,); 1 unless given."""
    if weights is None:
        return np.ones(n)
    weight = real_array("weights", weights)
    if weight.shape != (n,) or not (weight >= 0.0).all() or not np.isfinite(weight).all():
        raise ShapeError(f"weights must be {n} finite numbers, none negative; {weight} came")
    return weight


STATUS: tuple[Any, ...] = tuple(np.int8(status) for status in IkStatus)
"""What a call returns for each status: the same object every time."""
UNREACHABLE = STATUS[IkStatus.UNREACHABLE]
REACHED_WELL = (IkStatus.OK, IkStatus.SINGULAR)


class Nearest:
    """The nearest branch of one arm with a closed form, for many calls."""

    def __init__(self, arm: SolvedArm) -> None:
        form, limits, moving = arm.closed_form, arm.limits, arm.model.independent
        assert form is not None
        turns = [2.0 * np.pi * arm.model.joints[i].turns for i in moving]
        self._arm, self._names, self._rows = arm, form.names, 3 if form.task == "position" else 6
        self._joints = np.array([limits.lower, limits.upper, turns, np.ones(arm.n)])
        self._ndim = 1 if form.task == "position" else 2
        self._address = arm.kernel("inverse_geometry").address if form.exact else 0  # else branches are to be refined
        self._forward = arm.kernel("fk").address if form.exact else 0
        self._one = nearest_point if form.task == "position" else nearest_pose
        q = np.empty(arm.n)
        branches: list[Any] = [np.int64(k) for k in range(len(form.names))]
        self._answers = tuple(IkNearest(q, status, k, form.names) for k in branches for status in STATUS[:STATUSES])

    def take(self, T: ArrayLike, q0: ArrayLike, weights: ArrayLike | None, threads: int) -> IkNearest:
        """Arguments, result and errors as for `Arm.ik_nearest`."""
        joints = self._joints
        if weights is not None:
            joints = np.concatenate([joints[:3], joint_weights(weights, self._arm.n)[None]])
        found: IkNearest | None = None
        if self._address and threads == 1:
            found = self._one(self._address, self._forward, len(self._names), T, q0, joints, self._answers)
        if found is None:  # rows of them, lists, other numbers than floats
            return self._general(T, q0, joints, check_threads(threads))
        if found[1] is UNREACHABLE and self._rows == 6:
            check_pose(T, "T")
        return found

    def _general(self, T: ArrayLike, q0: ArrayLike, joints: Array, threads: int) -> IkNearest:
        """Rows of targets and of joints, which broadcast."""
        reference = joint_vectors("q0", q0, self._arm.limits.names)
        target = self._targets(T)
        axes = 1 if target.shape[-1] == 3 else 2
        try:
            lead = np.broadcast_shapes(target.shape[:-axes], reference.shape[:-1])
        except ValueError:
            raise ShapeError(
                f"q0 {reference.shape} does not go with T: {target.shape[:-axes]} targets; give one q0, or one for each"
            ) from None
        targets = _rows(target, lead, target.shape[-axes:])
        references = _rows(reference, lead, reference.shape[-1:])
        q, count = np.empty((*lead, reference.shape[-1])), len(references)
        taken, number = np.empty(lead, np.int8), np.empty(lead, np.int64)
        flat = q.reshape(count, -1), taken.reshape(count), number.reshape(count)
        firsts = range(0, count, CHUNK)
        waiting = iter(firsts)

        def worker(_: int) -> None:
            for first in waiting:  # whoever is free takes the next rows
                part = slice(first, first + CHUNK)
                self._choose(targets[part], references[part], joints, [a[part] for a in flat])

        try:
            share(worker, max(1, min(threads, len(firsts))))
        except NotAPose:
            check_pose(target, "T")  # counts from the first target
            raise
        return IkNearest(q, taken[()], number[()], self._names)

    def _choose(self, T: Array, reference: Array, joints: Array, found: Sequence[NDArray[Any]]) -> None:
        """Write joints, status and number of the nearest branch for rows."""
        solved = self._arm.ik(T)
        start = np.require(reference, requirements=("C", "W"))
        q, taken, number = found
        nearest_of_rows(solved.q, solved.status, start, joints, q, taken, number)
        free = np.flatnonzero(number < 0)
        if len(free):
            some = IkResult(solved.q[free], solved.status[free], solved.names)
            to = Reference(start[free], *joints)
            q[free], taken[free], number[free] = self._choose_free(T[free], some, to)
        inside = ~outside(start, *joints[:2]).any(-1)
        far = np.flatnonzero(inside & (np.abs(q - start).max(-1) > NEAR))
        missed = np.abs(self._misses(start[far], T[far])).max(-1, initial=0.0)
        far = far[(missed < LOCAL) & (np.abs(q[far] - start[far]).max(-1) > STEEP * missed)]
        if len(far):
            q[far], taken[far] = self._approached(T[far], q[far], taken[far], Reference(start[far], *joints))

    def _targets(self, T: ArrayLike) -> Array:
        """Targets of the right shape; whether they are poses is for `Arm.ik` to see."""
        try:
            target = real_array("T", T)
        except ShapeError:
            return check_pose(T, "T")
        if target.shape[-2:] == (4, 4) or (self._ndim == 1 and target.shape[-1:] == (3,)):
            return target
        return check_pose(target, "T")

    def _choose_free(self, T: Array, found: IkResult, to: Reference) -> tuple[Array, NDArray[Any], NDArray[np.intp]]:
        """Joints, status and number of the nearest solution for rows in which a joint is free in some branch."""
        rows = len(found.status)
        reached, free = found.status != IkStatus.UNREACHABLE, found.status >= IkStatus.SINGULAR
        owner, branch = np.nonzero(free)
        q = self._turned(found.q, to)
        beyond = (found.status == IkStatus.LIMIT).astype(float)
        q[owner, branch], beyond[owner, branch] = nearest_members(self._arm, T, found.q[owner, branch], owner, to)
        rank = np.where(reached, beyond > 0.0, 2)
        apart = (to.weights * np.abs(q - to.q0[:, None])).max(-1)
        number = np.lexsort((np.round(apart, 12), rank))[..., 0] if rows else np.empty(0, np.intp)
        row = np.arange(rows)
        status = np.where(beyond > 0.0, IkStatus.LIMIT, np.where(free, IkStatus.SINGULAR, found.status))
        return q[row, number], status[row, number], number

    def _misses(self, q: Array, T: Array) -> Array:
        """By what joints (N, n) miss their targets (N, rows)."""
        goal = T[:, :3, 3] if self._rows == 3 and T.ndim == 3 else T
        return pose_error(self._arm.fk(q), goal, self._rows)

    def _approached(self, T: Array, q: Array, taken: NDArray[Any], to: Reference) -> tuple[Array, NDArray[np.int8]]:
        """What is reached from the reference, where that is nearer than the branch that was taken (q, status)."""
        found, reached, singular = approached(self._arm, T, q, to)
        good = reached & (to.violation(found) == 0.0)
        better = good & ((to.distance(found) < to.distance(q) - NEAR) | ~np.isin(taken, REACHED_WELL))
        status = np.where(singular, IkStatus.SINGULAR, IkStatus.OK)
        return np.where(better[:, None], found, q), np.where(better, status, taken).astype(np.int8)

    def _turned(self, q: Array, to: Reference) -> Array:
        return whole_turns(q, to.q0[:, None], to.lower, to.upper, to.turns)


def _rows(a: NDArray[Any], lead: tuple[int, ...], shape: tuple[int, ...]) -> NDArray[Any]:
    """An array broadcast to rows (N, ...), without a copy if it is one sample or all of them."""
    count = math.prod(lead)
    if a.shape == shape:
        return np.broadcast_to(a, (count, *shape))
    return np.broadcast_to(a, (*lead, *shape)).reshape(count, *shape)
