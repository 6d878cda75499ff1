"""Small systems of equations over scalars: floats, or those that are traced."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.trace import Number, absolute, less, select

__all__ = ["factor_ldl", "solve_factored", "solve_ldl", "solve_symmetric3"]

Vector = Sequence[Number]
Matrix = Sequence[Sequence[Number]]


def factor_ldl(B: Matrix) -> list[list[Number]]:
    """Factor a symmetric positive definite B = U D U^T, U with ones on its diagonal and zeros below.

    Row k is what stands above the diagonal in column k of U, then 1 / D[k]. Eliminated from the last row up: an arm's
    distal rows are the cheap ones, and zeros of B stay zeros.
    """
    A = [list(row) for row in B]
    factor: list[list[Number]] = [[] for _ in A]
    for k in reversed(range(len(A))):
        inverse = 1.0 / A[k][k]
        factor[k] = [*(A[k][i] * inverse for i in range(k)), inverse]
        for i in range(k):
            for j in range(i + 1):
                A[i][j] = A[i][j] - factor[k][i] * A[k][j]
    return factor


def solve_factored(factor: Matrix, b: Vector) -> list[Number]:
    """Solve B x = b, given `factor_ldl(B)`."""
    x = list(b)
    for i in reversed(range(len(x))):
        for k in reversed(range(i + 1, len(x))):
            x[i] = x[i] - factor[k][i] * x[k]
    for k, row in enumerate(factor):
        x[k] = x[k] * row[k]
        for i in range(k):
            x[k] = x[k] - row[i] * x[i]
    return x


def solve_ldl(B: Matrix, b: Vector) -> list[Number]:
    """Solve B x = b for a symmetric positive definite B."""
    return solve_factored(factor_ldl(B), b)


def solve_symmetric3(A: Matrix, b: Vector) -> tuple[list[Number], Number]:
    """Solution of A x = b by cofactors, A symmetric (3, 3), and the determinant (1.0 where that is 0)."""
    c00 = A[1][1] * A[2][2] - A[1][2] * A[1][2]
    c01 = A[0][2] * A[1][2] - A[0][1] * A[2][2]
    c02 = A[0][1] * A[1][2] - A[0][2] * A[1][1]
    c11 = A[0][0] * A[2][2] - A[0][2] * A[0][2]
    c12 = A[0][1] * A[0][2] - A[0][0] * A[1][2]
    c22 = A[0][0] * A[1][1] - A[0][1] * A[0][1]
    determinant = A[0][0] * c00 + A[0][1] * c01 + A[0][2] * c02
    inverse = 1.0 / select(less(absolute(determinant), 1e-300), 1.0, determinant)
    rows = ([c00, c01, c02], [c01, c11, c12], [c02, c12, c22])
    return [(row[0] * b[0] + row[1] * b[1] + row[2] * b[2]) * inverse for row in rows], determinant
