"""Singular values and vectors of small matrices: as `numpy.linalg.svd`, in a tenth of its time for Jacobians.

Compiled for matrices of up to six rows or columns, whatever the other count; LAPACK's beyond.
"""

from __future__ import annotations

import math

import numpy as np

from holonom.arrays import Array
from holonom.numeric.jacobi_kernels import MOST
from holonom.numeric.svd_kernels import svd_of_rows, values_of_rows

__all__ = ["singular_values", "svd"]

Three = tuple[Array, Array, Array]


def svd(A: Array) -> Three:
    """U, s, V^T of A (..., m, n): A = U diag(s) V^T, with U (..., m, m) and V^T (..., n, n) orthogonal.

    s (..., min(m, n)) is largest first, and NaN where A has NaN or infinity.
    """
    lead, (m, n) = A.shape[:-2], A.shape[-2:]
    if min(m, n) > MOST:
        return _of_lapack(A)
    count, k = math.prod(lead), min(m, n)
    U, s, Vt = np.empty((*lead, m, m)), np.empty((*lead, k)), np.empty((*lead, n, n))
    rows = np.ascontiguousarray(A).reshape(count, m, n)
    svd_of_rows(rows, U.reshape(count, m, m), s.reshape(count, k), Vt.reshape(count, n, n))
    return U, s, Vt


def singular_values(A: Array) -> Array:
    """Singular values (..., min(m, n)) of A (..., m, n), as `svd` gives them."""
    lead, (m, n) = A.shape[:-2], A.shape[-2:]
    if min(m, n) > MOST:
        return _of_lapack(A)[1]
    s = np.empty((*lead, min(m, n)))
    values_of_rows(np.ascontiguousarray(A).reshape(math.prod(lead), m, n), s.reshape(math.prod(lead), min(m, n)))
    return s


def _of_lapack(A: Array) -> Three:
    bad = ~np.isfinite(A)
    U, s, Vt = np.linalg.svd(np.where(bad, 0.0, A))
    s[bad.any((-1, -2))] = np.nan
    return U, s, Vt
