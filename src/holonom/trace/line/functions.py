"""Functions that work on floats and on traced scalars alike; an equation written with them is its own reference."""

from __future__ import annotations

import math

from holonom.trace.line.graph import Condition, Number, Scalar

__all__ = [
    "absolute",
    "atan2",
    "copysign",
    "cos",
    "floor",
    "less",
    "less_equal",
    "maximum",
    "minimum",
    "select",
    "sin",
    "sqrt",
]


def _unary(name: str, x: Scalar) -> Scalar:
    return Scalar(x.graph, x.graph.add(name, x.i))


def _pair(a: Number, b: Number) -> tuple[Scalar, Scalar]:
    """Return both as scalars of the graph that at least one of them belongs to."""
    graph = a.graph if isinstance(a, Scalar) else b.graph  # type: ignore[union-attr]
    p = a if isinstance(a, Scalar) else graph.constant(float(a))
    return p, b if isinstance(b, Scalar) else graph.constant(float(b))


def sin(x: Number) -> Number:
    """Sine of an angle in rad."""
    if not isinstance(x, Scalar):
        return math.sin(x)
    return math.sin(x.value) if x.value is not None else _unary("sin", x)


def cos(x: Number) -> Number:
    """Cosine of an angle in rad."""
    if not isinstance(x, Scalar):
        return math.cos(x)
    return math.cos(x.value) if x.value is not None else _unary("cos", x)


def sqrt(x: Number) -> Number:
    """Square root; NaN below zero (guard with `maximum(x, 0.0)`)."""
    if not isinstance(x, Scalar):
        return math.sqrt(x) if x >= 0.0 else math.nan
    return math.sqrt(x.value) if x.value is not None else _unary("sqrt", x)


def absolute(x: Number) -> Number:
    """Magnitude."""
    if not isinstance(x, Scalar):
        return abs(x)
    return abs(x.value) if x.value is not None else _unary("abs", x)


def floor(x: Number) -> Number:
    """The largest whole number that is not above x."""
    if not isinstance(x, Scalar):
        return float(math.floor(x)) if math.isfinite(x) else x
    return float(math.floor(x.value)) if x.value is not None else _unary("floor", x)


def copysign(a: Number, b: Number) -> Number:
    """The magnitude of `a` with the sign of `b`, which a zero has too."""
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return math.copysign(a, b)
    p, q = _pair(a, b)
    return Scalar(p.graph, p.graph.add("copysign", p.i, q.i))


def atan2(y: Number, x: Number) -> Number:
    """Angle of the point (x, y) in (-pi, pi]; 0 at the origin."""
    if not isinstance(y, Scalar) and not isinstance(x, Scalar):
        return math.atan2(y, x)
    a, b = _pair(y, x)
    if a.value is not None and b.value is not None:
        return math.atan2(a.value, b.value)
    return Scalar(a.graph, a.graph.add("atan2", a.i, b.i))


def minimum(a: Number, b: Number) -> Number:
    """The smaller one."""
    return select(less(a, b), a, b)


def maximum(a: Number, b: Number) -> Number:
    """The larger one."""
    return select(less(a, b), b, a)


def less(a: Number, b: Number) -> Condition | bool:
    """Whether a < b."""
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return a < b
    p, q = _pair(a, b)
    if p.value is not None and q.value is not None:
        return p.value < q.value
    return Condition(p.graph, p.graph.add("<", p.i, q.i))


def less_equal(a: Number, b: Number) -> Condition | bool:
    """Whether a <= b."""
    if not isinstance(a, Scalar) and not isinstance(b, Scalar):
        return a <= b
    p, q = _pair(a, b)
    if p.value is not None and q.value is not None:
        return p.value <= q.value
    return Condition(p.graph, p.graph.add("<=", p.i, q.i))


def select(condition: Condition | bool, a: Number, b: Number) -> Number:
    """`a` where the condition holds, else `b`; both are evaluated."""
    if not isinstance(condition, Condition):
        return a if condition else b
    graph = condition.graph
    p = a if isinstance(a, Scalar) else graph.constant(float(a))
    q = b if isinstance(b, Scalar) else graph.constant(float(b))
    return p if p.i == q.i else Scalar(graph, graph.add("select", condition.i, p.i, q.i))
