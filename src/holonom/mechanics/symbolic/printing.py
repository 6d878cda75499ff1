"""Collecting the terms of a polynomial as a textbook does: by accelerations and speeds, then by masses or angles."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from holonom.trace.line.trigonometric import Polynomial

__all__ = [
    "LETTER",
    "MASS",
    "MOTION",
    "WEIGHT",
    "Alphabet",
    "Product",
    "Shape",
    "abbreviation",
    "expression",
    "in_sines",
    "latex_name",
    "latex_names",
]

NEGLIGIBLE = 1e-10  # of the largest coefficient of a formula
DENOMINATORS = (1, 2, 3, 4, 6, 8, 12, 16)
MASS, LETTER, SUM, WEIGHT, ANGLE, MOTION = range(6)
"""What a factor is, in the order in which factors are written."""


class Factor(NamedTuple):
    """A variable to a power (`name`, `power`), or the cosine or sine ("cos", "sin") of an angle sum k . q."""

    rank: int
    order: tuple[float, ...]
    name: str
    power: int = 1
    turns: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Alphabet:
    """The variables' names, what rank they have, and which of them turn about parallel axes together."""

    names: tuple[str, ...]
    ranks: tuple[int, ...]
    groups: tuple[tuple[int, ...], ...]


class Shape(NamedTuple):
    """How to make an expression: SymPy, digits of numbers, fractions or not, and how a sine or cosine is written."""

    sympy: Any
    digits: int
    fractions: bool
    angle: Callable[[str, tuple[tuple[str, float], ...]], Any]


Product = frozenset[Factor]


def in_sines(p: Polynomial, alphabet: Alphabet) -> dict[Product, float]:
    """Products of variables, sines and cosines: e^(i k . q) taken apart, one angle for each group of parallel axes."""
    total: dict[Product, complex] = {}
    for (powers, turns), c in p.items():
        plain = [_variable(alphabet, k, e) for k, e in enumerate(powers) if e]
        angles = [a for group in alphabet.groups if (a := _angle(alphabet, turns, group)) is not None]
        for kinds in itertools.product(("cos", "sin"), repeat=len(angles)):
            factors, value = list(plain), c
            for kind, (sign, order, names) in zip(kinds, angles, strict=True):
                factors.append(Factor(ANGLE, (*order, float(kind == "sin")), kind, 1, names))
                value *= 1j * sign if kind == "sin" else 1.0
            key = frozenset(factors)
            total[key] = total.get(key, 0j) + value
    largest = max((abs(c.real) for c in total.values()), default=0.0)
    return {key: c.real for key, c in total.items() if abs(c.real) > NEGLIGIBLE * largest}


def _variable(alphabet: Alphabet, k: int, power: int) -> Factor:
    return Factor(alphabet.ranks[k], (float(k), -float(power)), alphabet.names[k], power)


def _angle(
    alphabet: Alphabet, turns: Sequence[float], group: Sequence[int]
) -> tuple[float, tuple[float, ...], tuple[tuple[str, float], ...]] | None:
    """Sign, sorting order and names of the part of an angle that belongs to a group, its first factor positive."""
    part = [(k, turns[k]) for k in group if turns[k]]
    if not part:
        return None
    sign = -1.0 if part[0][1] < 0 else 1.0
    order = (float(len(part)), *(v for k, turn in part for v in (float(k), sign * turn)))
    return sign, order, tuple((alphabet.names[k], sign * turn) for k, turn in part)


def expression(terms: Mapping[Product, float], shape: Shape) -> Any:
    """The terms as a nested sum: accelerations and speeds outside, then masses (with g: angles), then the rest."""
    by_motion = _grouped(terms, lambda f, key: f.rank in (MOTION, WEIGHT))
    written = []
    for motion, rest in by_motion:
        heavy = any(f.rank == WEIGHT for f in motion)
        massive = any(f.rank == MASS for key in rest for f in key)
        second = ANGLE if heavy or not massive else MASS
        parts = [
            _times(shape, outer, [_leaf(shape, key, c) for key, c in _sorted(inner)])
            for outer, inner in _grouped(rest, lambda f, key, rank=second: f.rank == rank)
        ]
        written += [_times(shape, motion, [part]) for part in parts] if heavy else [_times(shape, motion, parts)]
    return _sum(shape, [_product(shape, *term) for term in written])


Written = tuple[float, list[tuple[Factor | None, Any]]]
"""A coefficient and factors; a factor that is a sum has no `Factor`."""


def _grouped(
    terms: Mapping[Product, float], outside: Callable[..., bool]
) -> list[tuple[Product, dict[Product, float]]]:
    groups: dict[Product, dict[Product, float]] = {}
    for key, c in terms.items():
        outer = frozenset(f for f in key if outside(f, key))
        groups.setdefault(outer, {})[key - outer] = c
    return sorted(groups.items(), key=lambda item: _order(item[0]))


def _sorted(terms: Mapping[Product, float]) -> list[tuple[Product, float]]:
    return sorted(terms.items(), key=lambda item: _order(item[0]))


def _order(key: Product) -> tuple[Any, ...]:
    """Terms without angles first; accelerations before speeds before g; squares before products."""
    ranked = sorted(key)
    angles = tuple(f.order for f in ranked if f.rank == ANGLE)
    weight = any(f.rank == WEIGHT for f in ranked)
    return weight, len(angles), angles, [(f.rank, *f.order) for f in ranked]


def _leaf(shape: Shape, key: Product, c: float) -> Written:
    return c, [(f, _factor(shape, f)) for f in key]


def _times(shape: Shape, outer: Product, parts: list[Written]) -> Written:
    """`outer` times the sum of the parts; a sum that begins with minus gives its sign away."""
    around = [(f, _factor(shape, f)) for f in outer]
    if len(parts) == 1:
        return parts[0][0], [*parts[0][1], *around]
    if not outer:
        return 1.0, [(None, _sum(shape, [_product(shape, *part) for part in parts]))]
    sign = -1.0 if all(c < 0 for c, _ in parts) else 1.0
    inside = _sum(shape, [_product(shape, sign * c, factors) for c, factors in parts])
    return sign, [(None, inside), *around]


def _factor(shape: Shape, f: Factor) -> Any:
    if f.turns:
        return shape.angle(f.name, f.turns)
    symbol = shape.sympy.Symbol(f.name, real=True)
    return symbol if f.power == 1 else shape.sympy.Pow(symbol, f.power)


def _product(shape: Shape, c: float, factors: list[tuple[Factor | None, Any]]) -> Any:
    ordered = sorted(factors, key=lambda item: (SUM, ()) if item[0] is None else (item[0].rank, item[0].order))
    number = _number(shape, c)
    if len(ordered) == 1 and number == 1:
        return ordered[0][1]
    parts = [e for _, e in ordered] if number == 1 and ordered else [number, *(e for _, e in ordered)]
    return shape.sympy.Mul(*parts, evaluate=False) if len(parts) > 1 else parts[0]


def _number(shape: Shape, c: float) -> Any:
    for d in DENOMINATORS if shape.fractions else (1,):
        if abs(c * d - round(c * d)) < 1e-12 * max(1.0, abs(c * d)):
            return shape.sympy.Rational(round(c * d), d)
    return shape.sympy.Float(f"{c:.{shape.digits}g}")


def _sum(shape: Shape, terms: list[Any]) -> Any:
    """A sum; sums within it are opened."""
    flat = [part for term in terms for part in (term.args if term.is_Add else (term,))]
    if not flat:
        return shape.sympy.Integer(0)
    return shape.sympy.Add(*flat, evaluate=False) if len(flat) > 1 else flat[0]


def abbreviation(kind: str, turns: tuple[tuple[str, float], ...]) -> str:
    """c12 for cos(q1 + q2), s1 for sin(q1); other angles in full."""
    numbers = [name.removeprefix("q") for name, _ in turns]
    if all(turn == 1.0 for _, turn in turns) and (len(turns) == 1 or all(len(k) == 1 for k in numbers)):
        return kind[0] + "".join(numbers)
    text = ""
    for name, turn in turns:
        factor = "" if abs(turn) == 1.0 else f"{abs(turn):g}*"
        text += f"{' - ' if turn < 0 else ' + '}{factor}{name}"
    return f"{kind}({text.removeprefix(' + ')})"


def latex_names(symbols: Sequence[Any]) -> dict[Any, str]:
    r"""How symbols are written in LaTeX: \ddot{q}_{1}, I_{zz1}, c_{12}, \cos(2 q_{1})."""
    return {symbol: latex_name(str(symbol)) for symbol in symbols}


def latex_name(name: str) -> str:
    """A letter with its index below."""
    if name == "det":
        return r"\det B"
    if "(" in name:
        kind, inside = name.removesuffix(")").split("(")
        words = " ".join(latex_name(w) if w[0] == "q" else w for w in inside.replace("*", " ").split())
        return rf"\{kind}({words})"
    stem = name.rstrip("0123456789_")
    index = name[len(stem) :].replace("_", ",")
    head = {"qdd": r"\ddot{q}", "qd": r"\dot{q}", "tau": r"\tau"}.get(stem, stem[0])
    below = index if stem in ("qdd", "qd", "tau") else stem[1:] + index
    return f"{head}_{{{below}}}" if below else head
