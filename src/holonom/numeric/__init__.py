"""Small dense linear algebra in compiled code: singular values, eigenvalues."""

__all__: list[str] = []
