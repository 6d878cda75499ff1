"""From the text of a straight line to machine code, past Numba's type inference: every value in it is a double.

The text is what a person reads (`Kernel.source`): one operation a line, `t7 = t3 * c0`, loads `q_0 = q[0]`, stores
`tau[0] = t7`.
Going straight to LLVM compiles it several times faster than letting Numba infer it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from llvmlite import ir
from numba import types

from holonom.trace.elementary import arctan2, sincos

__all__ = ["lower"]

DOUBLE = ir.DoubleType()
CALLED = {"sincos": sincos, "arctan2": arctan2}
"""Helpers that are compiled functions of their own."""
INSTRUCTIONS = {"abs": "llvm.fabs", "sqrt": "llvm.sqrt"}
ARITHMETIC = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
LOAD = re.compile(r"(\w+)\[(\d+)\]")
CALL = re.compile(r"(\w+)\((.*)\)")


def lower(
    context: Any, program: str, arguments: Mapping[str, Any], flags: Sequence[str], *, stride: int = 1
) -> tuple[Any, Callable[..., Any]]:
    """Return signature and code generator of an intrinsic that runs `program`.

    Parameters
    ----------
    context
        Numba's typing context, as an intrinsic gets it.
    program
        One operation a line; a last line `return x` gives a value.
    arguments
        Name -> Numba type: arrays that are read and written at flat places, C-contiguous; an integer argument
        "lane" is added to every place.
    flags
        Fast-math flags of the arithmetic.
    stride
        Elements between neighbouring places: 64 where each place holds a block of lanes.
    """
    lines = program.splitlines()
    result = types.float64 if lines and lines[-1].startswith("return ") else types.void
    helpers = {name: _typed(context, function) for name, function in CALLED.items() if f"{name}(" in program}

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        places = dict(zip(arguments, args, strict=True))
        lane = places.pop("lane", None)
        kinds = dict(zip(arguments, signature.args, strict=True))
        data = {name: ctx.make_array(kinds[name])(ctx, builder, array).data for name, array in places.items()}
        held = {name: ctx.get_data_type(kinds[name].dtype) for name in places}
        calls = {name: (ctx.get_function(kind, sig)) for name, (kind, sig) in helpers.items()}
        return _Assembler(ctx, builder, data, held, calls, tuple(flags), lane, stride).run(lines)

    return result(*arguments.values()), generate


def _typed(context: Any, function: Any) -> tuple[Any, Any]:
    """Compile a helper for doubles; return its type and signature."""
    kind = context.resolve_value_type(function)
    count = function.py_func.__code__.co_argcount
    return kind, kind.get_call_type(context, (types.float64,) * count, {})


class _Assembler:
    """Emits one straight line; `values` maps names to LLVM values."""

    def __init__(
        self,
        ctx: Any,
        builder: Any,
        data: Mapping[str, Any],
        held: Mapping[str, Any],
        calls: Mapping[str, Any],
        flags: tuple[str, ...],
        lane: Any,
        stride: int,
    ) -> None:
        self.ctx, self.builder, self.data, self.held, self.calls = ctx, builder, data, held, calls
        self.flags, self.lane, self.stride = flags, lane, stride
        self.values: dict[str, Any] = {}

    def run(self, lines: Sequence[str]) -> Any:
        for line in lines:
            if line.startswith("return "):
                return self.value(line.removeprefix("return "))
            target, _, expression = line.partition(" = ")
            if stored := LOAD.fullmatch(target):
                self.store(stored[1], stored[2], self.value(expression))
            elif "," in target:
                pair = self.call(expression)
                for k, name in enumerate(target.split(", ")):
                    self.values[name] = self.builder.extract_value(pair, k)
            else:
                self.values[target] = self.evaluate(expression)
        return self.ctx.get_dummy_value()

    def evaluate(self, expression: str) -> Any:
        if loaded := LOAD.fullmatch(expression):
            return self.builder.load(self.place(*loaded.groups()), typ=DOUBLE)
        if expression.endswith(")"):
            return self.call(expression)
        words = expression.split(" ")
        if len(words) == 1:
            return self.builder.fneg(self.value(expression[1:]), flags=self.flags)
        a, operator, b = self.value(words[0]), words[1], self.value(words[2])
        if operator in ARITHMETIC:
            return getattr(self.builder, ARITHMETIC[operator])(a, b, flags=self.flags)
        if operator in "&|":
            return self.builder.and_(a, b) if operator == "&" else self.builder.or_(a, b)
        return self.builder.fcmp_ordered(operator, a, b)

    def call(self, expression: str) -> Any:
        found = CALL.fullmatch(expression)
        assert found is not None
        name, values = found[1], [self.value(word) for word in found[2].split(", ")]
        if name == "select":
            return self.builder.select(*values)
        if name in INSTRUCTIONS:
            return self.builder.call(self.builder.module.declare_intrinsic(INSTRUCTIONS[name], [DOUBLE]), values)
        return self.calls[name](self.builder, values)

    def value(self, word: str) -> Any:
        known = self.values.get(word)
        return ir.Constant(DOUBLE, float(word)) if known is None else known

    def place(self, name: str, index: str) -> Any:
        offset = ir.Constant(ir.IntType(64), int(index) * self.stride)
        where = offset if self.lane is None else self.builder.add(self.lane, offset)
        return self.builder.gep(self.data[name], [where], source_etype=self.held[name])

    def store(self, name: str, index: str, value: Any) -> None:
        """Store a double; into an array of small integers as one."""
        held = self.held[name]
        self.builder.store(value if held == DOUBLE else self.builder.fptosi(value, held), self.place(name, index))
