"""Rows of numbers in memory to vectors of one column each, and back: what a batch costs beside its arithmetic.

A row is cut into pieces of 4, 2 and 1 numbers, none longer than a vector. Pieces of so many rows are loaded side by
side and transposed in registers, so that a vector holds one number of every row; storing goes the same way back.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["across", "itemsize", "load_columns", "splat", "store_columns"]

DOUBLE, INDEX, LONG = ir.DoubleType(), ir.IntType(32), ir.IntType(64)

TOGETHER = 16
"""Columns of a row that are written together, a multiple of the pieces (measured: as fast as 8, faster than 48)."""


def load_columns(builder: Any, rows: Any, width: int, lanes: int) -> list[Any]:
    """Return `width` vectors: number k of the `lanes` rows that start at the pointer `rows`."""
    columns: list[Any] = []
    for first, size in _pieces(width, lanes):
        vectors = []
        for k in range(size):
            mine = [_piece(builder, rows, DOUBLE, width * row + first, size) for row in range(k, lanes, size)]
            vectors.append(_joined(builder, [builder.load(place, align=itemsize(DOUBLE)) for place in mine]))
        columns += _transposed(builder, vectors, size, lanes)
    return columns


def store_columns(builder: Any, rows: Any, columns: Sequence[Any], lanes: int, width: int | None = None) -> None:
    """Store vectors as `load_columns` would find them; of numbers of any type, in rows that may be wider.

    Row after row, for memory is written in whole lines; of wide rows `TOGETHER` columns after as many, for registers
    hold only so many.
    """
    kind = columns[0].type.element
    width = width or len(columns)
    for some in range(0, len(columns), TOGETHER):
        pieces = [
            (first, size, _transposed(builder, columns[first : first + size], size, lanes))
            for first, size in _pieces(len(columns), lanes)
            if some <= first < some + TOGETHER
        ]
        for row in range(lanes):
            for first, size, vectors in pieces:
                k, at = row % size, row // size * size
                part = _shuffled(builder, vectors[k], vectors[k], range(at, at + size))
                place = _piece(builder, rows, kind, width * row + first, size)
                builder.store(part, place, align=itemsize(kind))


def _across(context: Any, found: Any, rows: Any, start: Any, first: Any, width: Any, count: Any, lanes: Any) -> Any:
    """Numbers first, ..., first + count - 1 of all lanes, `found` (width, lanes) flat, to the rows from `start` on."""
    wide, together, many = (each.literal_value for each in (width, count, lanes))

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        source, target = (
            ctx.make_array(kind)(ctx, builder, value).data
            for kind, value in zip(signature.args[:2], args[:2], strict=True)
        )
        held, vector = ctx.get_data_type(rows.dtype), ir.VectorType(DOUBLE, many)
        columns = []
        for k in range(together):
            place = builder.mul(builder.add(args[3], LONG(k)), LONG(many))
            where = builder.bitcast(builder.gep(source, [place], source_etype=DOUBLE), vector.as_pointer())
            value = builder.load(where, typ=vector, align=itemsize(DOUBLE))
            columns.append(value if held == DOUBLE else builder.fptosi(value, ir.VectorType(held, many)))
        place = builder.add(builder.mul(args[2], LONG(wide)), args[3])
        store_columns(builder, builder.gep(target, [place], source_etype=held), columns, many, wide)
        return ctx.get_dummy_value()

    return types.void(found, rows, types.int64, types.int64, width, count, lanes), generate


across: Any = intrinsic(prefer_literal=True)(_across)
"""`across(found, rows, start, first, width, count, lanes)`: numbers of which all lanes lie together, into rows."""


def itemsize(kind: Any) -> int:
    """Bytes of a number of an LLVM type, which are its alignment too."""
    return 8 if kind == DOUBLE else kind.width // 8


def splat(builder: Any, value: Any, lanes: int) -> Any:
    """A vector of which every lane is the value."""
    first = builder.insert_element(ir.Constant(ir.VectorType(value.type, lanes), ir.Undefined), value, INDEX(0))
    return _shuffled(builder, first, first, [0] * lanes)


def _pieces(width: int, lanes: int) -> Iterator[tuple[int, int]]:
    """First column and number of columns of each piece."""
    first = 0
    while first < width:
        size = next(size for size in (4, 2, 1) if size <= min(lanes, width - first))
        yield first, size
        first += size


def _piece(builder: Any, rows: Any, kind: Any, place: int, size: int) -> Any:
    """Pointer to so many numbers from a place on."""
    where = builder.gep(rows, [LONG(place)], source_etype=kind)
    return builder.bitcast(where, ir.VectorType(kind, size).as_pointer())


def _joined(builder: Any, parts: Sequence[Any]) -> Any:
    """Vectors end to end; their number is a power of two."""
    while len(parts) > 1:
        both = range(2 * parts[0].type.count)
        parts = [_shuffled(builder, a, b, both) for a, b in zip(parts[::2], parts[1::2], strict=True)]
    return parts[0]


def _transposed(builder: Any, vectors: Sequence[Any], size: int, lanes: int) -> list[Any]:
    """Transpose every square of `size` vectors and as many neighbouring lanes."""
    made, step = list(vectors), 1
    while step < size:
        low = [lane if not lane & step else lanes + lane - step for lane in range(lanes)]
        high = [lane + step if not lane & step else lanes + lane for lane in range(lanes)]
        for k in range(size):
            if not k & step:
                a, b = made[k], made[k + step]
                made[k], made[k + step] = _shuffled(builder, a, b, low), _shuffled(builder, a, b, high)
        step *= 2
    return made


def _shuffled(builder: Any, a: Any, b: Any, lanes: Sequence[int]) -> Any:
    """The lanes named, counted through `a` and then `b`."""
    mask = ir.Constant(ir.VectorType(INDEX, len(lanes)), [INDEX(k) for k in lanes])
    return builder.shuffle_vector(a, b, mask)
