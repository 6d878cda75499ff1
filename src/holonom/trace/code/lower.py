"""From the text of a straight line to machine code, past Numba's type inference: every value in it is a double.

The text is what a person reads (`Kernel.source`): one operation a line, `t7 = t3 * c0`, loads `q_0 = q[0]`, stores
`tau[0] = t7`. Going straight to LLVM compiles it several times faster than letting Numba infer it, and the same text
becomes code for vectors: then each value is that of several samples, one a lane.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from llvmlite import ir
from numba import types

from holonom.trace.code.transpose import itemsize, load_columns, splat, store_columns
from holonom.trace.line.elementary import ELEMENTARY, parameters, traced
from holonom.trace.line.straight import operand, straight_line

__all__ = ["lower"]

DOUBLE, LONG = ir.DoubleType(), ir.IntType(64)
INSTRUCTIONS = {"abs": "llvm.fabs", "sqrt": "llvm.sqrt", "floor": "llvm.floor", "copysign": "llvm.copysign"}
ARITHMETIC = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
LOAD = re.compile(r"(\w+)\[(\d+)\]")
CALL = re.compile(r"(\w+)\((.*)\)")


def lower(
    program: str, arguments: Mapping[str, Any], flags: Sequence[str], *, lanes: int = 1, columns: int = 0
) -> tuple[Any, Callable[..., Any]]:
    """Return signature and code generator of an intrinsic that runs `program`.

    Parameters
    ----------
    program
        One operation a line; a last line `return x, ...` gives values: of several lanes, their sums.
    arguments
        Name -> Numba type: doubles, and arrays that are read and written, C-contiguous. `a[k]` is place k of the flat
        array; with lanes, as many places from `lanes * k` on. An argument "start" makes those of two axes rows: `a[k]`
        is then number k of the rows from `start` on, one a lane. Of arrays but "shared", an argument "column" makes
        `a[k]` number k of that column; "across" of as many columns from there on, one a lane, which share "shared".
    flags
        Fast-math flags of the arithmetic.
    lanes
        Samples that are computed at once, or columns.
    columns
        Columns of each array, if any.
    """
    lines = program.splitlines()
    wanted = lines.pop().removeprefix("return ").split(", ") if lines[-1].startswith("return ") else []
    result = {0: types.void, 1: types.float64}.get(len(wanted), types.UniTuple(types.float64, len(wanted)))

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        given = dict(zip(arguments, args, strict=True))
        kinds = dict(zip(arguments, signature.args, strict=True))
        where: dict[str, Any] = {name: given.pop(name) for name in ("start", "column", "across") if name in given}
        memory: dict[str, _Places | _Rows] = {}
        for name in [name for name in given if isinstance(kinds[name], types.Array)]:
            data = ctx.make_array(kinds[name])(ctx, builder, given.pop(name)).data
            held = ctx.get_data_type(kinds[name].dtype)
            if "start" in where and kinds[name].ndim == 2:
                memory[name] = _Rows(builder, data, held, lanes, where["start"], _width(name, lines))
            else:
                begin, step, same = _places(builder, name, where, lanes, columns)
                begun = builder.gep(data, [begin], source_etype=held)
                memory[name] = _Places(builder, begun, held, lanes, step, same=same)
        line = _Assembler(builder, memory, flags, lanes)
        line.values.update(given)
        line.run(lines)
        for each in memory.values():
            each.close()
        sums = [line.sum(line.value(word)) for word in wanted]
        if len(sums) > 1:
            return ctx.make_tuple(builder, result, sums)
        return sums[0] if sums else ctx.get_dummy_value()

    return result(*arguments.values()), generate


def _width(name: str, lines: Sequence[str]) -> int:
    """Numbers of an array that a line reads or writes, which are all that it has."""
    return len({side for line in lines for side in line.split(" = ") if side.startswith(f"{name}[")})


def _places(builder: Any, name: str, where: Mapping[str, Any], lanes: int, columns: int) -> tuple[Any, int, bool]:
    """Where number 0 of an array lies, how much further each next one, and whether all lanes have it in common."""
    if "across" in where:
        return (LONG(0), 1, True) if name == "shared" else (where["across"], columns, False)
    if "column" in where and name != "shared":
        return builder.mul(where["column"], LONG(lanes)), lanes * columns, False
    return LONG(0), lanes, False


@functools.cache
def _elementary(name: str) -> tuple[Sequence[str], Sequence[str], Sequence[str]]:
    """Names of the arguments, straight line, and names of the results of an elementary function."""
    graph, found = traced(name)
    lines = straight_line(graph, found)
    return [f"{each}_0" for each in parameters(name)], lines, [operand(graph, value.i) for value in found]


class _Places:
    """An array in which number k of all lanes lies in one piece, `step` after the one before, or is one for all."""

    def __init__(self, builder: Any, first: Any, held: Any, lanes: int, step: int, *, same: bool = False) -> None:
        self.builder, self.first, self.held, self.step = builder, first, held, step
        self.lanes, self.same = lanes, same and lanes > 1
        self.kind = held if lanes == 1 or same else ir.VectorType(held, lanes)

    def load(self, index: int) -> Any:
        value = self.builder.load(self._place(index), typ=self.kind, align=itemsize(self.held))
        return splat(self.builder, value, self.lanes) if self.same else value

    def store(self, index: int, value: Any) -> None:
        self.builder.store(_as_held(self.builder, value, self.kind), self._place(index), align=itemsize(self.held))

    def close(self) -> None:
        """All is written."""

    def _place(self, index: int) -> Any:
        where = self.builder.gep(self.first, [LONG(self.step * index)], source_etype=self.held)
        return self.builder.bitcast(where, self.kind.as_pointer())


class _Rows:
    """An array with a sample a row, and so many numbers in it; what is stored is written at the end."""

    def __init__(self, builder: Any, first: Any, held: Any, lanes: int, start: Any, width: int) -> None:
        self.builder, self.held, self.lanes = builder, held, lanes
        self.first = builder.gep(first, [builder.mul(start, LONG(width))], source_etype=held)
        self.columns: list[Any] = []
        self.written: list[Any] = [None] * width

    def load(self, index: int) -> Any:
        if not self.columns:
            self.columns = load_columns(self.builder, self.first, len(self.written), self.lanes)
        return self.columns[index]

    def store(self, index: int, value: Any) -> None:
        self.written[index] = _as_held(self.builder, value, ir.VectorType(self.held, self.lanes))

    def close(self) -> None:
        if self.written[0] is not None:
            store_columns(self.builder, self.first, self.written, self.lanes)


def _as_held(builder: Any, value: Any, kind: Any) -> Any:
    """Doubles as an array holds them: in one of small integers as such."""
    return value if value.type == kind else builder.fptosi(value, kind)


class _Assembler:
    """Emits one straight line; `values` maps names to LLVM values."""

    def __init__(self, builder: Any, memory: Mapping[str, _Places | _Rows], flags: Sequence[str], lanes: int) -> None:
        self.builder, self.memory, self.flags, self.lanes = builder, memory, tuple(flags), lanes
        self.kind = DOUBLE if lanes == 1 else ir.VectorType(DOUBLE, lanes)
        self.values: dict[str, Any] = {}

    def run(self, lines: Sequence[str]) -> None:
        for line in lines:
            target, _, expression = line.partition(" = ")
            if stored := LOAD.fullmatch(target):
                self.memory[stored[1]].store(int(stored[2]), self.value(expression))
            elif "," in target:
                self.values.update(zip(target.split(", "), self.call(expression), strict=True))
            else:
                self.values[target] = self.evaluate(expression)

    def evaluate(self, expression: str) -> Any:
        if loaded := LOAD.fullmatch(expression):
            return self.memory[loaded[1]].load(int(loaded[2]))
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
