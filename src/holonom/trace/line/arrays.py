"""A traced equation over NumPy arrays: nothing is compiled, so it suits equations that are evaluated a few times."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.trace.line.graph import Graph, Scalar, live_nodes

__all__ = ["ArrayEquation", "on_arrays"]

CHUNK = 256  # rows at a time: every node of the graph holds one array of this length

_FUNCTIONS: Mapping[object, Callable[..., Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "neg": np.negative,
    "sin": np.sin,
    "cos": np.cos,
    "sqrt": np.sqrt,
    "abs": np.abs,
    "atan2": np.arctan2,
    "<": np.less,
    "<=": np.less_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "select": np.where,
}


def on_arrays(equation: Callable[..., Iterable[Any]], inputs: Mapping[str, int]) -> ArrayEquation:
    """Trace an equation once and return it as a function of arrays.

    Parameters
    ----------
    equation : function of one sequence of scalars per input that returns a flat sequence.
    inputs : name -> numbers per sample.
    """
    graph = Graph()
    found = equation(*([graph.input(name, k) for k in range(width)] for name, width in inputs.items()))
    outputs = [v if isinstance(v, Scalar) else graph.constant(float(v)) for v in found]
    return ArrayEquation(tuple(inputs), graph, outputs)


class ArrayEquation:
    """A traced equation: call it with one array (N, width) per input, in their order; returns (N, outputs)."""

    def __init__(self, inputs: tuple[str, ...], graph: Graph, outputs: list[Scalar]) -> None:
        self.inputs, self._graph, self._outputs = inputs, graph, outputs
        self._live = live_nodes(graph, outputs)

    def __call__(self, *arrays: Array) -> Array:
        """Evaluate rows; they are not checked."""
        count = arrays[0].shape[0]
        result = np.empty((count, len(self._outputs)))
        for first in range(0, count, CHUNK):
            rows: dict[object, Array] = {
                name: a[first : first + CHUNK] for name, a in zip(self.inputs, arrays, strict=True)
            }
            self._evaluate(rows, result[first : first + CHUNK])
        return result

    def _evaluate(self, rows: Mapping[object, Array], result: Array) -> None:
        values: dict[object, Any] = {}
        for i in self._live:
            op, *a = self._graph.ops[i]
            if op == "in":
                values[i] = rows[a[0]][:, a[1]]  # type: ignore[index]
            elif op == "const":
                values[i] = a[0]
            else:
                values[i] = _FUNCTIONS[op](*(values[k] for k in a))
        for k, out in enumerate(self._outputs):
            result[:, k] = values[out.i]
