"""The inverse geometry of an arm as one equation: branches of its closed form, proved by its forward kinematics."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.inverse.subproblems import Branch, Truth, Turn
from holonom.mechanics.equations.vectors import Matrix, Pose, Vector, compose, dot, matmul, matvec, sub, transpose
from holonom.mechanics.kernels.inverse.closed_form import ClosedForm
from holonom.model import LIMIT_TOLERANCE, ArmModel, JointLimits, outside
from holonom.spatial.poses import RIGID
from holonom.trace import Kernel, Number, absolute, atan2, compile, less, select

__all__ = [
    "LIMIT",
    "OK",
    "REACHED",
    "SINGULAR",
    "SINGULAR_LIMIT",
    "UNREACHABLE",
    "inverse_geometry",
    "inverse_kernel",
    "pose_error",
    "refined",
    "repeated",
]


OK, UNREACHABLE, LIMIT, SINGULAR, SINGULAR_LIMIT = 0, 1, 2, 3, 4
REACHED = 1e-8
"""Root of the sum of squares of T(q) - T (m, and the rotation's entries) up to which a branch has reached the pose."""
REFINEMENTS, LARGEST = 30, 0.5
"""Newton steps of a branch that is to be refined, at most, and the largest change of a joint in one (rad or m)."""
DAMPING = 0.03
"""Of its steps, per square of the error (Chan & Lawrence 1988)."""
KICKS, SAME = (0.05, -0.05, 0.8, -0.8, 1.6, -1.6, 2.4, -2.4, 3.1), 1e-6
"""By what such a branch is moved where it meets another one (rad), and the difference up to which two are the same."""
REFINED = 1e-9
"""As `REACHED`, of a branch that is refined."""
DEPARTED = 1e3
"""How much further a branch that is still to be refined may miss, per departure of the axes from the closed form's."""


def inverse_geometry(model: ArmModel, form: ClosedForm, target: Vector) -> tuple[list[Number], list[Number]]:
    """All branches for T_wt (16 numbers, row by row), or for p_wt (3) of a position task: joints (k n), status (k).

    The rotation is first made orthonormal (one Newton step: 1e-6 becomes 1e-12). A branch that forward kinematics does
    not prove is UNREACHABLE; it holds the joints that come nearest in its own way. So are all branches of what is no
    pose, to the tolerance of `spatial.check_pose`: whoever finds none reached asks that for the reason.
    """
    refused: Truth = False
    if form.task == "position":
        found = form.branches(_into(form.chain.before, target))
        goal = list(target)
    else:
        R, departs = _orthonormal([target[4 * i : 4 * i + 3] for i in range(3)])
        p = [target[3], target[7], target[11]]
        refused = departs | _last_row_departs(target[12:])
        found = form.branches(_motion(form, (R, p)))
        goal = kinematics.flat_pose((R, p))[:12]
    reached = REACHED if form.exact else REACHED + DEPARTED * form.chain.departure
    joints: list[Number] = []
    status: list[Number] = []
    for branch in found:
        q = _joints(model, form, branch)
        T = kinematics.pose(model, q, None)
        missing = sub(T[:12] if len(goal) == 12 else [T[3], T[7], T[11]], goal)
        joints += q
        missed = refused | less(reached * reached, dot(missing, missing))
        status.append(_status(model, q, missed, branch.free))
    return joints, status


def inverse_kernel(model: ArmModel, form: ClosedForm, result: Callable[[Array, NDArray[np.int8]], Any]) -> Kernel:
    """The compiled equation, and what a call makes of the branches and their status."""
    k, n = len(form.names), len(model.joints)
    inputs = {"p": 3} if form.task == "position" else {"T": (4, 4)}
    return compile(
        lambda target: inverse_geometry(model, form, target),
        inputs,
        {"q": (k, n), "status": k},
        name=f"{model.name}_inverse_geometry",
        integers=("status",),
        branches=True,
        result=result,
    )


def _orthonormal(R: Matrix) -> tuple[Matrix, Truth]:
    """(3 - R R^T) R / 2, the rotation nearest to R if R is nearly one, and whether it is not.

    A mirror passes here, and fails the proof: what forward kinematics gives turns.
    """
    square = matmul(R, transpose(R))
    departs: Truth = False
    for i in range(3):
        for j in range(i + 1):
            departs = departs | less(RIGID, absolute(square[i][j] - (1.0 if i == j else 0.0)))
    half = [[(1.5 if i == j else 0.0) - 0.5 * square[i][j] for j in range(3)] for i in range(3)]
    return matmul(half, R), departs


def _last_row_departs(row: Vector) -> Truth:
    x, y, z, one = row
    return less(0.0, absolute(x) + absolute(y) + absolute(z) + absolute(one - 1.0))


def _into(frame: Sequence[Sequence[float]], p: Vector) -> list[Number]:
    R, origin = kinematics.split(frame)  # type: ignore[arg-type]
    return matvec(transpose(R), sub(p, origin))


def _motion(form: ClosedForm, T: Pose) -> Pose:
    """G = before^-1 T home^-1."""
    R, p = compose(_inverted(kinematics.split(form.chain.before)), T)
    return compose((R, p), _inverted(kinematics.split(form.chain.home)))


def _inverted(T: Pose) -> Pose:
    R, p = T
    back = transpose(R)
    return back, [-x for x in matvec(back, p)]


def _joints(model: ArmModel, form: ClosedForm, branch: Branch) -> list[Number]:
    """The model's joints, wrapped into their limits where whole turns allow it."""
    q = []
    for joint, reference, value in zip(model.joints, form.chain.reference, branch.values, strict=True):
        if isinstance(value, Turn):
            q.append(_wrapped(atan2(value.s, value.c) + reference, joint.limits))
        else:
            q.append(value)
    return q


def _wrapped(q: Number, limits: JointLimits) -> Number:
    """Bring an angle of less than two turns within half a turn of the middle of its limits."""
    finite = math.isfinite(limits.lower) and math.isfinite(limits.upper)
    middle = 0.5 * (limits.lower + limits.upper) if finite else 0.0
    turns = 2.0 * math.pi * round(middle / (2.0 * math.pi))
    q = select(less(math.pi, q), q - 2.0 * math.pi, q)
    q = select(less(q, -math.pi), q + 2.0 * math.pi, q) + turns
    up, down = q + 2.0 * math.pi, q - 2.0 * math.pi
    if math.isfinite(limits.lower) and limits.upper > turns + math.pi:
        q = select(less(q, limits.lower) & _below(up, limits.upper), up, q)
    if math.isfinite(limits.upper) and limits.lower < turns - math.pi:
        q = select(less(limits.upper, q) & _below(-down, -limits.lower), down, q)
    return q


def _below(q: Number, bound: float) -> Truth:
    return less(q, bound) if math.isfinite(bound) else True


def _status(model: ArmModel, q: Vector, missed: Truth, free: Truth) -> Number:
    beyond: Truth = False
    for joint, v in zip(model.joints, q, strict=True):
        for bound, sign in ((joint.limits.lower, 1.0), (joint.limits.upper, -1.0)):
            if math.isfinite(bound):
                beyond = beyond | less(sign * v, sign * bound - LIMIT_TOLERANCE)
    inside, out = select(free, SINGULAR, OK), select(free, SINGULAR_LIMIT, LIMIT)
    return select(missed, UNREACHABLE, select(beyond, out, inside))


def refined(
    fk: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    limits: tuple[Array, Array],
    task: str,
    target: Array,
    q: Array,
    status: NDArray[np.int8],
) -> tuple[Array, NDArray[np.int8]]:
    """Branches of an arm that is only nearly what its closed form takes it for, after a few Newton steps.

    target (..., 4, 4) or (..., 3); q (..., k, n); status (..., k).
    """
    rows = 3 if task == "position" else 6
    lead, (k, n) = q.shape[:-2], q.shape[-2:]
    goal = np.asarray(target).reshape(-1, *target.shape[len(lead) :])
    first, code = q.reshape(-1, k, n), status.reshape(-1, k)
    better, reached = np.empty_like(first), np.empty(code.shape, dtype=bool)

    def improve(start: Array, row: NDArray[np.intp]) -> tuple[Array, NDArray[np.bool_]]:
        """Joints (m, n) after Newton's method for the targets of some rows, and whether they reach them."""
        at = start
        for _ in range(REFINEMENTS):
            J, error = jacobian(at)[:, :rows], pose_error(fk(at), goal[row], rows)
            JT, damping = np.swapaxes(J, -1, -2), DAMPING * (error**2).sum(-1) + 1e-15
            step = (JT @ np.linalg.solve(J @ JT + damping[:, None, None] * np.eye(rows), error[..., None]))[..., 0]
            at = at + step * np.minimum(1.0, LARGEST / np.maximum(np.abs(step).max(-1, keepdims=True), 1e-300))
            if np.abs(step).max(initial=0.0) < 1e-13:
                break
        return at, np.linalg.norm(pose_error(fk(at), goal[row], rows), axis=-1) < REFINED

    every = np.repeat(np.arange(len(first)), k)
    found, fine = improve(first.reshape(-1, n), every)
    better[:], reached[:] = found.reshape(-1, k, n), fine.reshape(-1, k) & (code != UNREACHABLE)
    for kick in KICKS:  # where branches nearly meet, or a joint is free, the nominal arm's may be one, or none
        row, branch = np.nonzero(~reached | repeated(better, reached))
        if not len(row):
            break
        start = first[row, branch]
        loose = np.linalg.svd(jacobian(start)[:, :rows])[2][:, -1]
        found, fine = improve(start + kick * loose / np.abs(loose).max(-1, keepdims=True), row)
        for r, b in zip(row[fine], branch[fine], strict=True):
            own = found[(row == r) & (branch == b)][0]
            apart = np.abs(_less_turns(better[r] - own)).max(-1)
            if not (reached[r] & (apart < SAME)).any():
                better[r, b], reached[r, b] = own, True
    better = np.where(reached[..., None], better, first)
    beyond = outside(better, *limits).any(-1)
    free = (code == SINGULAR) | (code == SINGULAR_LIMIT)
    rest = np.where(beyond, np.where(free, SINGULAR_LIMIT, LIMIT), np.where(free, SINGULAR, OK))
    return better.reshape(q.shape), np.where(reached, rest, UNREACHABLE).astype(np.int8).reshape(status.shape)


def repeated(q: Array, reached: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a branch (..., k) of joints (..., k, n) is an earlier reached one again."""
    apart = _less_turns(q[..., :, None, :] - q[..., None, :, :])
    same = np.abs(apart).max(-1) < SAME
    return np.asarray(
        (same & reached[..., None, :] & reached[..., :, None] & np.tri(q.shape[-2], k=-1, dtype=bool)).any(-1)
    )


def _less_turns(apart: Array) -> Array:
    return np.asarray(apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi)))


def pose_error(T: Array, goal: Array, rows: int) -> Array:
    """Place, and for six rows sine of the angle times the axis, that T still has to go: (..., rows)."""
    if rows == 3:
        return np.asarray(goal - T[..., :3, 3])
    W = goal[..., :3, :3] @ np.swapaxes(T[..., :3, :3], -1, -2)
    turn = 0.5 * np.stack([W[..., 2, 1] - W[..., 1, 2], W[..., 0, 2] - W[..., 2, 0], W[..., 1, 0] - W[..., 0, 1]], -1)
    return np.concatenate([goal[..., :3, 3] - T[..., :3, 3], turn], -1)
