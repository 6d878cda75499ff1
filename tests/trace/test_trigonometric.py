"""Multiplied-out equations: identities of the angle become equal terms, and what is no polynomial is refused."""

import pytest

from holonom.errors import InputError
from holonom.trace import Graph, cos, sin, sqrt
from holonom.trace.line.trigonometric import multiplied_out

VARIABLES = [("q", 0), ("q", 1), ("m", 0)]


def expanded(equation):
    graph = Graph()
    found = equation(graph.input("q", 0), graph.input("q", 1), graph.input("m", 0))
    return multiplied_out(graph, [found], VARIABLES)[0]


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (lambda p, q, m: m * (sin(p) * sin(p)) + m * (cos(p) * cos(p)), lambda p, q, m: m),
        (lambda p, q, m: sin(p) * cos(q) + cos(p) * sin(q), lambda p, q, m: sin(p + q)),
        (lambda p, q, m: 2.0 * (cos(p) * cos(p)), lambda p, q, m: cos(2.0 * p) + 1.0),
        (lambda p, q, m: (m * p) * cos(q + 1.5707963267948966), lambda p, q, m: -(sin(q) * p) * m),
        (lambda p, q, m: (p + q) * (p - q) / m, lambda p, q, m: p * (p / m) - q * (q / m)),
    ],
    ids=["pythagoras", "sum", "double", "offset", "quotient"],
)
def test_identities(left, right):
    a, b = expanded(left), expanded(right)
    small = {term for p in (a, b) for term, c in p.items() if abs(c) < 1e-15}
    assert set(a) - small == set(b) - small
    assert all(abs(a[term] - b[term]) < 1e-15 for term in set(a) - small)


@pytest.mark.parametrize(
    ("equation", "message"),
    [
        (lambda p, q, m: p / (q + m), "a formula with '/'"),
        (lambda p, q, m: sqrt(p), "a formula with 'sqrt'"),
        (lambda p, q, m: sin(p * q), "not linear"),
        (lambda p, q, m: cos(sin(p)), "not linear"),
    ],
)
def test_what_cannot_be_multiplied_out(equation, message):
    with pytest.raises(InputError, match=message):
        expanded(equation)
