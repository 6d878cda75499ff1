"""Four numbers side by side in one register: equations written for a number are computed for four wheels at once.

In compiled code a `Pack` is added, multiplied, compared and chosen from as a float is, lane by lane, also with floats
(which count for all lanes): `+ - * /`, `< <= > >=` and `& |` of these, `min`, `max`, `abs`, `math.sqrt`,
`math.copysign`, `np.floor`, and `select` of `trace.compiled`. Nothing branches on one; `any_of` and `total` lead back
to a truth value and a number. `spread` makes a pack of one number, `chosen(a, b, 0, 1, 4, 5)` one of four lanes of two
packs (0 to 3 are those of `a`). `packed(record)` gives a record whose fields (4,) are packs, to read and to set:

    own = packed(states[0])
    own.angle += dt * own.speed

Where registers hold fewer than four numbers, LLVM takes several for one.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer, infer_global, signature
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_cast,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_model,
)

__all__ = ["WIDTH", "any_of", "chosen", "largest", "load", "mask", "pack", "packed", "spread", "store", "total"]

WIDTH = 4

_NUMBERS = ir.VectorType(ir.DoubleType(), WIDTH)
_TRUTHS = ir.VectorType(ir.IntType(1), WIDTH)


class Pack(types.Type):
    """Four float64."""

    def __init__(self) -> None:
        super().__init__("Pack")

    def can_convert_from(self, typingctx: Any, other: Any) -> Conversion | None:
        """Tell Numba that a number counts for all lanes."""
        del typingctx
        return Conversion.safe if isinstance(other, types.Float | types.Integer) else None


class Mask(types.Type):
    """Four truth values."""

    def __init__(self) -> None:
        super().__init__("Mask")


class PackedRecord(types.Type):
    """A record that lies in memory, its fields (4,) as packs."""

    def __init__(self, record: types.Record) -> None:
        self.record = record
        super().__init__(f"Packed({record})")


pack, mask = Pack(), Mask()


def _represent(kind: type[types.Type], as_what: ir.Type) -> None:
    """Tell Numba what LLVM holds values of a type in."""

    class Model(models.PrimitiveModel):
        def __init__(self, manager: Any, of: Any) -> None:
            super().__init__(manager, of, as_what)  # type: ignore[no-untyped-call]

    register_model(kind)(Model)


_represent(Pack, _NUMBERS)
_represent(Mask, _TRUTHS)
_represent(PackedRecord, ir.PointerType(ir.IntType(8)))


@lower_cast(types.Float, Pack)
@lower_cast(types.Integer, Pack)
def _spread(context: Any, builder: Any, given: Any, wanted: Any, value: Any) -> Any:
    """One number in all lanes."""
    del wanted
    number = context.cast(builder, value, given, types.float64)
    one = builder.insert_element(ir.Constant(_NUMBERS, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(one, ir.Constant(_NUMBERS, ir.Undefined), lanes)


def _define(function: Any, result: Any, operands: tuple[Any, ...], emit: Callable[..., Any]) -> None:
    """Let compiled code call a function with packs, or with packs and numbers; `emit` writes the instructions."""

    class Template(AbstractTemplate):
        key = function

        def generic(self, args: Any, kws: Any) -> Any:
            meant = len(args) == len(operands) and not kws and any(isinstance(kind, Pack | Mask) for kind in args)
            if meant and all(self.context.can_convert(*pair) is not None for pair in zip(args, operands, strict=True)):
                return signature(result, *operands)
            return None

    def generate(context: Any, builder: Any, _: Any, args: Any) -> Any:
        del context
        return emit(builder, *args)

    infer(Template)
    infer_global(function, types.Function(Template))
    lower_builtin(function, *(type(kind) for kind in operands))(generate)


def _instruction(name: str) -> Callable[..., Any]:
    return lambda builder, *args: getattr(builder, name)(*args)


def _comparison(sign: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


def _llvm(name: str) -> Callable[..., Any]:
    """One of LLVM's own functions, lane by lane."""

    def emit(builder: Any, *args: Any) -> Any:
        kind = ir.FunctionType(_NUMBERS, [_NUMBERS] * len(args))
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64")
        return builder.call(function, args)

    return emit


def _better(sign: str) -> Callable[..., Any]:
    """As Python's `min` and `max`: the first, unless the second is better."""
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(sign, b, a), b, a)


_function: Any
for _name, _functions in (
    ("fadd", (operator.add, operator.iadd)),
    ("fsub", (operator.sub, operator.isub)),
    ("fmul", (operator.mul, operator.imul)),
    ("fdiv", (operator.truediv, operator.itruediv)),
):
    for _function in _functions:
        _define(_function, pack, (pack, pack), _instruction(_name))
for _function, _name in ((operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">=")):
    _define(_function, mask, (pack, pack), _comparison(_name))
for _function, _name in ((operator.and_, "and_"), (operator.or_, "or_")):
    _define(_function, mask, (mask, mask), _instruction(_name))
for _function, _name in ((math.sqrt, "sqrt"), (abs, "fabs"), (np.floor, "floor")):
    _define(_function, pack, (pack,), _llvm(_name))
_define(operator.neg, pack, (pack,), _instruction("fneg"))
_define(math.copysign, pack, (pack, pack), _llvm("copysign"))
_define(min, pack, (pack, pack), _better("<"))
_define(max, pack, (pack, pack), _better(">"))


def _total(context: Any, numbers: Any) -> Any:
    """Sum of four numbers, `(a + c) + (b + d)`."""
    del context, numbers

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        number = ir.IntType(32)
        half = builder.fadd(_lanes(builder, args[0], 0, 1), _lanes(builder, args[0], 2, 3))
        return builder.fadd(*(builder.extract_element(half, ir.Constant(number, k)) for k in range(2)))

    return types.float64(pack), generate


def _largest(context: Any, numbers: Any) -> Any:
    """The largest of four numbers."""
    del context, numbers

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        number = ir.IntType(32)
        half = _better(">")(builder, _lanes(builder, args[0], 0, 1), _lanes(builder, args[0], 2, 3))
        return _better(">")(builder, *(builder.extract_element(half, ir.Constant(number, k)) for k in range(2)))

    return types.float64(pack), generate


def _any_of(context: Any, truths: Any) -> Any:
    """Whether one of four is true."""
    del context, truths

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(mask), generate


def _spread_number(context: Any, number: Any) -> Any:
    """The same number four times."""
    del context
    return pack(pack), lambda _, builder, signature, args: args[0]


def _chosen(context: Any, a: Any, b: Any, first: Any, second: Any, third: Any, fourth: Any) -> Any:
    """Four lanes of two packs, by literal numbers from 0 to 7."""
    del context
    numbers = (first, second, third, fourth)
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [getattr(k, "literal_value", 0) for k in numbers])

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.shuffle_vector(*args[:2], lanes)

    return pack(a, b, *numbers), generate


def _load(context: Any, array: Any, block: Any) -> Any:
    """Numbers `[4 block : 4 block + 4]` of a contiguous array."""
    del context

    def generate(target: Any, builder: Any, _: Any, args: Any) -> Any:
        return builder.load(_block(target, builder, array, *args), align=8)

    return pack(array, block), generate


def _store(context: Any, array: Any, block: Any, numbers: Any) -> Any:
    """Write numbers `[4 block : 4 block + 4]` of a contiguous array."""
    del context, numbers

    def generate(target: Any, builder: Any, _: Any, args: Any) -> Any:
        builder.store(args[2], _block(target, builder, array, *args[:2]), align=8)
        return target.get_dummy_value()

    return types.void(array, block, pack), generate


def _packed(context: Any, record: Any) -> Any:
    """Give a record whose fields (4,) are packs."""
    del context

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.PointerType(ir.IntType(8)))

    return PackedRecord(record)(record), generate


any_of: Any = intrinsic(_any_of)
chosen: Any = intrinsic(prefer_literal=True)(_chosen)
largest: Any = intrinsic(_largest)
load: Any = intrinsic(_load)
packed: Any = intrinsic(_packed)
spread: Any = intrinsic(_spread_number)
store: Any = intrinsic(_store)
total: Any = intrinsic(_total)


def _lanes(builder: Any, numbers: Any, *chosen: int) -> Any:
    lanes = ir.Constant(ir.VectorType(ir.IntType(32), len(chosen)), list(chosen))
    return builder.shuffle_vector(numbers, ir.Constant(numbers.type, ir.Undefined), lanes)


def _block(context: Any, builder: Any, kind: Any, array: Any, block: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    first = builder.mul(block, ir.Constant(block.type, WIDTH))
    return builder.bitcast(builder.gep(data, [first]), ir.PointerType(_NUMBERS))


@infer_getattr
class _Fields(AttributeTemplate):
    key = PackedRecord

    def generic_resolve(self, kind: Any, name: str) -> Any:  # type: ignore[override]
        """Type of a field: a pack, or a record of packs."""
        if name not in kind.record.fields:
            return None
        field = kind.record.typeof(name)
        return PackedRecord(field) if isinstance(field, types.Record) else pack


@lower_getattr_generic(PackedRecord)
def _read(context: Any, builder: Any, kind: Any, value: Any, name: str) -> Any:
    place = builder.gep(value, [context.get_constant(types.intp, kind.record.offset(name))])
    if isinstance(kind.record.typeof(name), types.Record):
        return place
    return builder.load(builder.bitcast(place, ir.PointerType(_NUMBERS)), align=8)


@lower_setattr_generic(PackedRecord)
def _write(context: Any, builder: Any, sig: Any, args: Any, name: str) -> None:
    kind, given = sig.args
    place = builder.gep(args[0], [context.get_constant(types.intp, kind.record.offset(name))])
    number = context.cast(builder, args[1], given, pack)
    builder.store(number, builder.bitcast(place, ir.PointerType(_NUMBERS)), align=8)
