"""A traced equation multiplied out: a sum of products of its inputs and of exponentials e^(i k . q).

That form is canonical (angle sums, cancellations and repeated angles are all found by collecting equal terms), so it
is what readable formulas are made from. Division by a sum, roots and selections have no place in it.
"""

from __future__ import annotations

import cmath
from collections.abc import Iterable, Mapping
from operator import add, sub

from holonom.errors import InputError
from holonom.trace.line.graph import Graph, Scalar, live_nodes

__all__ = ["Polynomial", "Term", "Variable", "multiplied_out"]

Variable = tuple[str, int]
"""An input of the graph: name and slot."""

Term = tuple[tuple[int, ...], tuple[float, ...]]
"""Exponents of all variables, and k: how often each of them turns in e^(i k . q)."""

Polynomial = Mapping[Term, complex]
"""Terms and their coefficients."""

ROUNDING = 1e-13  # of the summands: a smaller sum is zero


def multiplied_out(graph: Graph, outputs: Iterable[Scalar], variables: Iterable[Variable]) -> list[Polynomial]:
    """Return each output as a polynomial in the variables and in e^(i k . q).

    Raises
    ------
    InputError
        An output is no such polynomial.
    """
    wanted = list(outputs)
    place = {variable: k for k, variable in enumerate(variables)}
    known: dict[object, dict[Term, complex]] = {}
    for i in live_nodes(graph, wanted):
        op, *a = graph.ops[i]
        if op == "in":
            known[i] = _power(len(place), place[str(a[0]), int(str(a[1]))])
        elif op == "const":
            known[i] = {_one(len(place)): complex(float(str(a[0])))} if a[0] != 0.0 else {}
        else:
            known[i] = _apply(str(op), [known[k] for k in a], len(place))
    return [known[out.i] for out in wanted]


def _one(n: int) -> Term:
    return (0,) * n, (0.0,) * n


def _power(n: int, k: int) -> dict[Term, complex]:
    return {(tuple(int(i == k) for i in range(n)), (0.0,) * n): 1.0 + 0j}


def _apply(op: str, a: list[dict[Term, complex]], n: int) -> dict[Term, complex]:
    match op:
        case "+":
            return _sum(a[0], a[1], 1.0)
        case "-":
            return _sum(a[0], a[1], -1.0)
        case "neg":
            return {term: -c for term, c in a[0].items()}
        case "*":
            return _product(a[0], a[1])
        case "/" if len(a[1]) == 1:
            return _product(a[0], _reciprocal(a[1]))
        case "sin" | "cos":
            forward = _exponential(a[0], n)
            backward = _reciprocal(forward)
            half = 0.5 if op == "cos" else -0.5j
            return _sum({t: half * c for t, c in forward.items()}, backward, half if op == "cos" else -half)
    raise InputError(f"a formula with {op!r} cannot be multiplied out into products, sines and cosines")


def _sum(a: Polynomial, b: Polynomial, sign: complex) -> dict[Term, complex]:
    total = dict(a)
    for term, c in b.items():
        _collect(total, term, sign * c)
    return total


def _collect(total: dict[Term, complex], term: Term, c: complex) -> None:
    before = total.get(term, 0j)
    after = before + c
    if abs(after) <= ROUNDING * (abs(before) + abs(c)):
        total.pop(term, None)
    else:
        total[term] = after


def _product(a: Polynomial, b: Polynomial) -> dict[Term, complex]:
    total: dict[Term, complex] = {}
    for (powers, turns), c in a.items():
        for (more, further), d in b.items():
            _collect(total, (tuple(map(add, powers, more)), tuple(map(add, turns, further))), c * d)
    return total


def _reciprocal(a: Polynomial) -> dict[Term, complex]:
    ((powers, turns), c), zero = next(iter(a.items())), _one(len(next(iter(a))[0]))
    return {(tuple(map(sub, zero[0], powers)), tuple(map(sub, zero[1], turns))): 1.0 / c}


def _exponential(angle: Polynomial, n: int) -> dict[Term, complex]:
    """e^(i angle) of a sum of variables with constant factors, and a constant."""
    turns, offset = [0.0] * n, 0.0
    for (powers, k), c in angle.items():
        if any(k) or sum(powers) > 1 or min(powers, default=0) < 0:
            raise InputError("the angle of a sine or cosine is not linear in the joints")
        if sum(powers) == 0:
            offset = c.real
        else:
            turns[powers.index(1)] = c.real
    return {((0,) * n, tuple(turns)): cmath.exp(1j * offset)}
