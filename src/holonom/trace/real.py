"""Numbers from a caller: an array of floats, or an error that says what came."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.errors import ShapeError

__all__ = ["real_array"]


def real_array(name: str, value: Any) -> NDArray[np.float64]:
    """Return `value` as float64.

    Raises
    ------
    ShapeError
        It holds something else than real numbers. NumPy alone would drop an imaginary part with no more than a warning.
    """
    try:
        given = np.asarray(value)
        if given.dtype.kind != "c":
            return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as problem:
        raise ShapeError(f"{name} holds something that is not a number: {problem}") from None
    raise ShapeError(f"{name} holds complex numbers; give real ones (its .real, if the rest is rounding)")
