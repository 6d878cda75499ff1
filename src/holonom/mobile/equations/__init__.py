"""Equations of wheels and bases over plain scalars: they run on floats as their own reference and are traced.

================  ==========================================================
`wheels`          rolling and sliding row of one wheel
`base_models`     rows of a base and its inverse model at given steering
`steering`        angles of its steering, and its inverse model at those
`forward`         its forward model, by least squares
================  ==========================================================
"""

__all__: list[str] = []
