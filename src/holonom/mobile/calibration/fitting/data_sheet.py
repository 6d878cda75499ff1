"""What the data sheet adds to what runs tell: nominal numbers are measurements too.

A few runs tell some numbers hardly better than the data sheet does, and least squares alone puts into them whatever the
wheels slipped that day: it fits those runs and is worse on others. Here nominal lengths count as measured, with the
tolerances below, all of them wider by one factor t that the runs themselves show: where they go with the data sheet, it
holds what they do not tell; where they contradict it by much, it counts for nothing.
"""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.mobile.calibration.parameters import Parameters

__all__ = ["BATCH", "EACH", "FOREIGN", "LENGTH", "informed"]

BATCH, EACH = 2e-3, 1e-3
"""Standard deviation of diameters, as a share: of all wheels together (load, wear), and of each by itself."""
LENGTH = 9e-3
"""Of tracks, wheelbases, levers, as a share: a tyre touches the floor nobody knows where across its width.

Round numbers of what workshops keep, that of lengths between 0.8 and 1 % where OptiOdom's sets told of each other best.
"""
_SIZES = ("diameter", "radius")
_LENGTHS = ("wheelbase", "track", "wheel_distance", "lever")
_DOUBTS = np.geomspace(0.02, 200.0, 160)  # factors t
FOREIGN = 1.5
"""Factor beyond which the data sheet is taken for that of another robot, and says nothing."""


def informed(parameters: Parameters, x: Array, covariance: Array) -> tuple[Array, float]:
    """Scaled parameters (p,) by runs and data sheet, and how many times wider than usual its tolerances came out.

    Parameters
    ----------
    x, covariance : (p,), (p, p) by the runs alone.

    Returns
    -------
    (p,) parameters; NaN for the factor where the data sheet says nothing.

    Notes
    -----
    For one t a linear update of Gaussian numbers; the mean over t, with `t^2` inverse gamma of shape and rate 1 (so
    nominal numbers scatter as Student's t with two degrees of freedom), weighted by how well t explains x (Gelman et
    al., *Bayesian Data Analysis*, 5.5). Angles, effective tracks, and places of wheels and of the truth's frame are no
    numbers of a data sheet: it says nothing of them but what follows from the others.

    Nobody vouches for a data sheet: deviations are to stay those of the runs alone.
    """
    Q = _tolerances(parameters)
    stated = np.diagonal(Q) > 0.0
    if not stated.any():
        return x, float("nan")
    Q, xs = Q[np.ix_(stated, stated)], x[stated]
    C, Cs = covariance[:, stated], covariance[np.ix_(stated, stated)]
    found, fit = [], []
    for t in _DOUBTS:
        S = Cs + t**2 * Q
        by_sheet = np.linalg.solve(S, xs)
        found.append(x - C @ by_sheet)
        prior = -2.0 * np.log(t) - 1.0 / t**2  # of log t
        fit.append(prior - 0.5 * (np.linalg.slogdet(S)[1] + xs @ by_sheet))
    w = np.exp(np.array(fit) - max(fit))
    w /= w.sum()
    doubt = float(np.exp(w @ np.log(_DOUBTS)))
    return (w @ np.array(found) if doubt < FOREIGN else x), doubt


def _tolerances(parameters: Parameters) -> Array:
    """Covariance (p, p) of the scaled parameters by the data sheet; zero where it says nothing."""
    share = np.where(parameters.scale > 0.0, parameters.nominal / parameters.scale, 0.0)
    size = np.array([name.startswith(_SIZES) for name in parameters.names])
    length = np.array([name.startswith(_LENGTHS) for name in parameters.names])
    Q = BATCH**2 * np.outer(size, size) + np.diag(EACH**2 * size + LENGTH**2 * length)
    return np.asarray(Q * np.outer(share, share))
