"""The branch of a closed-form inverse that is nearest to given joints: what `Arm.ik_nearest` calls."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.errors import ShapeError
from holonom.mechanics.ik_result import IkNearest, IkStatus
from holonom.mechanics.inverse_geometry import UNREACHABLE
from holonom.mechanics.nearest_kernels import nearest_of_rows, nearest_one
from holonom.spatial import check_pose
from holonom.trace import real_array

if TYPE_CHECKING:
    from holonom.mechanics.arm import Arm

__all__ = ["Nearest", "joint_vectors"]

Array = NDArray[np.float64]
FREE = 1e-8
"""Singular value of the Jacobian below which a combination of joints moves nothing."""


def joint_vectors(name: str, q: ArrayLike, names: tuple[str, ...]) -> Array:
    """`q` as finite joint vectors (..., n).

    Raises
    ------
    ShapeError
        Another shape; something that is no finite number, named with its joint and row.
    """
    given = real_array(name, q)
    if given.shape[-1:] != (len(names),):
        raise ShapeError(f"{name} must be of shape (..., {len(names)}); shape {given.shape} came")
    if not np.isfinite(given).all():
        *row, k = (int(i) for i in np.argwhere(~np.isfinite(given))[0])
        place = f" in row {tuple(row)}" if row else ""
        raise ShapeError(f"{name}[{k}] (joint {names[k]!r}) is {given[(*row, k)]}{place}; finite numbers are needed")
    return given


class Nearest:
    """The nearest branch of one arm with a closed form, for many calls."""

    def __init__(self, arm: Arm) -> None:
        form, limits, moving = arm.closed_form, arm.limits, arm.model.independent
        assert form is not None
        turns = [2.0 * np.pi * (arm.model.joints[i].kind == "revolute") for i in moving]
        self._arm, self._names, self._rows = arm, form.names, 3 if form.task == "position" else 6
        self._joints = np.array([limits.lower, limits.upper, turns, np.ones(arm.n)])
        self._ndim = 1 if form.task == "position" else 2
        self._address = arm.kernel("inverse_geometry").address if form.exact else 0  # 0: branches are to be refined
        # What a call returns for a branch and its status, made once.
        self._branches = [np.int64(k) for k in range(len(form.names))]
        self._status = [np.int8(status) for status in IkStatus]

    def take(self, T: ArrayLike, q0: ArrayLike, weights: ArrayLike | None) -> IkNearest:
        """Arguments, result and errors as for `Arm.ik_nearest`."""
        joints = self._joints if weights is None else self._weighted(weights)
        q = np.empty(joints.shape[1])
        if not self._address or getattr(q0, "ndim", 0) != 1 or getattr(T, "ndim", 0) != self._ndim:
            return self._general(T, q0, joints)
        try:
            code = nearest_one(self._address, len(self._branches), T, q0, joints, q)  # type: ignore[arg-type]
        except TypeError:  # other numbers than floats, other layouts
            code = -1
        if code < 0:
            return self._general(T, q0, joints)
        if code & 3 == IkStatus.SINGULAR:
            q = self._kept(T, q, np.asarray(q0), np.asarray(True))
        elif code & 3 == UNREACHABLE and self._rows == 6:
            check_pose(T, "T")
        return tuple.__new__(IkNearest, (q, self._status[code & 3], self._branches[code >> 2], self._names))

    def _weighted(self, weights: ArrayLike) -> Array:
        n = self._joints.shape[1]
        weight = real_array("weights", weights)
        if weight.shape != (n,) or not (weight >= 0.0).all() or not np.isfinite(weight).all():
            raise ShapeError(f"weights must be {n} finite numbers, none negative; {weight} came")
        return np.concatenate([self._joints[:3], weight[None]])

    def _general(self, T: ArrayLike, q0: ArrayLike, joints: Array) -> IkNearest:
        """Rows of targets and of joints, which broadcast."""
        reference = joint_vectors("q0", q0, self._arm.limits.names)
        found = self._arm.ik(T)
        k, n = found.q.shape[-2:]
        try:
            lead = np.broadcast_shapes(found.q.shape[:-2], reference.shape[:-1])
        except ValueError:
            raise ShapeError(
                f"q0 {reference.shape} does not go with T: {found.q.shape[:-2]} targets; give one q0, or one for each"
            ) from None
        branches = _rows(found.q, (*lead, k, n)).reshape(-1, k, n)
        status = _rows(found.status, (*lead, k)).reshape(-1, k)
        start = _rows(reference, (*lead, n)).reshape(-1, n)
        q = np.empty(start.shape)
        taken, number = np.empty(len(start), np.int8), np.empty(len(start), np.int64)
        nearest_of_rows(branches, status, start, joints, q, taken, number)
        kept = self._kept(T, q.reshape(*lead, n), reference, (taken == IkStatus.SINGULAR).reshape(lead))
        return IkNearest(kept, taken.reshape(lead)[()], number.reshape(lead)[()], self._names)

    def _kept(self, T: ArrayLike, q: Array, reference: Array, singular: NDArray[np.bool_]) -> Array:
        """Singular branches with their free joints as in the reference, where that holds the target."""
        if not singular.any():
            return q
        arm, target = self._arm, np.asarray(T, dtype=float)
        _, s, Vt = np.linalg.svd(arm.jacobian(q)[..., : self._rows, :])
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


def _rows(a: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """An array broadcast, as compiled code takes it."""
    return np.require(np.broadcast_to(a, shape) if a.shape != shape else a, requirements=("C", "W"))
