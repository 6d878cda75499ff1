"""What the data sheet adds to what runs tell: nominal numbers are measurements too.

A few runs tell some numbers hardly better than the data sheet does, and least squares alone puts into them whatever the
wheels slipped that day: it fits those runs and is worse on others. Here nominal lengths count as measured, with the
tolerances below, all of them wider by one factor t that the runs themselves show: where they go with the data sheet, it
holds what they do not tell; where they contradict it by much, it counts for nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.mobile.calibration.parameters import Parameters

__all__ = ["BATCH", "EACH", "FOREIGN", "LENGTH", "Informed", "informed"]

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


@dataclass(frozen=True, slots=True)
class Informed:
    """What runs and data sheet tell together.

    Attributes
    ----------
    x : (p,) scaled parameters.
    covariance : (p, p) of them.
    doubt : how many times wider than usual the data sheet's tolerances came out; NaN where it says nothing.
    """

    x: Array
    covariance: Array
    doubt: float


def informed(parameters: Parameters, x: Array, covariance: Array) -> Informed:
    """Parameters by runs, x (p,) scaled, with their covariance (p, p), and by the data sheet.

    Notes
    -----
    For one t a linear update of Gaussian numbers; the mean over t, with `t^2` inverse gamma of shape and rate 1 (so
    nominal numbers scatter as Student's t with two degrees of freedom), weighted by how well t explains x (Gelman et
    al., *Bayesian Data Analysis*, 5.5). Angles, effective tracks, and places of wheels and of the truth's frame are no
    numbers of a data sheet: it says nothing of them but what follows from the others.
    """
    Q = _tolerances(parameters)
    stated = np.diagonal(Q) > 0.0
    if not stated.any():
        return Informed(x, covariance, float("nan"))
    Q, xs = Q[np.ix_(stated, stated)], x[stated]
    C, Cs = covariance[:, stated], covariance[np.ix_(stated, stated)]
    xt, Ct, fit = [], [], []
    for t in _DOUBTS:
        S = Cs + t**2 * Q
        K = np.linalg.solve(S, C.T).T
        xt.append(x - K @ xs)
        Ct.append(covariance - K @ C.T)
        prior = -2.0 * np.log(t) - 1.0 / t**2  # of log t
        fit.append(prior - 0.5 * (np.linalg.slogdet(S)[1] + xs @ np.linalg.solve(S, xs)))
    w = np.exp(np.array(fit) - max(fit))
    w /= w.sum()
    doubt = float(np.exp(w @ np.log(_DOUBTS)))
    if doubt > FOREIGN:
        return Informed(x, covariance, doubt)
    mean = w @ np.array(xt)
    apart = np.array(xt) - mean
    spread = np.einsum("t,tij->ij", w, np.array(Ct)) + np.einsum("t,ti,tj->ij", w, apart, apart)
    return Informed(mean, spread, doubt)


def _tolerances(parameters: Parameters) -> Array:
    """Covariance (p, p) of the scaled parameters by the data sheet; zero where it says nothing."""
    share = np.where(parameters.scale > 0.0, parameters.nominal / parameters.scale, 0.0)
    size = np.array([name.startswith(_SIZES) for name in parameters.names])
    length = np.array([name.startswith(_LENGTHS) for name in parameters.names])
    Q = BATCH**2 * np.outer(size, size) + np.diag(EACH**2 * size + LENGTH**2 * length)
    return np.asarray(Q * np.outer(share, share))
