"""A traced equation over arrays equals the equation on floats, row by row, across chunks."""

import numpy as np

from holonom.trace import absolute, atan2, cos, less, less_equal, maximum, select, sin, sqrt
from holonom.trace.line.arrays import CHUNK, on_arrays


def equation(a, b):
    """One of every operation."""
    inside = less(a[0], b[0])
    far = less_equal(1.0, b[1])
    if not isinstance(inside, bool):
        inside, far = inside & far, inside | far
    else:
        inside, far = inside and far, inside or far
    return [
        select(inside, a[0] + b[1], a[0] - b[1]),
        select(far, -(a[1] * b[0]), a[1] / (2.0 + b[0] * b[0])),
        sin(a[0]) * cos(b[1]),
        sqrt(absolute(a[1])),
        atan2(a[0], b[0]),
        maximum(a[0], b[1]),
        3.0,
    ]


def test_arrays_equal_floats():
    rng = np.random.default_rng(0)
    a, b = rng.uniform(-2.0, 2.0, (2, 2 * CHUNK + 5, 2))
    expected = np.array([equation(x, y) for x, y in zip(a.tolist(), b.tolist(), strict=True)])
    found = on_arrays(equation, {"a": 2, "b": 2})(a, b)
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-15)
    assert on_arrays(equation, {"a": 2, "b": 2})(a[:0], b[:0]).shape == (0, 7)
