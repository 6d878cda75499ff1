"""How a base evaluates its equations: the first few samples as NumPy arrays, then all by a compiled kernel."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.errors import ShapeError
from holonom.trace import Kernel, check_threads, compile
from holonom.trace.line.arrays import ArrayEquation, on_arrays

__all__ = ["BaseEquation", "product", "written"]

COMPILE_FROM = 512
"""Samples, over all calls, from which on a kernel is compiled: a base asked a few times costs no compilation."""
CALL = 16
"""Samples that a call counts for at least: a loop that calls for one sample each is compiled after 32 calls."""


def written(result: Array, out: Array | None) -> Array:
    """Return the result, in `out` where that is given."""
    if out is None:
        return result
    if not isinstance(out, np.ndarray) or out.shape != result.shape or out.dtype != np.float64:
        came = f"{out.dtype} {out.shape}" if isinstance(out, np.ndarray) else type(out).__name__
        raise ShapeError(f"out= must be a float64 array of shape {result.shape}; {came} came")
    out[...] = result
    return out


def product(rows: Array, matrix: Array, out: Array | None) -> Array:
    """`rows @ matrix`, in `out` where that is given."""
    if isinstance(out, np.ndarray) and out.dtype == np.float64 and out.shape == (*rows.shape[:-1], matrix.shape[1]):
        np.matmul(rows, matrix, out=out)
        return out
    return written(rows @ matrix, out)


class BaseEquation:
    """An equation over samples; inputs and outputs are name -> numbers per sample."""

    def __init__(
        self, equation: Callable[..., Sequence[Any]], inputs: Mapping[str, int], outputs: Mapping[str, int], name: str
    ) -> None:
        self.equation, self.inputs, self.outputs, self.name = equation, dict(inputs), dict(outputs), name
        self._asked = 0

    @functools.cached_property
    def kernel(self) -> Kernel:
        """The compiled form."""
        only = len(self.outputs) == 1
        take = (lambda *a: self.equation(*a)[0]) if only else self.equation
        return compile(take, self.inputs, self.outputs, name=self.name, few=0)

    @functools.cached_property
    def _arrays(self) -> ArrayEquation:
        return on_arrays(lambda *a: [x for output in self.equation(*a) for x in output], self.inputs)

    def __call__(self, *arrays: ArrayLike, out: Array | None = None, threads: int = 1) -> tuple[Array, ...]:
        """Evaluate; `out` takes the first output."""
        if self._asked < COMPILE_FROM:
            sizes = (np.size(a) // max(w, 1) for a, w in zip(arrays, self.inputs.values(), strict=True))
            self._asked += max(CALL, *sizes)
        if self._asked >= COMPILE_FROM:
            return self._batch(arrays, out, threads)
        check_threads(threads)
        given = [vectors(n, a, w) for (n, w), a in zip(self.inputs.items(), arrays, strict=True)]
        try:
            lead = np.broadcast_shapes(*(a.shape[:-1] for a in given))
        except ValueError:
            named = ", ".join(f"{n} {a.shape}" for n, a in zip(self.inputs, given, strict=True))
            raise ShapeError(f"leading axes do not go together: {named}") from None
        rows = [np.broadcast_to(a, (*lead, a.shape[-1])).reshape(-1, a.shape[-1]) for a in given]
        edges = np.cumsum(list(self.outputs.values()))
        found = [p.reshape(*lead, p.shape[-1]) for p in np.split(self._arrays(*rows), edges[:-1], axis=1)]
        return (written(found[0], out), *found[1:])

    def _batch(self, arrays: Sequence[ArrayLike], out: Array | None, threads: int) -> tuple[Array, ...]:
        if len(self.outputs) == 1:
            return (self.kernel(*arrays, out=out, threads=threads),)
        if out is None:
            return self.kernel(*arrays, threads=threads)
        rest = [np.empty((*out.shape[:-1], width)) for width in list(self.outputs.values())[1:]]
        return self.kernel(*arrays, out=(out, *rest), threads=threads)
