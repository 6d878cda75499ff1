"""Reaching a pose as a least-squares task: the pose error, its derivative, the normal matrix of a damped step.

The error is [p* - p; log(R* R^T)] along the world's axes, or [R^T (p* - p); log(R^T R*)] along the tool's.
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.kinematics import frames, jacobian
from holonom.mechanics.equations.vectors import (
    Matrix,
    Pose,
    Vector,
    add,
    cross,
    dot,
    matmul,
    scale,
    sub,
    transpose,
    tvec,
)
from holonom.model import ArmModel
from holonom.numeric.small import solve_ldl
from holonom.trace import Number, absolute, atan2, cos, less, select, sin, sqrt

__all__ = ["damped_multipliers", "pose_error", "pose_task", "rotation_vector"]

FLOOR = 1e-12
"""Least damping, as a share of the trace of the normal matrix: keeps rank-deficient arms solvable."""
TINY = 1e-30
"""Damping that remains where no joint is free."""


def rotation_vector(R: Matrix) -> list[Number]:
    """log(R): axis times angle in [0, pi]."""
    v, w = _half_turn(R)
    s = sqrt(dot(v, v))
    sign = select(less(w, 0.0), -2.0, 2.0)
    return scale(sign * atan2(s, absolute(w)) / select(less(0.0, s), s, 1.0), v)


def _half_turn(R: Matrix) -> tuple[list[Number], Number]:
    """A multiple of the unit quaternion (v, w), from its largest component: accurate near pi too (Shepperd 1978)."""
    a, b, c = R[0][0], R[1][1], R[2][2]
    x, y, z = R[2][1] - R[1][2], R[0][2] - R[2][0], R[1][0] - R[0][1]
    xy, yz, zx = R[0][1] + R[1][0], R[1][2] + R[2][1], R[2][0] + R[0][2]
    by_w: list[Number] = [x, y, z, 1.0 + a + b + c]
    by_x: list[Number] = [1.0 + a - b - c, xy, zx, x]
    by_y: list[Number] = [xy, 1.0 + b - c - a, yz, y]
    by_z: list[Number] = [zx, yz, 1.0 + c - a - b, z]
    x_over_z, y_over_z, x_over_y = less(c, a), less(c, b), less(b, a)
    turned = [
        select(x_over_y, select(x_over_z, p, r), select(y_over_z, q, r))
        for p, q, r in zip(by_x, by_y, by_z, strict=True)
    ]
    chosen = [select(less(0.0, a + b + c), p, q) for p, q in zip(by_w, turned, strict=True)]
    return chosen[:3], chosen[3]


def pose_error(goal: Pose, T: Pose, frame: str) -> tuple[list[Number], list[Number]]:
    """Position error and rotation vector from the pose T to the goal, along the axes of "world" or "tool"."""
    (R_goal, p_goal), (R, p) = goal, T
    off = sub(p_goal, p)
    if frame == "tool":
        return tvec(R, off), rotation_vector(matmul(transpose(R), R_goal))
    return off, rotation_vector(matmul(R_goal, transpose(R)))


def pose_task(model: ArmModel, q: Vector, goal: Vector, weights: Vector, frame: str, exact: bool) -> list[Number]:
    """The task at q: [squared residual; e (6); J^T (n, 6); lower triangle of J J^T (21)].

    `goal` holds the rows of [R* p*]. e and J are weighted; the residual counts the rows whose weight is not 0, as they
    are. J is the geometric Jacobian: minus the derivative of e once all rows count (the rotation's part turns e only
    about itself), and always if `exact`.
    """
    n = len(q)
    T = frames(model, q)[-1]
    e_p, e_r = pose_error(([goal[0:3], goal[4:7], goal[8:11]], [goal[3], goal[7], goal[11]]), T, frame)
    rows = jacobian(model, q, frame)
    columns = [[rows[n * i + k] for i in range(6)] for k in range(n)]
    if exact:
        columns = [_exact(column, e_p, e_r, frame) for column in columns]
    error = [*e_p, *e_r]
    residual: Number = 0.0
    for e, weight in zip(error, weights, strict=True):
        residual = residual + select(less(0.0, weight), e * e, 0.0)
    J = [[weight * x for weight, x in zip(weights, column, strict=True)] for column in columns]
    weighted = [weight * e for weight, e in zip(weights, error, strict=True)]
    normal = [dot([c[i] for c in J], [c[j] for c in J]) for i in range(6) for j in range(i + 1)]
    return [residual, *weighted, *(x for column in J for x in column), *normal]


def _exact(column: Vector, e_p: Vector, e_r: Vector, frame: str) -> list[Number]:
    """Minus the derivative of the error along a joint's twist [v; w].

    d log(R* R^T) = -Jr^-1 w, d log(R^T R*) = -Jl^-1 w, with Jr^-1, Jl^-1 = 1 +- [e]x / 2 + c [e]x^2 and
    c = (1 - h cot h) / 4 h^2, h = |e| / 2 (Chirikjian 2011, 10.6); R^T (p* - p) turns with the tool.
    """
    v, w = list(column[:3]), list(column[3:])
    square = dot(e_r, e_r)
    small = less(square, 1e-6)
    half = sqrt(select(small, 1.0, square)) * 0.5
    c = select(small, 1.0 / 12.0, (1.0 - half * _cotangent(half)) / select(small, 1.0, square))
    across = cross(e_r, w)
    turn = add(add(w, scale(-0.5 if frame == "tool" else 0.5, across)), scale(c, cross(e_r, across)))
    return [*(add(v, cross(w, e_p)) if frame == "tool" else v), *turn]


def _cotangent(x: Number) -> Number:
    return cos(x) / sin(x)


def damped_multipliers(normal: Vector, x: Sequence[Number], damping: Number) -> list[Number]:
    """y of (J J^T + damping) y = x, the step being J^T y; `normal` is the lower triangle of J J^T, row by row."""
    A: list[list[Number]] = [[normal[max(i, j) * (max(i, j) + 1) // 2 + min(i, j)] for j in range(6)] for i in range(6)]
    trace = A[0][0] + A[1][1] + A[2][2] + A[3][3] + A[4][4] + A[5][5]
    for i in range(6):
        A[i][i] = A[i][i] + (damping + FLOOR * trace + TINY)
    return solve_ldl(A, x)
