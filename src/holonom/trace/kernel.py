"""From an equation to a compiled kernel."""

from __future__ import annotations

import dataclasses
import functools
import keyword
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import REVOLUTION, real_array
from holonom.errors import InputError, ShapeError
from holonom.trace.call.refusals import name_inputs, name_results
from holonom.trace.call.threads import check_threads
from holonom.trace.line.columns import Columns, columns_of
from holonom.trace.line.graph import Graph, Scalar, live_nodes, turning_inputs
from holonom.trace.line.lanes import lanes_of
from holonom.trace.line.straight import Field, operand, straight_line
from holonom.trace.text.emit import TAKEN, Parts, emit_block, emit_made, emit_pointer, emit_single
from holonom.trace.text.generated import load_module

if TYPE_CHECKING:
    from holonom.trace.call.batch import Batch

__all__ = ["Kernel", "compile"]

WORTH = 100_000
"""Operations of all rows that a thread is woken for."""
FEW = 2000
"""Rows, over all calls, up to which the one-sample form takes them: to compile that of a batch takes longer."""
Array = NDArray[Any]
Shape = int | tuple[int, ...]


def compile(
    equation: Callable[..., Any],
    inputs: Mapping[str, Shape],
    outputs: Mapping[str, Shape],
    *,
    name: str,
    integers: Sequence[str] = (),
    branches: bool = False,
    columns: Callable[..., Any] | None = None,
    result: Callable[..., Any] | None = None,
    few: int | None = None,
    checked: bool = False,
) -> Kernel:
    """Trace an equation once and return its kernel; machine code is made on first use, or loaded from the cache.

    Parameters
    ----------
    equation
        Function of one sequence of scalars per input; an input of shape (r, c) comes as a flat sequence of r*c
        numbers, row by row. It returns one flat sequence per output (for one output: that sequence itself).
    inputs, outputs
        Name -> shape of one sample: 6, or (4, 4).
    name
        Title and file name of the generated module.
    integers
        Outputs that hold small integers and are stored as int8.
    branches
        The outputs have a row per branch, all by like equations: one sample's branches then run side by side.
    columns
        The outputs are made column by column, as their last axes count them: `columns(shared, own)` gives one column of
        each, of what `equation` then returns instead of outputs: a flat sequence that all columns share, and rows of
        numbers, one for each column. Written out, they would be a line too long to compile.
    result
        Of several outputs, what a call returns: a function of their arrays, in order, that gives a tuple which begins
        with them (perhaps viewed as another type). By default a plain tuple.
    few
        Rows, over all calls, from which on the batch form is compiled; by default 2,000.
    checked
        A result that is not finite is an error: for equations that divide by what may be 0.

    Raises
    ------
    InputError
        An input or output has a name that Python or the kernel's text needs.
    ShapeError
        The equation gives another count of numbers than was declared.
    """
    graph = Graph()
    ins = [_field(key, shape, key in integers) for key, shape in inputs.items()]
    outs = [_field(key, shape, key in integers) for key, shape in outputs.items()]
    outs = [dataclasses.replace(f, checked=checked and not f.integer) for f in outs]
    raw = equation(*([graph.input(f.name, k) for k in range(f.width)] for f in ins))
    values = [raw] if len(outs) == 1 and columns is None else list(raw)
    loop = columns_of(name, columns, len(values[0]), len(values[1]), outs) if columns else None
    results: dict[str, list[Scalar]] = {}
    for f, value in zip(loop.given if loop else outs, values, strict=True):
        scalars = [v if isinstance(v, Scalar) else graph.constant(float(v)) for v in value]
        if len(scalars) != f.width:
            raise ShapeError(f"equation {name!r} gives {len(scalars)} numbers for {f.name!r}; {f.width} were declared")
        results[f.name] = scalars
    return Kernel(name, tuple(ins), tuple(outs), graph, results, branches, loop, result or _plain, few)


def _apart(rows: Sequence[Array], results: Sequence[Array]) -> Sequence[Array]:
    """The rows, copied where a result may share their memory; two arrays that own theirs do not."""
    found = list(rows)
    for result in results:
        own = result.flags.owndata
        for k, r in enumerate(found):
            if r is result or (not (own and r.flags.owndata) and np.may_share_memory(r, result)):
                found[k] = r.copy()
    return found


def _plain(*arrays: Array) -> Any:
    return arrays if len(arrays) > 1 else arrays[0]


def _field(name: str, shape: Shape, integer: bool) -> Field:
    if not name.isidentifier() or name.startswith("_") or keyword.iskeyword(name) or name in TAKEN:
        raise InputError(f"{name!r} cannot be the name of an input or output: it is a word of Python or of the kernel")
    return Field(name, (shape,) if isinstance(shape, int) else tuple(shape), integer)


class Kernel:
    """A compiled equation of one robot.

    Call it with one array per input: one sample each (its own shape) or a batch of rows (leading axes before it).
    `kernel.single(in1, ..., out1, ...)` is the fastest way for one sample: C-contiguous float64 arrays of exactly the
    declared shapes, outputs given; it returns 0, 1 (something else came) 2 (NaN or infinity among the inputs, or
    numbers beyond their bounds) or 3 (the result is not finite, where that is checked).
    """

    def __init__(
        self,
        name: str,
        inputs: tuple[Field, ...],
        outputs: tuple[Field, ...],
        graph: Graph,
        results: Mapping[str, list[Scalar]],
        branches: bool = False,
        columns: Columns | None = None,
        result: Callable[..., Any] = _plain,
        few: int | None = None,
    ) -> None:
        turning = turning_inputs(graph, live_nodes(graph, [s for values in results.values() for s in values]))
        bounded = tuple(dataclasses.replace(f, bound=REVOLUTION) if f.name in turning else f for f in inputs)
        self.name, self.inputs, self.outputs, self.result = name, bounded, outputs, result
        self._body = straight_line(graph, [s for values in results.values() for s in values])
        self._results = {key: [operand(graph, s.i) for s in values] for key, values in results.items()}
        self.columns = columns
        lanes = functools.partial(lanes_of, graph, outputs, results) if branches else lambda: columns
        self._parts: Callable[[], Parts | None] = functools.cache(lanes)
        self._axes = 1 + len(inputs[0].shape)
        self._few = FEW if few is None else few
        self._made_of = graph, results, branches, columns, result, few
        self._allocate = [(f.shape, np.dtype(np.int8 if f.integer else np.float64)) for f in outputs]

    @property
    def operations(self) -> int:
        """Live operations after simplification; those of a column count for each."""
        return len(self._body) + (self.columns.count * len(self.columns.body) if self.columns else 0)

    @functools.cached_property
    def reads(self) -> tuple[str, ...]:
        """Names of the inputs that any output depends on."""
        text = " ".join([*self._body, *(value for values in self._results.values() for value in values)])
        words = {word.rpartition("_")[0] for word in re.findall(r"\w+_\d+", text)}
        return tuple(f.name for f in self.inputs if f.name in words)

    def without(self, names: Sequence[str]) -> Kernel:
        """Return the kernel without some inputs, on which no output may depend."""
        return Kernel(self.name, tuple(f for f in self.inputs if f.name not in names), self.outputs, *self._made_of)

    @property
    def source(self) -> str:
        """Readable text of the one-sample form."""
        return self.text(emit_single, self._parts())

    @property
    def block_source(self) -> str:
        """Readable text of the batch form."""
        return self.text(emit_block, self.columns)

    def text(self, emit: Callable[..., str], *more: Any) -> str:
        """Text of another form, written by `emit(title, body, inputs, outputs, results, *more)`."""
        return emit(self.name, self._body, self.inputs, self.outputs, self._results, *more)

    @functools.cached_property
    def single(self) -> Callable[..., int]:
        """The compiled one-sample form (see the class)."""
        return load_module(f"{self.name}_single", self.source).single

    @functools.cached_property
    def made(self) -> Callable[..., Any]:
        """The compiled one-sample form that makes its result: `made(in1, ..., like)` or None (see `emit_made`)."""
        return load_module(f"{self.name}_made", self.text(emit_made, self._parts())).made

    @functools.cached_property
    def rows(self) -> int:
        """Address of the batch form in C: `rows(places, first, last)` (see `emit_block`)."""
        return load_module(f"{self.name}_rows", self.text(emit_block, self.columns)).rows.address

    @functools.cached_property
    def _batch(self) -> Batch:
        from holonom.trace.call.batch import Batch  # heavy, and not needed for what is read only

        likes = [np.empty((1, *f.shape), np.int8 if f.integer else np.float64) for f in (*self.inputs, *self.outputs)]
        return Batch(self.rows, len(self.inputs), tuple(likes), WORTH // max(self.operations, 1) + 1)

    @functools.cached_property
    def address(self) -> int:
        """Address of the C form `void(double* inputs, double* outputs)`, for compiled loops over any robot."""
        return load_module(f"{self.name}_pointer", self.text(emit_pointer, self._parts())).pointer.address

    def __call__(self, *arrays: Any, out: Any = None, threads: int = 1) -> Any:
        """Evaluate one sample or a batch.

        Parameters
        ----------
        *arrays
            One per input, `(..., *shape)`; leading axes broadcast.
        out
            Array (or tuple of arrays, for several outputs) to write into, C-contiguous, of the result's shape; it may
            share memory with an input.
        threads
            Threads that share a batch, 1 or more.

        Returns
        -------
        The output array, or a tuple of them, as `compile` was told.

        Raises
        ------
        ShapeError
            Wrong shape or type; `NotFinite`: NaN or infinity. The message names the input and the row.
        OutOfLimits
            An angle beyond 1e15 rad, any number beyond 1e100.
        InputError
            `threads` is no whole number of at least 1.
        """
        if len(arrays) != len(self.inputs):
            raise ShapeError(
                f"{self.name} takes {len(self.inputs)} arrays ({', '.join(f.name for f in self.inputs)}); "
                f"{len(arrays)} came"
            )
        return self.call(*arrays, out=out, threads=threads)

    @functools.cached_property
    def call(self) -> Callable[..., Any]:
        """Calling the kernel, as a plain function: Python's way to `__call__` costs as much as a small kernel."""
        return _caller(self)

    def general(self, arrays: Sequence[Any], out: Any, threads: int) -> Any:
        """Evaluate whatever the one-sample forms did not take: rows as they are, all else after a closer look."""
        threads = check_threads(threads)
        if self._few > 0:
            first = arrays[0]
            if not (type(first) is np.ndarray and first.ndim == self._axes and len(first) > self._few):
                return self._slowly(arrays, out, threads)
            self._few = 0
        results = self._results_of(arrays) if out is None else out if isinstance(out, tuple) else (out,)
        if results is not None and self._batch.quick((*arrays, *results), threads):
            return self.result(*results)
        return self._slowly(arrays, out, threads)

    def _results_of(self, arrays: Sequence[Any]) -> tuple[Array, ...] | None:
        """Room for the results, if the inputs are an array for each that has rows."""
        first = arrays[0]
        if type(first) is not np.ndarray or first.ndim != self._axes:
            return None
        count = len(first)
        return tuple([np.empty((count, *shape), dtype) for shape, dtype in self._allocate])

    def _slowly(self, arrays: Sequence[Any], out: Any, threads: int) -> Any:
        """Check, broadcast and evaluate anything."""
        rows, lead = self._rows_of(arrays)
        count = len(rows[0])
        if out is None:
            results = [np.empty((*lead, *shape), dtype) for shape, dtype in self._allocate]
        else:
            results = list(out if isinstance(out, tuple) else (out,))
            self._check_out(results, lead)
            # What is written must not be read any more, nor named as not finite.
            rows = _apart(rows, results)
        self._few -= count
        fine = self._one_by_one(rows, results, count) if self._few > 0 else None
        if fine is None:
            fine = self._batch.run((*rows, *results), count, threads)
        if count and not fine:
            name_inputs(self.inputs, rows, lead)
            name_results(self.name, self.outputs, results, lead)
        return self.result(*results)

    def _one_by_one(self, rows: Sequence[Array], results: Sequence[Array], count: int) -> bool | None:
        """Evaluate rows by the one-sample form: whether all inputs were finite; None if it cannot read these arrays."""
        shaped = zip((*self.inputs, *self.outputs), (*rows, *results), strict=True)
        every = [(a.reshape(count, f.width), f.shape) for f, a in shaped]
        fine = True
        for k in range(count):
            status = self.single(*(a[k].reshape(shape) for a, shape in every))
            if status:
                if status == 1:
                    return None
                fine = False
        return fine

    def _rows_of(self, arrays: Sequence[Any]) -> tuple[Sequence[Array], tuple[int, ...]]:
        """Return the inputs as C-contiguous rows (N, width) and the leading axes they share."""
        given = [real_array(f.name, a) for f, a in zip(self.inputs, arrays, strict=True)]
        for f, a in zip(self.inputs, given, strict=True):
            if a.shape[max(a.ndim - len(f.shape), 0) :] != f.shape:
                wanted = ", ".join(["...", *map(str, f.shape)])
                raise ShapeError(f"{f.name} has shape {a.shape}; ({wanted}) is needed")
        leads = [a.shape[: a.ndim - len(f.shape)] for f, a in zip(self.inputs, given, strict=True)]
        try:
            lead = np.broadcast_shapes(*leads)
        except ValueError:
            named = ", ".join(f"{f.name} {a.shape}" for f, a in zip(self.inputs, given, strict=True))
            raise ShapeError(f"leading axes do not go together: {named}") from None
        count = math.prod(lead)
        rows = []
        for f, a in zip(self.inputs, given, strict=True):
            whole = a if a.shape == (*lead, *f.shape) else np.broadcast_to(a, (*lead, *f.shape))
            rows.append(np.require(whole.reshape(count, f.width), requirements=["C", "A"]))
        return rows, lead

    def _check_out(self, results: Sequence[Any], lead: tuple[int, ...]) -> None:
        if len(results) != len(self.outputs):
            raise ShapeError(f"out= takes {len(self.outputs)} arrays for {self.name}; {len(results)} came")
        for f, r, (shape, dtype) in zip(self.outputs, results, self._allocate, strict=True):
            good = isinstance(r, np.ndarray) and r.shape == (*lead, *shape) and r.dtype == dtype
            if not good or not r.flags.carray:
                came = f"{r.dtype} {r.shape}" if isinstance(r, np.ndarray) else type(r).__name__
                raise ShapeError(
                    f"out= for {f.name} must be a writeable C-contiguous {dtype} array of shape {(*lead, *shape)}, "
                    f"aligned in memory; {came} came"
                )


CALL = """
def call({inputs}, /, *, out=None, threads=1):
    if threads == 1:
        if out is None:
            found = made({inputs}, like)
            if found is not None:
                return found
        else:
            try:
                if single({inputs}, {outputs}) == 0:
                    return result({outputs})
            except TypeError:  # not as many arrays as outputs
                pass
    return general(({inputs},), out, threads)
"""


def _caller(kernel: Kernel) -> Callable[..., Any]:
    """One sample at once, or else the general way; written out, for loops over arguments cost as much as a kernel.

    The compiled forms are loaded when the first sample comes: who has batches only needs none of them.
    """

    def load(form: str, otherwise: Any) -> Callable[..., Any]:
        def first(*arguments: Any) -> Any:
            if getattr(arguments[0], "ndim", None) != len(kernel.inputs[0].shape):
                return otherwise
            names[form] = getattr(kernel, form)
            return names[form](*arguments)

        return first

    like = kernel.result(*(np.empty(shape, kind) for shape, kind in kernel._allocate))
    names = {"like": like, "result": kernel.result, "general": kernel.general}
    names |= {"made": load("made", None), "single": load("single", 1)}
    text = CALL.format(
        inputs=", ".join(f"in{k}" for k in range(len(kernel.inputs))),
        outputs="out" if len(kernel.outputs) == 1 else "*out",
    )
    exec(text, names)
    call: Callable[..., Any] = names["call"]
    return call
