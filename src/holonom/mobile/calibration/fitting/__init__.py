"""Least squares over whole paths: residuals, pieces, deviations, limits of errors, what the data sheet adds."""

__all__: list[str] = []
