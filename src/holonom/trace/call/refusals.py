"""What was wrong with the numbers of a kernel that says that something was."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holonom.arrays import Array, too_large
from holonom.errors import NotFinite, OutOfLimits
from holonom.trace.line.straight import Field

__all__ = ["name_inputs", "name_results"]


def name_inputs(inputs: Sequence[Field], rows: Sequence[Array], lead: tuple[int, ...]) -> None:
    """Refuse inputs (N, width) that are not finite or exceed their bound; the rows count along the axes `lead`."""
    for f, a in zip(inputs, rows, strict=True):
        bad = np.argwhere(~np.isfinite(a))
        if bad.size:
            row, slot = bad[0]
            raise NotFinite(f"{f.name}[{slot}] is {a[row, slot]}{_place(row, lead)}; finite numbers are needed")
        with np.errstate(over="ignore"):
            far = np.argwhere(~(np.sum(a * a, axis=1) <= f.bound**2))
        if far.size:
            row = far[0, 0]
            slot = int(np.argmax(np.abs(a[row])))
            raise OutOfLimits(
                f"{f.name}[{slot}] is {a[row, slot]:g}{_place(row, lead)}: beyond {f.bound:g} "
                f"{too_large(f.bound)}; give less"
            )


def name_results(kernel: str, outputs: Sequence[Field], results: Sequence[Array], lead: tuple[int, ...]) -> None:
    """Refuse checked results that are not finite."""
    for f, result in zip(outputs, results, strict=True):
        if not f.checked:
            continue
        a = result.reshape(-1, f.width)
        bad = np.argwhere(~np.isfinite(a))
        if bad.size:
            row, slot = bad[0]
            raise NotFinite(
                f"{f.name}[{slot}] of {kernel} would be {a[row, slot]}{_place(row, lead)}: "
                "it is not defined for these inputs, where the equation divides by 0"
            )


def _place(row: int, lead: tuple[int, ...]) -> str:
    return f" in row {tuple(int(k) for k in np.unravel_index(row, lead))}" if lead else ""
