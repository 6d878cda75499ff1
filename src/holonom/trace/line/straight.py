"""The straight line of a kernel as text, an operation a line: what is read, computed and stored.

`emit` puts it into modules, `lanes` and `columns` take it apart, `lower` turns just that text into machine code.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from holonom.arrays import LARGEST
from holonom.trace.line.graph import Graph, Scalar, live_nodes

__all__ = [
    "BLOCK_FLAGS",
    "SCALAR_FLAGS",
    "TOGETHER",
    "Field",
    "Results",
    "intrinsic",
    "loads",
    "operand",
    "register",
    "stored_at_once",
    "stores",
    "straight_line",
]

TOGETHER = (16, 8, 4, 2, 1)
"""Numbers of a row that are written together, best first."""
Results = Mapping[str, list[str]]
BLOCK_FLAGS = ("contract", "nsz", "arcp")  # "reassoc" gains nothing here, and LLVM got one of 504 outputs wrong with it
SCALAR_FLAGS = ("contract", "nsz")
CALLS = {"atan2": "arctan2"}


@dataclass(frozen=True, slots=True)
class Field:
    """A named input or output array of one sample: its shape and whether it holds small integers (`int8`).

    An input's length, the root of the sum of its squares, may be up to `bound`: products of larger numbers overflow,
    and of an angle beyond `arrays.REVOLUTION` no revolution can be told. An output that is `checked` is refused where
    it is not finite.
    """

    name: str
    shape: tuple[int, ...]
    integer: bool = False
    bound: float = LARGEST
    checked: bool = False

    @property
    def width(self) -> int:
        """Numbers per sample."""
        return math.prod(self.shape)


def operand(graph: Graph, i: object) -> str:
    """Return how node `i` is written inside an expression."""
    assert isinstance(i, int)
    op, *a = graph.ops[i]
    match op:
        case "in":
            return f"{a[0]}_{a[1]}"
        case "const":
            return repr(a[0])
        case "sin":
            return f"s{a[0]}"
        case "cos":
            return f"c{a[0]}"
        case _:
            return f"t{i}"


def straight_line(graph: Graph, outputs: Sequence[Scalar]) -> list[str]:
    """Return one assignment per live operation; inputs stand as `{name}_{slot}`, constants in place."""
    lines: list[str] = []
    trig: set[object] = set()
    for i in live_nodes(graph, outputs):
        op, *a = graph.ops[i]
        if op in ("in", "const"):
            continue
        names = [operand(graph, k) for k in a]
        match op:
            case "sin" | "cos":
                if a[0] not in trig:
                    trig.add(a[0])
                    lines.append(f"s{a[0]}, c{a[0]} = sincos({names[0]})")
            case "neg":
                lines.append(f"t{i} = -{names[0]}")
            case "abs" | "sqrt" | "floor" | "copysign" | "atan2" | "select":
                lines.append(f"t{i} = {CALLS.get(str(op), op)}({', '.join(names)})")
            case "and" | "or":
                lines.append(f"t{i} = {names[0]} {'&' if op == 'and' else '|'} {names[1]}")
            case _:
                lines.append(f"t{i} = {names[0]} {op} {names[1]}")
    return lines


def loads(fields: Sequence[Field]) -> list[str]:
    """Lines that name the numbers of arrays."""
    return [f"{f.name}_{k} = {f.name}[{k}]" for f in fields for k in range(f.width)]


def stores(fields: Sequence[Field], results: Results) -> list[str]:
    """Lines that write results to arrays."""
    return [f"{f.name}[{k}] = {results[f.name][k]}" for f in fields for k in range(f.width)]


def stored_at_once(body: Sequence[str], stores: Sequence[str]) -> list[str]:
    """The lines, each store behind the line that makes its value: nothing has to be remembered for the end."""
    waiting: dict[str, list[str]] = {}
    for store in stores:
        waiting.setdefault(store.partition(" = ")[2], []).append(store)
    lines = []
    for line in body:
        lines.append(line)
        for name in line.partition(" = ")[0].split(", "):
            lines += waiting.pop(name, [])
    return lines + [store for rest in waiting.values() for store in rest]


def intrinsic(
    name: str, program: Sequence[str], arguments: Sequence[str], flags: tuple[str, ...], lanes: int, columns: int = 0
) -> str:
    """Text of an intrinsic that runs a straight line on its arguments."""
    text, table = "\n".join(program), ", ".join(f'"{a}": {a}' for a in arguments)
    more = f", columns={columns}" if columns else ""
    return (
        f'{name.upper()} = """\\\n{text}\n"""\n\n\n@intrinsic\ndef {name}(context, {", ".join(arguments)}):\n'
        f"    return lower({name.upper()}, {{{table}}}, {flags!r}, lanes={lanes}{more})\n\n\n"
    )


@functools.cache
def register() -> int:
    """Return how many doubles a vector register of this machine holds."""
    from llvmlite import binding

    features = binding.get_host_cpu_features()
    return 8 if features.get("avx512f") else 4 if features.get("avx") else 2
