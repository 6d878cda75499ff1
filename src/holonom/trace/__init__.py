"""The kernel compiler: equations over scalars, traced once, compiled to straight-line SIMD code.

================  =======================================================================
`compile`         equation -> `Kernel` (batch form, one-sample form, C pointer)
`sin`, `cos`, ... functions for equations; they work on floats and on traced scalars
`derivative`      forward and reverse mode on the graph
`cuda`            the same straight line for a GPU
`Graph`           the expression graph, simplified while it is built
`share`           parts of other work to threads; `check_threads`, `real_array`: what a caller gave
`cache_folder`    where machine code lies; `cache_use`, `empty_cache`
================  =======================================================================

Inside, in the order in which an equation goes through its rooms:

- `line`, from an equation to a straight line: `functions`, `graph`, `elementary`, `straight`; `lanes` lays the branches
  of an inverse side by side, `columns` makes the like columns of a result in a loop; `trigonometric` multiplies
  equations out into formulas, `arrays` runs them on NumPy arrays;
- `text`, to modules: `emit`; `generated` runs them;
- `code`, to machine code: `lower`, with `transpose` and `remainder` for the rows of a batch; `loops` compiles, `cache`
  keeps it by what `sources` say (and `bytecode`, Python's own);
- `call`: `pointer`; `direct`, `results` and `layout` are the way past Numba's dispatch, `batch` that of many rows;
  `crew` shares these among threads, with what is in `atomic`; `borrow` and `records` are for loops of steps.

Loops written by hand begin with `@loop` of `code.loops`; for them there are `code.compiled` (elementary functions) and
`code.simd` (four numbers as one).
"""

from holonom.arrays import real_array
from holonom.trace.call.threads import check_threads, share
from holonom.trace.code.cache import CacheUse, cache_folder, cache_use, empty_cache
from holonom.trace.kernel import Kernel, compile
from holonom.trace.line.functions import (
    absolute,
    atan2,
    cos,
    less,
    less_equal,
    maximum,
    minimum,
    select,
    sin,
    sqrt,
)
from holonom.trace.line.graph import Condition, Graph, Number, Scalar

__all__ = [
    "CacheUse",
    "Condition",
    "Graph",
    "Kernel",
    "Number",
    "Scalar",
    "absolute",
    "atan2",
    "cache_folder",
    "cache_use",
    "check_threads",
    "compile",
    "cos",
    "empty_cache",
    "less",
    "less_equal",
    "maximum",
    "minimum",
    "real_array",
    "select",
    "share",
    "sin",
    "sqrt",
]
