"""Like parts of one graph, laid side by side: the branches of an inverse become the lanes of a vector.

The outputs of such a kernel have a row per branch, and all rows come from the same equation, with other signs. Nodes of
several rows make a tuple. Where all of it do the same, their operands make tuples in turn, down to what the rows share
or where they differ: that is computed once, before the lanes.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from holonom.trace.line.graph import Graph, Op, Scalar
from holonom.trace.line.straight import (
    BLOCK_FLAGS,
    SCALAR_FLAGS,
    Field,
    Results,
    intrinsic,
    loads,
    operand,
    stores,
    straight_line,
)

__all__ = ["Lanes", "lanes_of"]

WIDTHS = (8, 4)
"""Branches of a vector, best first."""
DEPTH = 4
"""Operations deep that the operands of sums and products are compared."""
CONDITIONS = ("<", "<=", "and", "or")
COMMUTE = ("+", "*", "and", "or")
Rows = tuple[int, ...]
"""The nodes of several rows, one each."""
Likeness = Callable[[int, int, int], int]


@dataclass(frozen=True, slots=True)
class Lanes:
    """The programs of one sample whose branches are lanes.

    `shared` writes to `buf` what the branches start from. `branch` finds place k of a lane in `buf[width k + lane]` and
    writes there. `loads` brings back what `results` names; `size` numbers are in `buf`.
    """

    width: int
    size: int
    shared: Sequence[str]
    branch: Sequence[str]
    loads: Sequence[str]
    results: Results

    def line(self, body: Sequence[str], inputs: Sequence[Field], outputs: Sequence[Field], results: Results) -> str:
        """Text of `straight_line(inputs, outputs)` in these parts (see `Parts`)."""
        given, taken = [f.name for f in inputs], [f.name for f in outputs]
        return (
            intrinsic("shared", [*loads(inputs), *self.shared], [*given, "buf"], SCALAR_FLAGS, 1)
            + intrinsic("branch", self.branch, ["buf"], BLOCK_FLAGS, self.width)
            + intrinsic("spread", [*self.loads, *stores(outputs, self.results)], ["buf", *taken], SCALAR_FLAGS, 1)
            + f'@loop(inline="always")\ndef straight_line({", ".join((*given, *taken))}):\n'
            + f"    buf = scratch({self.size})\n    shared({', '.join(given)}, buf)\n    branch(buf)\n"
            + f"    spread(buf, {', '.join(taken)})\n\n\n"
        )


def lanes_of(graph: Graph, outputs: Sequence[Field], results: Mapping[str, Sequence[Scalar]]) -> Lanes | None:
    """Lay the rows of all outputs side by side; None if no vector of `WIDTHS` is full of them."""
    rows = outputs[0].shape[0]
    width = next((width for width in WIDTHS if rows % width == 0), None)
    if width is None:
        return None
    widths = {f.name: f.width // rows for f in outputs}
    places = [(name, width * row + k) for name, width in widths.items() for k in range(width) for row in range(rows)]
    values = [results[name][k].i for name, k in places]
    lane, wanted, given = _side_by_side(graph, [tuple(values[k : k + width]) for k in range(0, len(values), width)])
    starts = [Scalar(graph, i) for nodes in given for i in nodes]
    shared = straight_line(graph, starts)
    shared += [f"buf[{k}] = {operand(graph, s.i)}" for k, s in enumerate(starts)]
    branch = [f"lane_{k} = buf[{k}]" for k in range(len(given))]
    branch += straight_line(lane, wanted)
    branch += [f"buf[{len(given) + k}] = {operand(lane, s.i)}" for k, s in enumerate(wanted)]
    found_again = [f"found_{k} = buf[{len(starts) + k}]" for k in range(len(places))]
    names = {place: f"found_{k}" for k, place in enumerate(places)}
    found = {f.name: [names[f.name, k] for k in range(f.width)] for f in outputs}
    return Lanes(width, len(starts) + len(places), shared, branch, found_again, found)


def _side_by_side(graph: Graph, columns: Sequence[Rows]) -> tuple[Graph, list[Scalar], list[Rows]]:
    """The graph of one lane, its outputs, and what each of its inputs `lane_{k}` is for all lanes, in the whole."""
    lane, given = Graph(), list[Rows]()
    made: dict[Rows, int] = {}
    split = functools.cache(functools.partial(_split, graph, _likeness(graph)))
    stack = list(reversed(columns))
    while stack:
        nodes = stack[-1]
        op, parts = split(nodes)
        missing = [part for part in parts if part not in made]
        if missing:
            stack += reversed(missing)
            continue
        stack.pop()
        if nodes not in made:
            made[nodes] = lane.add(op, *(made[part] for part in parts)) if parts else _start(graph, lane, given, nodes)
    return lane, [Scalar(lane, made[nodes]) for nodes in columns], given


def _start(graph: Graph, lane: Graph, given: list[Rows], nodes: Rows) -> int:
    """What a lane does not compute: a constant, or an input; a truth value is 1 or 0 there."""
    kind, *value = graph.ops[nodes[0]]
    if kind == "const" and len(set(nodes)) == 1:
        return lane.add("const", *value)
    number = lane.input("lane", len(given))
    if kind not in CONDITIONS:
        given.append(nodes)
        return number.i
    one, zero = graph.constant(1.0), graph.constant(0.0)
    given.append(tuple(graph.add("select", i, one.i, zero.i) for i in nodes))
    return lane.add("<", lane.constant(0.5).i, number.i)


def _split(graph: Graph, alike: Likeness, nodes: Rows) -> tuple[str, list[Rows]]:
    """The operation that all nodes do, and its operands; no operands where they end.

    Branches differ by signs: where some add and others subtract, all add a product with 1 or -1.
    """
    ops = [graph.ops[i] for i in nodes]
    kinds = {str(op[0]) for op in ops}
    if len(set(nodes)) == 1 or kinds & {"const", "in"}:
        return "", []
    if len(kinds) == 1:
        return kinds.pop(), _columns(alike, ops)
    if kinds == {"+", "-"}:
        a, b = _columns(alike, ops)
        signs = _signs(graph, [op[0] == "-" for op in ops])
        return "+", [a, tuple(graph.add("*", i, sign) for i, sign in zip(b, signs, strict=True))]
    if "neg" in kinds:
        plain = tuple(_operands(op)[0] if op[0] == "neg" else i for i, op in zip(nodes, ops, strict=True))
        return "*", [plain, _signs(graph, [op[0] == "neg" for op in ops])]
    return "", []


def _signs(graph: Graph, negative: Sequence[bool]) -> Rows:
    return tuple(graph.constant(-1.0 if minus else 1.0).i for minus in negative)


def _columns(alike: Likeness, ops: Sequence[Op]) -> list[Rows]:
    """Operands side by side; those of a sum or product in the order in which they are most like the first row's."""
    first = _operands(ops[0])
    lines = [first]
    for op in ops[1:]:
        line = _operands(op)
        if op[0] in COMMUTE and _in_order(alike, first, line[::-1], DEPTH) > _in_order(alike, first, line, DEPTH):
            line = line[::-1]
        lines.append(line)
    return list(zip(*lines, strict=True))


def _operands(op: Op) -> list[int]:
    return [i for i in op[1:] if isinstance(i, int)]


def _likeness(graph: Graph) -> Likeness:
    """How much two nodes have in common, so many operations deep."""

    @functools.cache
    def alike(i: int, j: int, depth: int) -> int:
        p, q = graph.ops[i], graph.ops[j]
        if i == j:
            return 4**depth
        if p[0] != q[0] or p[0] == "in":
            return 0
        if p[0] == "const" or not depth:
            return 1
        a, b = _operands(p), _operands(q)
        crossed = _in_order(alike, a, b[::-1], depth - 1) if p[0] in COMMUTE else 0
        return 1 + max(_in_order(alike, a, b, depth - 1), crossed)

    return alike


def _in_order(alike: Likeness, a: Sequence[int], b: Sequence[int], depth: int) -> int:
    return sum(alike(i, j, depth) for i, j in zip(a, b, strict=True))
