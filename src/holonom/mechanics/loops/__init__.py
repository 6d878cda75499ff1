"""Compiled loops with branches over any arm's kernels: solvers, decompositions, integration."""

__all__: list[str] = []
