"""How uncertain odometry is: wheel noise that grows with the way, carried along the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.odometry.integrate import increments_of, pose_of, rule_named
from holonom.mobile.odometry.kernels import propagate_into

__all__ = ["UncertainPath", "increment_noise", "integrate_with_covariance"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class UncertainPath:
    """Poses (N, 3), x, y (m), theta (rad) in the world, and their covariances (N, 3, 3)."""

    poses: Array
    covariance: Array


def increment_noise(matrix: ArrayLike, travel: ArrayLike, factor: ArrayLike) -> Array:
    """Covariance of each increment from wheels whose error grows with their way.

    Parameters
    ----------
    matrix : (3, m)
        Rim ways to increments of the base: `base.twist(np.eye(m)).T / r`.
    travel : (N, m)
        Way of each rim per sample, m.
    factor : (m,) or one number
        Variance of a rim's way per metre, m: `var(s) = factor |s|`.

    Returns
    -------
    (N, 3, 3), m^2, m rad, rad^2.

    Raises
    ------
    ShapeError, OutOfLimits

    Source: Siegwart & Nourbakhsh (5.8).
    """
    A, s = np.asarray(matrix, dtype=np.float64), np.asarray(travel, dtype=np.float64)
    if A.ndim != 2 or A.shape[0] != 3 or s.ndim != 2 or s.shape[1] != A.shape[1]:
        raise ShapeError(f"matrix {A.shape} and travel {s.shape} came; give (3, wheels) and (samples, wheels)")
    k = np.broadcast_to(np.asarray(factor, dtype=np.float64), A.shape[1:])
    if not np.all(np.isfinite(k) & (k >= 0.0)):
        raise OutOfLimits(f"noise factors {k.tolist()} came; numbers from zero up are allowed, m")
    return np.einsum("im,nm,jm->nij", A, k * np.abs(s), A)


def integrate_with_covariance(
    increments: ArrayLike,
    noise: ArrayLike,
    *,
    start: ArrayLike = (0.0, 0.0, 0.0),
    covariance: ArrayLike | None = None,
    rule: str = "midpoint",
) -> UncertainPath:
    """Add increments up to poses, and their uncertainty with them, to first order.

    Parameters
    ----------
    increments : (N, 3), as for `integrate`.
    noise : (N, 3, 3), or (3, 3) for all; covariance of each increment, such as `increment_noise` gives.
    start, rule : as for `integrate`.
    covariance : (3, 3) of the start; zero unless given.

    Raises
    ------
    ShapeError, UnknownName

    Source: Siegwart & Nourbakhsh (5.9) to (5.11): `P <- F P F^T + G Q G^T`.
    """
    share, exact = rule_named(rule)
    rows = increments_of(increments)
    try:
        Q = np.ascontiguousarray(np.broadcast_to(np.asarray(noise, dtype=np.float64), (len(rows), 3, 3)))
        P = np.zeros((3, 3)) if covariance is None else np.asarray(covariance, dtype=np.float64).reshape(3, 3)
    except ValueError:
        raise ShapeError(
            f"noise has shape {np.shape(noise)}, covariance {np.asarray(covariance).shape}; "
            f"give ({len(rows)}, 3, 3) and (3, 3)"
        ) from None
    poses, out = np.empty_like(rows), np.empty((len(rows), 3, 3))
    propagate_into(rows, Q, pose_of(start), P, share, exact, poses, out)
    return UncertainPath(poses, out)
