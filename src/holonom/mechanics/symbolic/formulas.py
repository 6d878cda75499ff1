"""Formulas of an arm, printed as in a textbook: the same traced equations, multiplied out and collected again."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from holonom.errors import InputError, MissingExtra, UnknownName
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import composite_body, coriolis, newton_euler
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.vectors import Matrix, Vector, columns, sub
from holonom.mechanics.kernels.movable import check_movable
from holonom.mechanics.kernels.placement import bodies_of
from holonom.mechanics.symbolic.printing import (
    LETTER,
    MASS,
    MOTION,
    WEIGHT,
    Alphabet,
    Shape,
    abbreviation,
    expression,
    in_sines,
    latex_name,
    latex_names,
)
from holonom.mechanics.symbolic.symbols import Letters, symbolic_bodies, symbolic_model
from holonom.model import ArmModel
from holonom.trace import Graph, Number, Scalar
from holonom.trace.line.graph import live_nodes
from holonom.trace.line.trigonometric import Variable, multiplied_out

__all__ = ["QUANTITIES", "Formulas", "formulas"]

CRAMER = 2  # joints up to which forward dynamics is written out
PARALLEL = 1e-9  # sine of the angle between axes that are parallel


@dataclass(frozen=True, slots=True)
class Formulas:
    """Formulas as SymPy expressions in q1, ..., qd1, ..., qdd1, ... (tau1, ...) and the letters of the arm.

    Attributes
    ----------
    names, expressions : left and right sides.
    values : the number that each letter has in the model.
    text : one line per formula that is not zero; c12 is cos(q1 + q2), s12 its sine.
    latex : the same as lines of LaTeX.
    """

    names: tuple[str, ...]
    expressions: tuple[Any, ...]
    values: Mapping[str, float]
    text: str
    latex: str


class _Lettered:
    """What the table's equations need: the arm, its links and its motion, in scalars of one graph."""

    def __init__(self, model: ArmModel, graph: Graph, letter: Letters, *, symbols: bool) -> None:
        n = len(model.independent)
        self.source, self._letter, self._symbols = model, letter, symbols
        self.model = symbolic_model(model, letter) if symbols else model
        self.q, self.qd, self.qdd, self.tau = (
            [graph.input(name, k) for k in range(n)] for name in ("q", "qd", "qdd", "tau")
        )
        self.rest = [0.0] * n

    def bodies(self) -> list[Inertial]:
        if self._symbols:
            return symbolic_bodies(self.source, self.model, self._letter)
        return bodies_of(self.source)


Entries = tuple[list[str], list[Number]]


def _rows(name: str, M: Matrix) -> Entries:
    named = [(f"{name}{i + 1}{j + 1}", v) for i, row in enumerate(M) for j, v in enumerate(row)]
    return [n for n, _ in named], [v for _, v in named]


def _vector(name: str, v: Vector) -> Entries:
    return [f"{name}{i + 1}" for i in range(len(v))], list(v)


def _fk(a: _Lettered) -> Entries:
    R, p = kinematics.frames(a.model, a.q)[-1]
    names, entries = _rows("R", R)
    return ["x", "y", "z", *names], [*p, *entries]


def _jacobian(a: _Lettered) -> Entries:
    n = len(a.q)
    J = kinematics.jacobian(a.model, a.q, "world")
    return _rows("J", [J[n * i : n * i + n] for i in range(6)])


def _inverse_dynamics(a: _Lettered) -> Entries:
    return _vector("tau", newton_euler.inverse_dynamics(a.model, a.bodies(), a.q, a.qd, a.qdd))


def _mass_matrix(a: _Lettered) -> Entries:
    return _rows("B", composite_body.mass_matrix(a.model, a.bodies(), a.q))


def _coriolis_matrix(a: _Lettered) -> Entries:
    return _rows("C", coriolis.coriolis_matrix(a.model, a.bodies(), a.q, a.qd))


def _gravity(a: _Lettered) -> Entries:
    return _vector("g", newton_euler.inverse_dynamics(a.model, a.bodies(), a.q, a.rest, a.rest))


def _forward_dynamics(a: _Lettered) -> Entries:
    """Cramer's rule: numerators N, and the determinant that divides them all."""
    n, bodies = len(a.q), a.bodies()
    if n > CRAMER:
        raise InputError(f"forward dynamics of {n} joints fills pages; formulas are written for up to {CRAMER}")
    check_movable(a.source)
    B = columns(composite_body.mass_matrix(a.model, bodies, a.q))
    force = sub(a.tau, newton_euler.inverse_dynamics(a.model, bodies, a.q, a.qd, a.rest))
    names, numerators = _vector("qdd", [_determinant([*B[:i], force, *B[i + 1 :]]) for i in range(n)])
    return [*names, "det"], [*numerators, _determinant(B)]


def _determinant(A: Matrix) -> Number:
    if len(A) == 1:
        return A[0][0]
    total: Number = 0.0
    for k, row in enumerate(A):
        minor = _determinant([other[1:] for i, other in enumerate(A) if i != k])
        total = total + (1.0 if k % 2 == 0 else -1.0) * (row[0] * minor)
    return total


QUANTITIES: Mapping[str, Callable[[_Lettered], Entries]] = {
    "fk": _fk,
    "jacobian": _jacobian,
    "inverse_dynamics": _inverse_dynamics,
    "forward_dynamics": _forward_dynamics,
    "mass_matrix": _mass_matrix,
    "coriolis_matrix": _coriolis_matrix,
    "gravity": _gravity,
}
"""What can be written out as formulas, by the name that `formulas` takes."""


def formulas(
    arm: Arm | ArmModel,
    what: str = "inverse_dynamics",
    *,
    values: Literal["symbols", "numbers"] = "symbols",
    names: Mapping[str, str] | None = None,
    digits: int = 6,
) -> Formulas:
    """Write out a quantity of an arm (without friction), as a textbook does.

    Parameters
    ----------
    arm : an arm or its model.
    what : one of `QUANTITIES`: "fk" (position and rotation of the tool), "jacobian" (in the world), "mass_matrix",
        "coriolis_matrix", "gravity", "inverse_dynamics", and "forward_dynamics" (up to two joints).
    values : "symbols" puts letters for the arm's numbers (see `symbolic_model`: a1, d1, m1, cx1, Izz1, k1, Im1, g),
        "numbers" the numbers themselves.
    names : other names for letters, such as {"a1": "l1", "cx1": "a1"}.
    digits : significant ones of numbers that are no simple fraction.

    Raises
    ------
    UnknownName
        No such quantity, or no such letter to rename.
    InputError
        SymPy is not installed, or forward dynamics of more than two joints.
    MissingInertia

    Notes
    -----
    Products of sines and cosines of joints with parallel axes become angle sums; other angles stay products.
    """
    if what not in QUANTITIES:
        raise UnknownName("formula", what, QUANTITIES)
    if values not in ("symbols", "numbers"):
        raise UnknownName("kind of values", str(values), ("symbols", "numbers"))
    model = arm.model if isinstance(arm, Arm) else arm
    sympy = _sympy()
    graph = Graph()
    letter = Letters(graph, names or {})
    labels, entries = QUANTITIES[what](_Lettered(model, graph, letter, symbols=values == "symbols"))
    for name in names or {}:
        if name not in letter.proposed:
            raise UnknownName("letter", name, letter.proposed)
    outputs = [v if isinstance(v, Scalar) else graph.constant(float(v)) for v in entries]
    inputs = [graph.ops[i] for i in live_nodes(graph, outputs) if graph.ops[i][0] == "in"]
    variables = sorted(((str(op[1]), int(str(op[2]))) for op in inputs), key=_importance)
    alphabet = _alphabet(model, variables, letter)
    sums = [in_sines(p, alphabet) for p in multiplied_out(graph, outputs, variables)]
    full, short = _shapes(sympy, digits, fractions=values == "symbols")
    expressions = [expression(terms, full) for terms in sums]
    brief = [expression(terms, short) for terms in sums]
    if what == "forward_dynamics":
        expressions = _divided(sympy, expressions, expressions[-1])
        brief = _divided(sympy, brief, sympy.Symbol("det"))
    told = [(label, e) for label, e in zip(labels, brief, strict=True) if e != 0] or [(labels[0], brief[0])]
    return Formulas(tuple(labels), tuple(expressions), letter.values, _text(sympy, told), _latex(sympy, told))


def _divided(sympy: Any, expressions: list[Any], determinant: Any) -> list[Any]:
    """Numerators over the determinant, which is the last."""
    over = sympy.Pow(determinant, -1, evaluate=False)
    return [*(sympy.Mul(e, over, evaluate=False) for e in expressions[:-1]), expressions[-1]]


def _text(sympy: Any, told: list[tuple[str, Any]]) -> str:
    return "\n".join(f"{label} = {sympy.sstr(e, order='none').replace('**', '^')}" for label, e in told)


def _latex(sympy: Any, told: list[tuple[str, Any]]) -> str:
    lines = [
        f"{latex_name(label)} = {sympy.latex(e, order='none', symbol_names=latex_names(list(e.free_symbols)))}"
        for label, e in told
    ]
    return " \\\\\n".join(lines)


def _sympy() -> Any:
    try:
        return importlib.import_module("sympy")
    except ImportError:
        raise MissingExtra("a formula", "SymPy", "symbolic") from None


def _importance(variable: Variable) -> tuple[int, int]:
    """Accelerations and torques come first in a sum, then speeds, then what is proportional to a sliding joint's q."""
    name, slot = variable
    return {"qdd": 0, "tau": 0, "qd": 1, "q": 2}.get(name, 3), slot


def _parallel(model: ArmModel) -> list[list[int]]:
    """Entries of q that turn about axes which stay parallel: their sines and cosines are added up."""
    axes = [_axes(model, seed) for seed in (1, 2)]
    groups: list[list[int]] = []
    for i in range(len(model.independent)):
        for group in groups:
            if all(np.linalg.norm(np.cross(z[group[0]], z[i])) < PARALLEL for z in axes):
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _axes(model: ArmModel, seed: int) -> list[Any]:
    """Axes of the independent joints in the world, in a random configuration."""
    q = np.random.default_rng(seed).uniform(-1.0, 1.0, len(model.independent)).tolist()
    T = kinematics.frames(model, q)
    before = [np.array(joint.before)[:3, 2] for joint in model.joints]
    return [np.array(T[model.parent(i) + 1][0], dtype=float) @ before[i] for i in model.independent]


def _alphabet(model: ArmModel, variables: list[Variable], letter: Letters) -> Alphabet:
    masses, weight = {letter.renamed(f"m{i + 1}") for i in range(len(model.joints))}, letter.renamed("g")
    names, ranks = [], []
    for name, slot in variables:
        arms = name in letter.values
        names.append(name if arms else f"{name}{slot + 1}")
        ranks.append(MOTION if not arms else MASS if name in masses else WEIGHT if name == weight else LETTER)
    place = {variable: k for k, variable in enumerate(variables)}
    groups = tuple(tuple(place["q", i] for i in group if ("q", i) in place) for group in _parallel(model))
    return Alphabet(tuple(names), tuple(ranks), groups)


def _shapes(sympy: Any, digits: int, *, fractions: bool) -> tuple[Shape, Shape]:
    """How to write in full, and abbreviated."""

    def full(kind: str, turns: tuple[tuple[str, float], ...]) -> Any:
        angle = sum(sympy.nsimplify(k) * sympy.Symbol(name, real=True) for name, k in turns)
        return getattr(sympy, kind)(angle)

    def short(kind: str, turns: tuple[tuple[str, float], ...]) -> Any:
        return sympy.Symbol(abbreviation(kind, turns))

    return Shape(sympy, digits, fractions, full), Shape(sympy, digits, fractions, short)
