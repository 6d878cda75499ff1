"""Heydemann's correction: the ellipse of two signals back to a circle (P. Heydemann, Applied Optics 20, 1981, 3382)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from holonom.arrays import finite_array
from holonom.errors import CalibrationError
from holonom.trace.code.loops import loop

__all__ = ["SinCosCorrection", "correct_sincos", "fit_heydemann"]

WORST_CONDITION = 1e4
"""Of the fit, its columns scaled: beyond it the points lie on too little of the ellipse."""


class SinCosCorrection(NamedTuple):
    """Offsets of sine and cosine (V), amplitude of the sine over that of the cosine, phase the sine leads by (rad)."""

    sine_offset: float = 0.0
    cosine_offset: float = 0.0
    gain_ratio: float = 1.0
    phase_error: float = 0.0


@loop
def correct_sincos(correction: SinCosCorrection, sine: float, cosine: float) -> tuple[float, float]:
    """Sine and cosine (V) without offset, gain and phase errors; the cosine is the one that is trusted."""
    c = cosine - correction.cosine_offset
    s = (sine - correction.sine_offset) / correction.gain_ratio
    return (s - c * math.sin(correction.phase_error)) / math.cos(correction.phase_error), c


def fit_heydemann(sine: Any, cosine: Any) -> SinCosCorrection:
    """Fit the ellipse `A c^2 + B s^2 + C c s + D c + E s = 1` to signals over a period or more, by least squares.

    Parameters
    ----------
    sine, cosine : (n,), V, at whatever angles, n of at least 8.

    Returns
    -------
    The correction for `correct_sincos`.

    Raises
    ------
    CalibrationError
        Fewer points, points on too little of the ellipse, or on none.
    ShapeError, NotFinite
        Other shapes, values that are not finite.
    """
    s, c = finite_array("sine", sine, ("n",)), finite_array("cosine", cosine, ("n",))
    if len(s) != len(c) or len(s) < 8:
        raise CalibrationError(f"fit_heydemann: {len(s)} sines and {len(c)} cosines; 8 of each, or more, are needed")
    scale = float(np.sqrt(np.mean(s * s + c * c)))
    if scale == 0.0:
        raise CalibrationError("fit_heydemann: all signals are 0; turn the shaft by a line or more")
    x, y = c / scale, s / scale
    columns = np.column_stack([x * x, y * y, x * y, x, y])
    (A, B, C, D, E), _, rank, singular = np.linalg.lstsq(columns, np.ones_like(x), rcond=None)
    if rank < 5 or singular[0] > WORST_CONDITION * singular[-1] or 4.0 * A * B <= C * C or A <= 0.0:
        raise CalibrationError(
            "fit_heydemann: the points lie on no ellipse, or on too little of one; take them over a whole line"
        )
    below = C * C - 4.0 * A * B
    return SinCosCorrection(
        sine_offset=scale * float((2.0 * A * E - D * C) / below),
        cosine_offset=scale * float((2.0 * B * D - E * C) / below),
        gain_ratio=float(math.sqrt(A / B)),
        phase_error=-float(math.asin(C / math.sqrt(4.0 * A * B))),
    )
