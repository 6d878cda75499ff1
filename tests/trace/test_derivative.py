"""Derivatives on the graph: both modes agree, equal finite differences, and stay sparse."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom import trace
from holonom.errors import UnknownName
from holonom.trace.derivative import along, jacobian, operations
from holonom.trace.line.graph import Graph, Scalar
from holonom.trace.line.straight import operand, straight_line

OPERATIONS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: trace.sin(a) * b,
    "/": lambda a, b: a / (b * b + 0.5),
    "neg": lambda a, _: -a,
    "sin": lambda a, _: trace.sin(a),
    "cos": lambda a, _: trace.cos(a),
    "atan2": lambda a, b: trace.atan2(a, b * b + 0.1),
    "sqrt": lambda a, _: trace.sqrt(a * a + 0.3),
    "abs": lambda a, _: trace.absolute(a),
    "select": lambda a, b: trace.select(trace.less(a, b + 0.123), a * b, b),
    "const": lambda a, _: a * 0.5 - 1.0,
}


def run(program, values):
    values = list(values)
    for op, i, j in program:
        values.append(OPERATIONS[op](values[i % len(values)], values[j % len(values)]))
    return values[-1]


def evaluate(graph, scalars, inputs):
    scope = {f"x_{k}": v for k, v in enumerate(inputs)} | {
        "math": math,
        "arctan2": math.atan2,
        "select": lambda c, a, b: a if c else b,
        "sqrt": math.sqrt,
        "sincos": lambda x: (math.sin(x), math.cos(x)),
    }
    scalars = [s if isinstance(s, Scalar) else graph.constant(s) for s in scalars]
    names = ", ".join(operand(graph, s.i) for s in scalars)
    exec("\n".join([*straight_line(graph, scalars), f"result = [{names}]"]), scope)
    return np.array(scope["result"])


@given(
    st.lists(
        st.tuples(st.sampled_from(sorted(OPERATIONS)), st.integers(0, 30), st.integers(0, 30)), min_size=1, max_size=30
    ),
    st.integers(0, 99),
)
def test_derivatives_of_random_programs(program, seed):
    x = np.random.default_rng(seed).uniform(-2.0, 2.0, 3)
    graph = Graph()
    inputs = [graph.input("x", k) for k in range(3)]
    y = run(program, inputs)
    forward, reverse = (evaluate(graph, jacobian([y], inputs, mode)[0], x) for mode in ("forward", "reverse"))
    np.testing.assert_allclose(forward, reverse, rtol=1e-9, atol=1e-9 * max(1.0, np.abs(forward).max()))
    direction = [0.3, -0.7, 0.2]
    np.testing.assert_allclose(
        evaluate(graph, along([y], inputs, direction), x), [forward @ direction], rtol=1e-9, atol=1e-9
    )
    h = 1e-6
    steps = [(run(program, x + e), run(program, x), run(program, x - e)) for e in h * np.eye(3)]
    slopes = np.array([((a - b) / h, (b - c) / h) for a, b, c in steps])
    smooth = np.abs(slopes[:, 0] - slopes[:, 1]) < 1e-3 * (1.0 + np.abs(slopes[:, 0]))  # no corner within the step
    np.testing.assert_allclose(forward[smooth], slopes.mean(1)[smooth], rtol=2e-3, atol=2e-3)


def test_rules_one_by_one():
    graph = Graph()
    x, y = graph.input("x", 0), graph.input("x", 1)
    at = (0.7, -1.3)
    rules = [
        (x * y, (at[1], at[0])),
        (x / y, (1 / at[1], -at[0] / at[1] ** 2)),
        (trace.sqrt(x), (0.5 / math.sqrt(at[0]), 0.0)),
        (trace.sin(x), (math.cos(at[0]), 0.0)),
        (trace.cos(x), (-math.sin(at[0]), 0.0)),
        (trace.atan2(y, x), (-at[1] / (at[0] ** 2 + at[1] ** 2), at[0] / (at[0] ** 2 + at[1] ** 2))),
        (trace.absolute(y), (0.0, -1.0)),
        (trace.select(trace.less(x, y), x, y * 2.0), (0.0, 2.0)),
        (2.0 - x, (-1.0, 0.0)),
    ]
    for mode in ("forward", "reverse", "best"):
        for expression, expected in rules:
            (row,) = jacobian([expression], [x, y], mode)
            np.testing.assert_allclose(evaluate(graph, row, at), expected, rtol=1e-15)


def test_what_does_not_depend_is_the_number_zero():
    graph = Graph()
    x, y = graph.input("x", 0), graph.input("x", 1)
    rows = jacobian([trace.sin(x), 3.0, y * y], [x, y], "forward")
    assert rows[0][1] == rows[1][0] == rows[1][1] == rows[2][0] == 0.0
    assert operations([rows[0][0]]) == 1
    assert jacobian([x], [], "reverse") == [[]]


def test_an_intermediate_value_may_be_the_variable():
    graph = Graph()
    x = graph.input("x", 0)
    speed = trace.sin(x)
    for mode in ("forward", "reverse"):
        ((slope,),) = jacobian([speed * speed], [speed], mode)
        np.testing.assert_allclose(evaluate(graph, [slope], [0.4]), [2 * math.sin(0.4)])


def test_best_is_the_shorter_one():
    graph = Graph()
    x = [graph.input("x", k) for k in range(8)]
    y = [trace.sin(x[0] * x[1] * x[2] * x[3] * x[4] * x[5] * x[6] * x[7])]
    counts = [operations([e for row in jacobian(y, x, mode) for e in row]) for mode in ("forward", "reverse", "best")]
    assert counts[2] == min(counts)
    assert counts[1] < counts[0]


def test_an_unknown_mode_is_named():
    with pytest.raises(UnknownName, match="reverse"):
        jacobian([], [], "backward")
