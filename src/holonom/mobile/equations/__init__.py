"""Equations of wheels and bases over plain scalars: they run on floats as their own reference and are traced.

================  ==========================================================
`wheels`          rolling and sliding row of one wheel
`base_models`     inverse and forward model of a base, angles of its steering
================  ==========================================================
"""

__all__: list[str] = []
