"""How uncertain odometry is: wheel noise that grows with the way, carried along the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.odometry.integrate import increments_of, pose_of, rule_named
from holonom.mobile.odometry.kernels import propagate_into

__all__ = ["UncertainPath", "increment_noise", "integrate_with_covariance", "steering_jacobians"]


STEP = 1e-5  # rad, of differences by a steering angle


@dataclass(frozen=True, slots=True)
class UncertainPath:
    """Poses (N, 3), x, y (m), theta (rad) in the world, and their covariances (N, 3, 3)."""

    poses: Array
    covariance: Array


def increment_noise(
    matrix: ArrayLike,
    travel: ArrayLike,
    factor: ArrayLike,
    *,
    steering_jacobian: ArrayLike | None = None,
    steering_deviation: ArrayLike = 0.0,
) -> Array:
    """Covariance of each increment from wheels whose error grows with their way, and of steered ones from their angles.

    Parameters
    ----------
    matrix : (3, m), or (N, 3, m) where it changes with the steering
        Rim ways to increments of the base, `dtwist/dspeeds / r`: `base.twist(np.eye(m)).T / r` without steering,
        and the first of `steering_jacobians(base, travel, steering)` with it.
    travel : (N, m)
        Way of each rim per sample, m.
    factor : (m,) or one number
        Variance of a rim's way per metre, m: `var(s) = factor |s|`.
    steering_jacobian : (N, 3, k)
        Change of each increment per rad of each steering angle; the second of `steering_jacobians`.
    steering_deviation : (k,) or one number
        Standard deviation of each steering angle, rad, independent in each sample.

    Returns
    -------
    (N, 3, 3), m^2, m rad, rad^2.

    Raises
    ------
    ShapeError, OutOfLimits

    Source: Siegwart & Nourbakhsh (5.8), with a column for each angle.
    """
    A, s = np.asarray(matrix, dtype=np.float64), np.asarray(travel, dtype=np.float64)
    whole = A.ndim in (2, 3) and A.shape[-2] == 3 and s.ndim == 2 and s.shape[1] == A.shape[-1]
    if not whole or (A.ndim == 3 and len(A) != len(s)):
        raise ShapeError(
            f"matrix {A.shape} and travel {s.shape} came; give (3, wheels) or (samples, 3, wheels), "
            "and (samples, wheels)"
        )
    found = _congruent(A, _spread("noise factors", factor, A.shape[-1], "m") * np.abs(s))
    if steering_jacobian is None:
        return found
    B = np.asarray(steering_jacobian, dtype=np.float64)
    if B.ndim != 3 or B.shape[:2] != (len(s), 3):
        raise ShapeError(f"steering_jacobian has shape {B.shape}; give ({len(s)}, 3, steered wheels)")
    variance = _spread("steering deviations", steering_deviation, B.shape[2], "rad") ** 2
    return found + _congruent(B, np.broadcast_to(variance, (len(s), B.shape[2])))


def _congruent(A: Array, variance: Array) -> Array:
    """`A diag(variance) A^T` (N, 3, 3)."""
    scaled = A * variance[:, None, :]
    return np.asarray(scaled @ np.broadcast_to(np.swapaxes(A, -1, -2), (len(variance), *A.shape[:-3:-1])))


def _spread(what: str, values: ArrayLike, count: int, unit: str) -> Array:
    try:
        spread = np.broadcast_to(np.asarray(values, dtype=np.float64), (count,))
    except ValueError:
        raise ShapeError(f"{what} have shape {np.shape(values)}; give one, or {count}") from None
    if not np.all(np.isfinite(spread) & (spread >= 0.0)):
        raise OutOfLimits(f"{what} {spread.tolist()} came; numbers from zero up are allowed, {unit}")
    return spread


def steering_jacobians(base: WheelBase, travel: ArrayLike, steering: ArrayLike) -> tuple[Array, Array]:
    """Derivatives of the increments of a steered base by the ways of its rims and by its steering angles.

    Parameters
    ----------
    base : with k steered axles and m driven wheels.
    travel : (N, m) way of each rim per sample, m.
    steering : (N, k) rad.

    Returns
    -------
    (N, 3, m) by the ways, and (N, 3, k) by the angles, by central differences of `base.twist`.

    Raises
    ------
    ShapeError, InputError
        Angles at which the driven speeds do not determine the twist.
    """
    s, angles = np.asarray(travel, dtype=np.float64), np.asarray(steering, dtype=np.float64)
    m, k = len(base.driven), len(base.steered)
    if s.ndim != 2 or s.shape[1] != m or angles.shape != (len(s), k):
        raise ShapeError(f"travel {s.shape} and steering {angles.shape} came; give (samples, {m}) and (samples, {k})")
    turns = s / base.wheel_radii
    units = [base.twist(np.tile(row, (len(s), 1)), angles) for row in np.diag(1.0 / np.asarray(base.wheel_radii))]
    slopes = [
        (base.twist(turns, angles + step) - base.twist(turns, angles - step)) / (2.0 * STEP)
        for step in STEP * np.eye(k)
    ]
    return np.stack(units, axis=-1), np.stack(slopes, axis=-1) if k else np.empty((len(s), 3, 0))


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
