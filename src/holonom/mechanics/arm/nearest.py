"""The branch of a closed-form inverse that is nearest to given joints: what `Arm.ik_nearest` calls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, real_array, vectors
from holonom.errors import NotAPose, ShapeError
from holonom.mechanics.kernels.inverse.result import IkNearest, IkStatus
from holonom.mechanics.kernels.protocol import SolvedArm
from holonom.mechanics.loops.nearest import nearest_of_rows, nearest_point, nearest_pose
from holonom.spatial import check_pose
from holonom.trace import check_threads, share

__all__ = ["Nearest", "joint_vectors"]

CHUNK = 1024
"""Rows that are solved together, so that a batch takes little more memory than its result."""
FREE = 1e-8
"""Singular value of the Jacobian below which a combination of joints moves nothing."""


def joint_vectors(name: str, q: ArrayLike, names: tuple[str, ...]) -> Array:
    """`q` as finite joint vectors (..., n).

    Raises
    ------
    ShapeError
        Another shape; something that is no finite number, named with its joint and row.
    """
    return vectors(name, q, len(names), [f"joint {name!r}" for name in names])


STATUS: tuple[Any, ...] = tuple(np.int8(status) for status in IkStatus)
"""What a call returns for each status: the same object every time."""
UNREACHABLE, SINGULAR = STATUS[IkStatus.UNREACHABLE], STATUS[IkStatus.SINGULAR]


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
        self._one = nearest_point if form.task == "position" else nearest_pose
        q = np.empty(arm.n)
        branches: list[Any] = [np.int64(k) for k in range(len(form.names))]
        self._answers = tuple(IkNearest(q, status, k, form.names) for k in branches for status in STATUS)

    def take(self, T: ArrayLike, q0: ArrayLike, weights: ArrayLike | None, threads: int) -> IkNearest:
        """Arguments, result and errors as for `Arm.ik_nearest`."""
        joints = self._joints if weights is None else self._weighted(weights)
        found: IkNearest | None = None
        if self._address and threads == 1:
            found = self._one(self._address, len(self._names), T, q0, joints, self._answers)
        if found is None:  # rows of them, lists, other numbers than floats
            return self._general(T, q0, joints, check_threads(threads))
        status = found[1]
        if status is SINGULAR:
            return found._replace(q=self._kept(T, found.q, np.asarray(q0), np.asarray(True)))
        if status is UNREACHABLE and self._rows == 6:
            check_pose(T, "T")
        return found

    def _weighted(self, weights: ArrayLike) -> Array:
        n = self._joints.shape[1]
        weight = real_array("weights", weights)
        if weight.shape != (n,) or not (weight >= 0.0).all() or not np.isfinite(weight).all():
            raise ShapeError(f"weights must be {n} finite numbers, none negative; {weight} came")
        return np.concatenate([self._joints[:3], weight[None]])

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
        branches, status = self._arm.ik(T)[:2]
        start = np.require(reference, requirements=("C", "W"))
        q, taken, number = found
        nearest_of_rows(branches, status, start, joints, q, taken, number)
        q[:] = self._kept(T, q, reference, taken == IkStatus.SINGULAR)

    def _targets(self, T: ArrayLike) -> Array:
        """Targets of the right shape; whether they are poses is for `Arm.ik` to see."""
        try:
            target = real_array("T", T)
        except ShapeError:
            return check_pose(T, "T")
        if target.shape[-2:] == (4, 4) or (self._ndim == 1 and target.shape[-1:] == (3,)):
            return target
        return check_pose(target, "T")

    def _kept(self, T: ArrayLike, q: Array, reference: Array, singular: NDArray[np.bool_]) -> Array:
        """Singular branches with their free joints as in the reference, where that holds the target."""
        if not singular.any():
            return q
        from holonom.numeric.svd import svd  # compiled code, on first use

        arm, target = self._arm, np.asarray(T, dtype=float)
        _, s, Vt = svd(arm.jacobian(q)[..., : self._rows, :])
        spare = Vt.shape[-1] - s.shape[-1]
        s = np.concatenate([s, np.zeros((*s.shape[:-1], spare))], axis=-1)
        free = np.where(s[..., None] < FREE, Vt, 0.0)
        moved = q + np.einsum("...ki,...kj,...j->...i", free, free, reference - q)
        inside = ((moved >= arm.limits.lower) & (moved <= arm.limits.upper)).all(-1)
        reached = arm.fk(moved)
        if target.shape[-1] == 3:
            missed = np.abs(reached[..., :3, 3] - target).max(-1)
        elif self._rows == 3:
            missed = np.abs(reached - target)[..., :3, 3].max(-1)
        else:
            missed = np.abs(reached - target).max((-1, -2))
        return np.where((singular & inside & (missed < FREE))[..., None], moved, q)


def _rows(a: NDArray[Any], lead: tuple[int, ...], shape: tuple[int, ...]) -> NDArray[Any]:
    """An array broadcast to rows (N, ...), without a copy if it is one sample or all of them."""
    count = math.prod(lead)
    if a.shape == shape:
        return np.broadcast_to(a, (count, *shape))
    return np.broadcast_to(a, (*lead, *shape)).reshape(count, *shape)
