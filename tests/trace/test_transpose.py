"""Batches in vectors of every length and rows of every width: also those that other machines compile."""

import numpy as np
import pytest

from holonom.trace import compile


def _equation(a, b):
    return [3.0 * a[-1] + x for x in b], [*(x + 1.0 for x in a), -7.0]


@pytest.mark.parametrize("lanes", [2, 4, 8, 16])
@pytest.mark.parametrize("widths", [(1, 3), (5, 4), (7, 2)])
def test_rows_in_vectors_of_every_machine(lanes, widths, monkeypatch):
    """ARM and SSE have two doubles in a register, AVX four, AVX-512 eight; a vector fills one register or two."""
    monkeypatch.setattr("holonom.trace.text.emit.lanes_at_once", lambda operations: lanes)
    m, n = widths
    kernel = compile(_equation, {"a": m, "b": n}, {"y": n, "k": m + 1}, name="transpose", integers=("k",))
    rng = np.random.default_rng(3)
    for count in (1, lanes - 1, lanes, 2 * lanes + 1):
        a, b = rng.integers(-9, 9, (count, m)).astype(float), rng.normal(size=(count, n))
        y, k = kernel(a, b)
        np.testing.assert_allclose(y, 3.0 * a[:, -1:] + b, rtol=0.0, atol=1e-13)
        np.testing.assert_array_equal(k, np.column_stack([a + 1.0, np.full(count, -7.0)]))
