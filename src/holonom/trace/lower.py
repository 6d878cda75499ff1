"""From the text of a straight line to machine code, past Numba's type inference: every value in it is a double.

The text is what a person reads (`Kernel.source`): one operation a line, `t7 = t3 * c0`, loads `q_0 = q[0]`, stores
`tau[0] = t7`. Going straight to LLVM compiles it several times faster than letting Numba infer it, and the same text
becomes code for vectors: then each value is that of several samples, one a lane.
"""

from __future__ import annotations

import functools
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from llvmlite import ir
from numba import types

from holonom.trace.elementary import ELEMENTARY, parameters, traced
from holonom.trace.emit import operand, straight_line
from holonom.trace.transpose import itemsize, load_columns, store_columns

__all__ = ["lower"]

DOUBLE, LONG = ir.DoubleType(), ir.IntType(64)
INSTRUCTIONS = {"abs": "llvm.fabs", "sqrt": "llvm.sqrt", "floor": "llvm.floor", "copysign": "llvm.copysign"}
ARITHMETIC = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
LOAD = re.compile(r"(\w+)\[(\d+)\]")
CALL = re.compile(r"(\w+)\((.*)\)")


def lower(
    program: str, arguments: Mapping[str, Any], flags: Sequence[str], *, lanes: int = 1
) -> tuple[Any, Callable[..., Any]]:
    """Return signature and code generator of an intrinsic that runs `program`.

    Parameters
    ----------
    program
        One operation a line; a last line `return x, ...` gives values: of several lanes, their sums.
    arguments
        Name -> Numba type: doubles, and arrays that are read and written, C-contiguous. `a[k]` is place k of the flat
        array; with lanes, as many places from `lanes * k` on. An argument "start" makes them rows: `a[k]` is then
        number k of the rows from `start` on, one a lane.
    flags
        Fast-math flags of the arithmetic.
    lanes
        Samples that are computed at once.
    """
    lines = program.splitlines()
    wanted = lines.pop().removeprefix("return ").split(", ") if lines[-1].startswith("return ") else []
    result = {0: types.void, 1: types.float64}.get(len(wanted), types.UniTuple(types.float64, len(wanted)))

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        given = dict(zip(arguments, args, strict=True))
        kinds = dict(zip(arguments, signature.args, strict=True))
        start = given.pop("start", None)
        data = {
            name: (ctx.make_array(kinds[name])(ctx, builder, value).data, ctx.get_data_type(kinds[name].dtype))
            for name, value in given.items()
            if isinstance(kinds[name], types.Array)
        }
        memory = _Places(builder, data, lanes) if start is None else _Rows(builder, data, lanes, start, lines)
        line = _Assembler(builder, memory, flags, lanes)
        line.values.update((name, value) for name, value in given.items() if name not in data)
        line.run(lines)
        memory.close()
        sums = [line.sum(line.value(word)) for word in wanted]
        if len(sums) > 1:
            return ctx.make_tuple(builder, result, sums)
        return sums[0] if sums else ctx.get_dummy_value()

    return result(*arguments.values()), generate


@functools.cache
def _elementary(name: str) -> tuple[Sequence[str], Sequence[str], Sequence[str]]:
    """Names of the arguments, straight line, and names of the results of an elementary function."""
    graph, found = traced(name)
    lines = straight_line(graph, found)
    return [f"{each}_0" for each in parameters(name)], lines, [operand(graph, value.i) for value in found]


Data = Mapping[str, tuple[Any, Any]]
"""Arrays by name: pointer to the first number, and LLVM type of what is held."""


class _Places:
    """Flat arrays: place k of all lanes lies in one piece."""

    def __init__(self, builder: Any, data: Data, lanes: int) -> None:
        self.builder, self.data, self.lanes = builder, data, lanes

    def load(self, name: str, index: int) -> Any:
        place, kind = self._place(name, index)
        return self.builder.load(place, typ=kind, align=itemsize(DOUBLE))

    def store(self, name: str, index: int, value: Any) -> None:
        place, kind = self._place(name, index)
        self.builder.store(_as_held(self.builder, value, kind), place, align=itemsize(self.data[name][1]))

    def close(self) -> None:
        """All is written."""

    def _place(self, name: str, index: int) -> tuple[Any, Any]:
        first, held = self.data[name]
        kind = held if self.lanes == 1 else ir.VectorType(held, self.lanes)
        where = self.builder.gep(first, [LONG(self.lanes * index)], source_etype=held)
        return self.builder.bitcast(where, kind.as_pointer()), kind


class _Rows:
    """Arrays with a sample a row, as wide as the lines say; what is stored is written at the end."""

    def __init__(self, builder: Any, data: Data, lanes: int, start: Any, lines: Sequence[str]) -> None:
        self.builder, self.lanes = builder, lanes
        named = [found[1] for line in lines for side in line.split(" = ") if (found := LOAD.fullmatch(side))]
        self.widths = Counter(named)
        self.first = {
            name: builder.gep(data[name][0], [builder.mul(start, LONG(width))], source_etype=data[name][1])
            for name, width in self.widths.items()
        }
        self.held = {name: held for name, (_, held) in data.items()}
        self.columns: dict[str, list[Any]] = {}
        self.written: dict[str, list[Any]] = {name: [None] * width for name, width in self.widths.items()}

    def load(self, name: str, index: int) -> Any:
        if name not in self.columns:
            self.columns[name] = load_columns(self.builder, self.first[name], self.widths[name], self.lanes)
        return self.columns[name][index]

    def store(self, name: str, index: int, value: Any) -> None:
        kind = ir.VectorType(self.held[name], self.lanes)
        self.written[name][index] = _as_held(self.builder, value, kind)

    def close(self) -> None:
        for name, columns in self.written.items():
            if columns[0] is not None:
                store_columns(self.builder, self.first[name], columns, self.lanes)


def _as_held(builder: Any, value: Any, kind: Any) -> Any:
    """Doubles as an array holds them: in one of small integers as such."""
    return value if value.type == kind else builder.fptosi(value, kind)


class _Assembler:
    """Emits one straight line; `values` maps names to LLVM values."""

    def __init__(self, builder: Any, memory: _Places | _Rows, flags: Sequence[str], lanes: int) -> None:
        self.builder, self.memory, self.flags, self.lanes = builder, memory, tuple(flags), lanes
        self.kind = DOUBLE if lanes == 1 else ir.VectorType(DOUBLE, lanes)
        self.values: dict[str, Any] = {}

    def run(self, lines: Sequence[str]) -> None:
        for line in lines:
            target, _, expression = line.partition(" = ")
            if stored := LOAD.fullmatch(target):
                self.memory.store(stored[1], int(stored[2]), self.value(expression))
            elif "," in target:
                self.values.update(zip(target.split(", "), self.call(expression), strict=True))
            else:
                self.values[target] = self.evaluate(expression)

    def evaluate(self, expression: str) -> Any:
        if loaded := LOAD.fullmatch(expression):
            return self.memory.load(loaded[1], int(loaded[2]))
        if expression.endswith(")"):
            return self.call(expression)[0]
        words = expression.split(" ")
        if len(words) == 1:
            return self.builder.fneg(self.value(expression[1:]), flags=self.flags)
        a, operator, b = self.value(words[0]), words[1], self.value(words[2])
        if operator in ARITHMETIC:
            return getattr(self.builder, ARITHMETIC[operator])(a, b, flags=self.flags)
        if operator in "&|":
            return self.builder.and_(a, b) if operator == "&" else self.builder.or_(a, b)
        return self.builder.fcmp_ordered(operator, a, b)

    def call(self, expression: str) -> list[Any]:
        """The results of a function, one or more."""
        found = CALL.fullmatch(expression)
        assert found is not None
        name, values = found[1], [self.value(word) for word in found[2].split(", ")]
        if name in ELEMENTARY:
            names, lines, results = _elementary(name)
            inner = _Assembler(self.builder, self.memory, self.flags, self.lanes)
            inner.values.update(zip(names, values, strict=True))
            inner.run(lines)
            return [inner.value(word) for word in results]
        if name == "select":
            return [self.builder.select(*values)]
        return [self.builder.call(self.instruction(INSTRUCTIONS[name], len(values)), values)]

    def instruction(self, name: str, arguments: int) -> Any:
        """An intrinsic of LLVM, for all lanes."""
        module, suffix = self.builder.module, "f64" if self.lanes == 1 else f"v{self.lanes}f64"
        full = f"{name}.{suffix}"
        known = module.globals.get(full)
        return known or ir.Function(module, ir.FunctionType(self.kind, [self.kind] * arguments), full)

    def value(self, word: str) -> Any:
        known = self.values.get(word)
        if known is not None:
            return known
        return ir.Constant(self.kind, float(word) if self.lanes == 1 else [float(word)] * self.lanes)

    def sum(self, value: Any) -> Any:
        """The sum over the lanes."""
        if self.lanes == 1:
            return value
        parts = [self.builder.extract_element(value, ir.IntType(32)(k)) for k in range(self.lanes)]
        while len(parts) > 1:
            parts = [self.builder.fadd(a, b) for a, b in zip(parts[::2], parts[1::2], strict=True)]
        return parts[0]
