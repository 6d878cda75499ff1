"""Vectors and matrices of scalars, as plain lists: the letters of the textbooks, for floats and for traced scalars."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.trace import Number

__all__ = [
    "Matrix",
    "Pose",
    "Vector",
    "add",
    "columns",
    "compose",
    "cross",
    "dot",
    "matmul",
    "matvec",
    "scale",
    "sub",
    "transpose",
    "tvec",
]

Vector = Sequence[Number]
Matrix = Sequence[Sequence[Number]]
Pose = tuple[Matrix, Vector]
"""(R, p): rotation rows and position."""


def add(a: Vector, b: Vector) -> list[Number]:
    """a + b."""
    return [x + y for x, y in zip(a, b, strict=True)]


def sub(a: Vector, b: Vector) -> list[Number]:
    """a - b."""
    return [x - y for x, y in zip(a, b, strict=True)]


def scale(k: Number, a: Vector) -> list[Number]:
    """k a."""
    return [k * x for x in a]


def dot(a: Vector, b: Vector) -> Number:
    """a . b."""
    total: Number = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> list[Number]:
    """a x b."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def transpose(A: Matrix) -> list[list[Number]]:
    """A^T."""
    return [list(column) for column in zip(*A, strict=True)]


def columns(A: Matrix) -> list[list[Number]]:
    """Columns of A."""
    return transpose(A)


def matvec(A: Matrix, v: Vector) -> list[Number]:
    """A v."""
    return [dot(row, v) for row in A]


def tvec(A: Matrix, v: Vector) -> list[Number]:
    """A^T v."""
    return [dot(column, v) for column in zip(*A, strict=True)]


def matmul(A: Matrix, B: Matrix) -> list[list[Number]]:
    """A B."""
    return [[dot(row, column) for column in zip(*B, strict=True)] for row in A]


def compose(X: Pose, Y: Pose) -> Pose:
    """Pose product: T_ac = T_ab T_bc."""
    return matmul(X[0], Y[0]), add(X[1], matvec(X[0], Y[1]))
