"""Exact derivatives of a traced equation, as new scalars of the same graph (Griewank & Walther 2008, ch. 3).

Both modes apply the same local rules; zeros vanish while the graph is built, so the result is sparse by itself. The
derivative of a choice is the choice of the derivatives; at the corner of `absolute` it is the right-hand one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Literal

from holonom.errors import UnknownName
from holonom.trace.line.functions import cos, less, select, sin
from holonom.trace.line.graph import Condition, Graph, Number, Scalar, live_nodes

__all__ = ["along", "jacobian", "operations"]

Mode = Literal["forward", "reverse", "best"]
Rows = list[list[Number]]
Push = Callable[[Number], Number]
"""Multiplies a derivative by that of one operation with respect to one operand."""


def jacobian(outputs: Sequence[Number], inputs: Sequence[Scalar], mode: Mode = "best") -> Rows:
    """Return all partial derivatives d outputs[i] / d inputs[j].

    Parameters
    ----------
    outputs : numbers or scalars of one graph.
    inputs : scalars of that graph that count as independent; what lies before them is not looked at.
    mode : "forward" carries the derivatives with respect to every input along, "reverse" the sensitivity of one output
        at a time back to the inputs; "best" builds both and keeps the one with fewer live operations.

    Returns
    -------
    One row per output; an entry that is zero is the number 0.0.
    """
    modes = {"forward": _forward, "reverse": _reverse}
    if mode == "best":
        return min((f(outputs, inputs) for f in modes.values()), key=lambda J: operations([*outputs, *_flat(J)]))
    if mode not in modes:
        raise UnknownName("mode of differentiation", str(mode), (*modes, "best"))
    return modes[mode](outputs, inputs)


def along(outputs: Sequence[Number], inputs: Sequence[Scalar], direction: Sequence[Number]) -> list[Number]:
    """Return the derivatives of the outputs along a direction of the inputs: J @ direction, without J.

    With the inputs' rates as direction these are the outputs' rates.
    """
    tangents: dict[int, Number] = {x.i: d for x, d in zip(inputs, direction, strict=True)}
    scalars = [y for y in outputs if isinstance(y, Scalar)]
    if scalars:
        graph = scalars[0].graph
        for i in live_nodes(graph, scalars):
            if i not in tangents:
                tangents[i] = _sum(push(tangents[a]) for a, push in _rules(graph, i) if not _zero(tangents[a]))
    return [tangents[y.i] if isinstance(y, Scalar) else 0.0 for y in outputs]


def operations(outputs: Sequence[Number]) -> int:
    """Return how many live operations the outputs take."""
    scalars = [y for y in outputs if isinstance(y, Scalar)]
    if not scalars:
        return 0
    graph = scalars[0].graph
    return sum(graph.ops[i][0] not in ("in", "const") for i in live_nodes(graph, scalars))


def _forward(outputs: Sequence[Number], inputs: Sequence[Scalar]) -> Rows:
    columns = []
    for k in range(len(inputs)):
        columns.append(along(outputs, inputs, [1.0 if j == k else 0.0 for j in range(len(inputs))]))
    return [list(row) for row in zip(*columns, strict=True)] if columns else [[] for _ in outputs]


def _reverse(outputs: Sequence[Number], inputs: Sequence[Scalar]) -> Rows:
    return [_sensitivity(y, inputs) if isinstance(y, Scalar) else [0.0] * len(inputs) for y in outputs]


def _sensitivity(output: Scalar, inputs: Sequence[Scalar]) -> list[Number]:
    """Derivatives of one output with respect to all inputs."""
    graph, leaves = output.graph, {x.i for x in inputs}
    adjoint: dict[int, Number] = {output.i: 1.0}
    for i in reversed(live_nodes(graph, [output])):
        if i in leaves or _zero(flow := adjoint.get(i, 0.0)):
            continue
        for a, push in _rules(graph, i):
            adjoint[a] = adjoint.get(a, 0.0) + push(flow)
    return [adjoint.get(x.i, 0.0) for x in inputs]


def _rules(graph: Graph, i: int) -> Iterator[tuple[int, Push]]:
    """Operands of node i, each with what multiplies by the partial derivative; truth values have none."""
    op, *operands = graph.ops[i]
    y = Scalar(graph, i)
    x = [Scalar(graph, a) for a in operands] if op not in ("in", "const") else []  # type: ignore[arg-type]
    forces: list[Push] = []
    match op:
        case "+":
            forces = [_same, _same]
        case "-":
            forces = [_same, _minus]
        case "neg":
            forces = [_minus]
        case "*":
            forces = [lambda d: d * x[1], lambda d: d * x[0]]
        case "/":
            forces = [lambda d: d / x[1], lambda d: -(d * (y / x[1]))]
        case "sqrt":
            forces = [lambda d: d * (0.5 / y)]
        case "sin":
            forces = [lambda d: d * cos(x[0])]
        case "cos":
            forces = [lambda d: -(d * sin(x[0]))]
        case "atan2":
            square = x[0] * x[0] + x[1] * x[1]
            forces = [lambda d: d * (x[1] / square), lambda d: -(d * (x[0] / square))]
        case "abs":
            forces = [lambda d: select(less(x[0], 0.0), -d, d)]
        case "select":
            condition = Condition(graph, x[0].i)
            x = x[1:]
            forces = [lambda d: select(condition, d, 0.0), lambda d: select(condition, 0.0, d)]
    return zip([a.i for a in x], forces, strict=False)


def _same(d: Number) -> Number:
    return d


def _minus(d: Number) -> Number:
    return -d


def _zero(d: Number) -> bool:
    return (d.value if isinstance(d, Scalar) else d) == 0.0


def _sum(terms: Iterator[Number]) -> Number:
    total: Number = 0.0
    for term in terms:
        total = total + term
    return total


def _flat(rows: Rows) -> list[Number]:
    return [entry for row in rows for entry in row]
