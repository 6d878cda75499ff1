"""A gyro's scale and zero, from its rate beside a true heading."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.errors import CalibrationError, NotFinite, ShapeError

__all__ = ["GyroCalibration", "calibrate_gyro"]


SPAN = 1.0  # s over which rates are added up: angle random walk is white from span to span
FEWEST = 8  # spans
SURE = 0.1  # deviation of the scale above which the motion tells nothing of it


class GyroCalibration(NamedTuple):
    """A gyro that says `scale w + bias` at the turning rate w; deviations of both, rad/s for the bias."""

    scale: float
    bias: float
    scale_sigma: float
    bias_sigma: float


def calibrate_gyro(time: ArrayLike, rate: ArrayLike, heading: ArrayLike) -> GyroCalibration:
    """Calibrate a gyro by a true heading, over all spans of a second: `int rate dt = scale turn + bias span`.

    Parameters
    ----------
    time : (N,) s.
    rate : (N,) by the gyro, rad/s, each the mean since the sample before.
    heading : (N,) true, rad, without jumps.

    Raises
    ------
    CalibrationError
        Fewer spans than eight, or a base that turns too little, or always alike.
    ShapeError, NotFinite
    """
    t, w, theta = (np.asarray(values, dtype=np.float64) for values in (time, rate, heading))
    if t.ndim != 1 or not (t.shape == w.shape == theta.shape) or len(t) < 2:
        raise ShapeError(f"times {t.shape}, rates {w.shape}, headings {theta.shape} came; give as many of each")
    if not all(np.all(np.isfinite(values)) for values in (t, w, theta)):
        raise NotFinite("times, rates or headings hold NaN or infinity; repair the log")
    turned = np.concatenate([[0.0], np.cumsum(w[1:] * np.diff(t))])
    at = np.searchsorted(t, np.arange(t[0], t[-1], SPAN))
    if len(at) < FEWEST + 1:
        raise CalibrationError(f"{t[-1] - t[0]:.3g} s of a gyro came; give {FEWEST + 1} or more, with turns both ways")
    A = np.stack([np.diff(theta[at]), np.diff(t[at])], axis=1)
    seen = np.diff(turned[at])
    normal = A.T @ A
    if np.linalg.cond(normal) > 1e12:
        raise CalibrationError("the base turns always alike, which tells nothing of a gyro's scale; turn to both sides")
    found = np.linalg.solve(normal, A.T @ seen)
    left = seen - A @ found
    covariance = float(left @ left) / (len(seen) - 2) * np.linalg.inv(normal)
    sigma = np.sqrt(np.diagonal(covariance))
    if sigma[0] > SURE:
        raise CalibrationError("the base turns too little to tell a gyro's scale; turn to both sides, several times")
    return GyroCalibration(float(found[0]), float(found[1]), float(sigma[0]), float(sigma[1]))
