"""Small dense linear algebra: singular values, eigenvalues, systems of equations.

===============  ============================================================
`svd`            singular values and vectors, compiled for small matrices
`small`          systems of equations over floats or traced scalars
`small_kernels`  the same in compiled loops
===============  ============================================================
"""

__all__: list[str] = []
