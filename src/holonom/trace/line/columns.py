"""Like columns of a result: one straight line for all of them, run in a loop.

What grows with the third power of an arm's joints is mostly a matrix whose columns all come from the same equation.
Written out, that of a long chain takes minutes to compile. In the loop, the columns of one sample are the lanes of a
vector, as many as a register holds; in a batch the lanes are samples, and it goes from one column to the next.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from holonom.errors import ShapeError
from holonom.trace.line.graph import Graph, Scalar
from holonom.trace.line.straight import (
    BLOCK_FLAGS,
    SCALAR_FLAGS,
    TOGETHER,
    Field,
    Results,
    intrinsic,
    loads,
    operand,
    register,
    stored_at_once,
    stores,
    straight_line,
)

__all__ = ["Columns", "columns_of"]


@dataclass(frozen=True, slots=True)
class Columns:
    """The line of one column: its operations, and the numbers of the outputs' column.

    It reads `given`: `shared`, which is the same for all columns, and `own` (m, count), what each starts from.
    """

    given: Sequence[Field]
    body: Sequence[str]
    results: Sequence[Sequence[str]]

    @property
    def count(self) -> int:
        """How many columns there are."""
        return self.given[1].shape[1]

    def text(self, made: Sequence[Field], lanes: int, *, across: bool) -> str:
        """Text of `column(shared, own, outputs, k)`: column k of all lanes, or (across) as many columns from k on."""
        begin = [f"{f.name}_{k} = {f.name}[{k}]" for f in self.given for k in range(f.shape[0])]
        found = zip(made, self.results, strict=True)
        end = [f"{f.name}[{k}] = {value}" for f, values in found for k, value in enumerate(values)]
        arguments = ["shared", "own", *(f.name for f in made), "across" if across else "column"]
        program = [*begin, *stored_at_once(self.body, end)]
        return intrinsic("column", program, arguments, BLOCK_FLAGS, lanes, self.count)

    def line(self, body: Sequence[str], inputs: Sequence[Field], outputs: Sequence[Field], results: Results) -> str:
        """Text of `straight_line(inputs, outputs)` in these parts (see `Parts`)."""
        given, taken = ", ".join(f.name for f in inputs), ", ".join(f.name for f in outputs)
        lanes = next(size for size in TOGETHER if size <= min(register(), self.count))
        program = [*loads(inputs), *stored_at_once(body, stores(self.given, results))]
        arguments = [f.name for f in (*inputs, *self.given)]
        return (
            intrinsic("line", program, arguments, SCALAR_FLAGS, 1)
            + self.text(outputs, lanes, across=True)
            + f'@loop(inline="always")\ndef straight_line({given}, {taken}):\n'
            + "".join(f"    {f.name} = scratch({f.width})\n" for f in self.given)
            + f"    line({', '.join(arguments)})\n    for nth in range(0, {self.count}, {lanes}):\n"
            + f"        column(shared, own, {taken}, min(nth, {self.count - lanes}))\n\n\n"
        )


def columns_of(name: str, equation: Callable[..., Any], shared: int, own: int, outputs: Sequence[Field]) -> Columns:
    """Trace the equation of one column: of `shared` numbers, and its part of `own`.

    Raises
    ------
    ShapeError
        The outputs are not as many columns each, or the equation gives another count of numbers for one.
    """
    graph, count = Graph(), outputs[0].shape[-1]
    if any(f.shape[-1] != count for f in outputs) or own % count:
        shapes = ", ".join(f"{f.name} {f.shape}" for f in outputs)
        raise ShapeError(f"{name!r}: last axes of {shapes} count the columns, which start from {own} numbers in all")
    given = Field("shared", (shared,)), Field("own", (own // count, count))
    raw = equation(*([graph.input(f.name, k) for k in range(f.shape[0])] for f in given))
    found = [
        [v if isinstance(v, Scalar) else graph.constant(float(v)) for v in value]
        for value in ([raw] if len(outputs) == 1 else raw)
    ]
    for f, values in zip(outputs, found, strict=True):
        if len(values) != f.width // count:
            raise ShapeError(f"a column of {f.name!r} has {f.width // count} numbers; {len(values)} came")
    body = straight_line(graph, [s for values in found for s in values])
    return Columns(given, body, [[operand(graph, s.i) for s in values] for values in found])
