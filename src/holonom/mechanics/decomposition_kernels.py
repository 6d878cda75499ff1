"""The decompositions of `mechanics.analysis` at one configuration: from q to the result in one compiled call.

Each takes a plan (`plan_of`), and results to take after. It returns None if q is no such array of finite numbers; the
general way then says what is wrong with it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, njit
from numpy.typing import NDArray

from holonom.mechanics.singularity_kernels import rows_of
from holonom.mechanics.svd_kernels import ROOM, complete, decompose, room_for
from holonom.trace.direct import ArrayObject, array_of, direct, fits, scratch
from holonom.trace.pointer import call_kernel
from holonom.trace.results import Results, entry, exists, made_like, nothing

if TYPE_CHECKING:
    from holonom.mechanics.arm import Arm

__all__ = [
    "LOST",
    "PLAN",
    "ROOM",
    "ellipsoid_at",
    "given_jacobian",
    "lost_directions_at",
    "nullspace_at",
    "plan_of",
    "room_for",
    "singular_values_at",
]

Floats = NDArray[np.float64]
LOST = 1e-6
"""Singular value below which a direction counts as lost (m or 1 per rad)."""
PLAN = ArrayObject(int64, (4,))


def plan_of(arm: Arm, part: str = "all", frame: str = "world") -> NDArray[np.int64]:
    """Address of the arm's Jacobian in C form, count of joints, first row of the part, count of its rows."""
    rows = rows_of(part)
    return np.array([arm.kernel("jacobian", frame=frame).address, arm.n, rows.start, rows.stop - rows.start])


@njit(cache=True, error_model="numpy")
def given_jacobian(plan: Any, q: Floats, J: Floats) -> bool:
    """Write the Jacobian at q to the beginning of J (ROOM,), unless q is not finite or of another length."""
    n = plan[1]
    total = 0.0
    for x in q:
        total += x
    if q.shape[0] != n or not math.isfinite(total) or room_for(6, n) > ROOM:
        return False
    call_kernel(plan[0], q, J)
    return True


@njit(cache=True, error_model="numpy")
def _part(plan: Any, J: Floats) -> Floats:
    n, first, rows = plan[1], plan[2], plan[3]
    return J[n * first : n * (first + rows)].reshape(rows, n)


@njit(cache=True, error_model="numpy")
def _left(A: Floats, room: Floats, Ut: Floats, s: Floats) -> None:
    """Singular values s (k,) and left vectors of A (m, n), a row of Ut (m, m) each."""
    none = room[:0].reshape(0, 1)
    if A.shape[0] <= A.shape[1]:
        decompose(A, room, Ut, s, none)
    else:
        complete(Ut, decompose(A, room, none, s, Ut))


@njit(cache=True, error_model="numpy")
def _right(A: Floats, room: Floats, Vt: Floats, s: Floats) -> None:
    """Singular values s (k,) and right vectors of A (m, n), a row of Vt (n, n) each."""
    none = room[:0].reshape(0, 1)
    if A.shape[0] <= A.shape[1]:
        complete(Vt, decompose(A, room, none, s, Vt))
    else:
        decompose(A, room, Vt, s, none)


@njit(cache=True, error_model="numpy")
def _count(s: Floats, tolerance: float) -> int:
    count = 0
    for x in s:
        count += x > tolerance
    return count


_LIST, _TABLE = ArrayObject(float64, (None,)), ArrayObject(float64, (None, None))
_ELLIPSOID, _TABLES = Results([_TABLE, _LIST]), Results([_TABLE])


@njit(_LIST(PLAN, _LIST, _LIST), cache=True, error_model="numpy")
def _singular_values_at(plan: Any, q: Any, like: Any) -> Any:
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        none = room[:0].reshape(0, 1)
        decompose(_part(array_of(plan), J), room, none, array_of(result), none)
    return result


@njit(_ELLIPSOID(PLAN, _LIST, boolean, _ELLIPSOID), cache=True, error_model="numpy")
def _ellipsoid_at(plan: Any, q: Any, of_forces: bool, like: Any) -> Any:
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        A, axes, radii = _part(array_of(plan), J), array_of(entry(result, 0)), array_of(entry(result, 1))
        rows = A.shape[0]
        Ut = J[J.shape[0] - rows * rows :].reshape(rows, rows)
        radii[:] = 0.0
        _left(A, room, Ut, radii[: min(A.shape)])
        for i in range(rows):
            for j in range(rows):
                axes[j, rows - 1 - i if of_forces else i] = Ut[i, j]
        if of_forces:
            for i in range(rows):
                Ut[0, i] = radii[i]
            for i in range(rows):
                radii[rows - 1 - i] = 1.0 / Ut[0, i] if Ut[0, i] > LOST else np.inf
    return result


@njit(_TABLE(PLAN, _LIST, float64, _TABLES), cache=True, error_model="numpy")
def _lost_directions_at(plan: Any, q: Any, tolerance: float, likes: Any) -> Any:
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(entry(likes, 0))
    A = _part(array_of(plan), J)
    m = A.shape[0]
    basis = scratch(ROOM)
    Ut, s = basis[: m * m].reshape(m, m), basis[ROOM - min(A.shape) :]
    _left(A, room, Ut, s)
    kept = _count(s, tolerance)
    result = made_like(entry(likes, m - kept))
    if exists(result):
        found = array_of(result)
        for i in range(m - kept):
            for j in range(m):
                found[i, j] = Ut[kept + i, j]
    return result


@njit(_TABLE(PLAN, _LIST, float64, _TABLES), cache=True, error_model="numpy")
def _nullspace_at(plan: Any, q: Any, tolerance: float, likes: Any) -> Any:
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(entry(likes, 0))
    A = _part(array_of(plan), J)
    n = A.shape[1]
    if n * n + n > ROOM:
        return nothing(entry(likes, 0))
    basis = scratch(ROOM)
    Vt, s = basis[: n * n].reshape(n, n), basis[ROOM - min(A.shape) :]
    _right(A, room, Vt, s)
    kept = _count(s, tolerance)
    result = made_like(entry(likes, n - kept))
    if exists(result):
        found = array_of(result)
        for i in range(n - kept):
            for j in range(n):
                found[j, i] = Vt[kept + i, j]
    return result


singular_values_at: Any = direct(_singular_values_at)
"""`singular_values_at(plan, q, like)`: an array like the one given."""
ellipsoid_at: Any = direct(_ellipsoid_at)
"""`ellipsoid_at(plan, q, of_forces, like)`: axes and radii, in a tuple like the one given."""
lost_directions_at: Any = direct(_lost_directions_at)
"""`lost_directions_at(plan, q, tolerance, likes)`: (k, 6), an array like `likes[k]`."""
nullspace_at: Any = direct(_nullspace_at)
"""`nullspace_at(plan, q, tolerance, likes)`: (n, k), an array like `likes[k]`."""
