"""References of an arm as they come: refused before anything moves where they are none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import real_array
from holonom.errors import LevelFault, ShapeError
from holonom.mechanics import Arm

__all__ = ["checked_reference"]

PARTS = ("position", "speed", "acceleration")


def checked_reference(arm: Arm, reference: Any) -> NDArray[np.float64]:
    """Return samples (3, ticks, n) for an arm's joints.

    Raises
    ------
    ShapeError
        Another shape.
    LevelFault
        One that is not finite; which.
    """
    quick = type(reference) is np.ndarray and reference.dtype == np.float64
    samples: NDArray[np.float64] = reference if quick else real_array("reference", reference)
    if samples.ndim != 3 or samples.shape[0] != 3 or samples.shape[2] != arm.n:
        raise ShapeError(
            f"reference has shape {samples.shape}; it must be (3, ticks, {arm.n}): positions, speeds and accelerations "
            f"of {arm.n} joints"
        )
    if not math.isfinite(np.vdot(samples, samples)) and not np.isfinite(samples).all():  # the first is quicker
        part, tick, axis = np.argwhere(~np.isfinite(samples))[0]
        raise LevelFault(
            f"reference: {PARTS[part]} of {arm.limits.names[axis]} at tick {tick} is {samples[part, tick, axis]}; "
            "finite numbers are needed"
        )
    return samples
