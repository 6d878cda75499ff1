"""Which wheel slips: measured rim speeds that no twist explains, and what a second source says of them (spec 06.2)."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from enum import IntEnum
from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from holonom.arrays import Array, finite_array
from holonom.errors import ModelError, ShapeError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.coupling import Coupling, coupling_of
from holonom.mobile.drive.slip_kernels import (
    AMBIGUOUS,
    BOUND,
    INVERSE,
    NO_SLIP,
    SLIP,
    UNDETECTABLE,
    SlipParams,
    slip_samples,
    slip_start,
)
from holonom.registry import check_fields, parameter

__all__ = ["SlipReport", "SlipSettings", "SlipStatus", "detect_slip", "detectable", "separable_wheels", "slip_params"]

_MARGIN = 1.25  # of what noise and limits allow: a wheel is named once every other is out by more
_RANK = 1e-9  # of a singular value beside the largest: below it the wheels do not determine the twist


class SlipStatus(IntEnum):
    """What is known: nothing slips; which wheel slips; that one of several does; three wheels cannot tell."""

    NO_SLIP = NO_SLIP
    SLIP = SLIP
    AMBIGUOUS = AMBIGUOUS
    UNDETECTABLE = UNDETECTABLE


@dataclass(frozen=True, slots=True)
class SlipSettings:
    """How noisy the sources are and how sure a finding must be.

    With at most one slipping wheel two are considered only where no single one explains the speeds; with two a single
    one is named only if no two others explain them, so that five wheels alone name none (four wheels never tell two
    from one). An acceleration error is that of one that is handed in (motor currents, accelerometers).

    Raises
    ------
    OutOfLimits
    """

    noise: float | tuple[float, ...] = parameter(
        0.02, meaning="standard deviation of a sample of rim speed, one or one per wheel", unit="m/s", above=0.0
    )
    dt: float = parameter(1e-3, meaning="time between samples", unit="s", above=0.0)
    rate_noise: float = parameter(
        0.01, meaning="standard deviation of a sample of the gyro", unit="rad/s", least=0.0, most=inf
    )
    rate_bias: float = parameter(0.02, meaning="how far its zero may be off", unit="rad/s", least=0.0, most=inf)
    max_acceleration: float = parameter(
        inf, meaning="of the base; infinite: the last velocity tells nothing", unit="m/s2", above=0.0, most=inf
    )
    max_angular_acceleration: float = parameter(inf, meaning="the same", unit="rad/s2", above=0.0, most=inf)
    acceleration_error: float = parameter(
        inf, meaning="how far an acceleration may be off", unit="m/s2", least=0.0, most=inf
    )
    angular_acceleration_error: float = parameter(
        inf, meaning="how far an angular acceleration may be off", unit="rad/s2", least=0.0, most=inf
    )
    false_alarm: float = parameter(
        1e-4, meaning="probability that noise alone carries a sample over a bound", above=0.0, below=0.5
    )
    persistence: float = parameter(0.010, meaning="how long slip lasts before it is raised", unit="s", above=0.0)
    confirmation: float = parameter(
        0.005, meaning="how long all samples name one wheel before it is named", unit="s", above=0.0
    )
    most: int = parameter(1, meaning="wheels that may slip at once", least=1, most=2)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True)
class SlipReport:
    """What N samples said.

    Attributes
    ----------
    status
        (N,) codes of `SlipStatus`.
    wheel
        (N,) index of the wheel named; -1 where none or two are.
    named, candidates
        (N, n) whether each wheel is known to slip, whether it may.
    twist
        (N, 3) vx, vy (m/s), w (rad/s) in base_link, without the slipping wheel.
    residual
        (N, n) `m - D D^+ m` of all wheels, m/s.
    statistic, threshold
        (N,) weighted square sum of the residual, and the bound that noise keeps below.
    """

    status: NDArray[np.int64]
    wheel: NDArray[np.int64]
    named: NDArray[np.bool_]
    candidates: NDArray[np.bool_]
    twist: Array
    residual: Array
    statistic: Array
    threshold: float


def detect_slip(
    base: WheelBase | Coupling | ArrayLike,
    speeds: ArrayLike,
    settings: SlipSettings,
    *,
    rate: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
) -> SlipReport:
    """Find slip in a log and name the wheel where something names it.

    Parameters
    ----------
    base
        A base, its coupling, or D (n, 3) of a base of radius 1 m.
    speeds
        (N, n) rim speeds, m/s: `base.wheel_radii` times the wheel speeds of a `WheelBase`.
    settings
        Noise, limits, how sure to be.
    rate
        (N,) gyro, rad/s.
    acceleration
        (N, 3) ax, ay (m/s2), wd (rad/s2) of the base from motor currents or accelerometers; NaN where unknown.

    Raises
    ------
    ShapeError
    ModelError
        Wheels that do not determine the twist.

    Notes
    -----
    With n >= 5 the wheel is the one without which the others agree. With n = 4 every three wheels agree: named is the
    wheel without which the twist agrees with the gyro and with the last velocity within the acceleration limits; if
    several such remain the status is AMBIGUOUS. Two wheels that slip in just the ratio that a third one alone would
    show (in noise: often with n = 4 and 5, seldom with 6) look like it; `most=2` names none then (n >= 5).

    `slip_step` is the same sample by sample.
    """
    coupling = coupling_of(base)
    params = slip_params(coupling, settings)
    n, R, D = coupling.wheels, coupling.radius, coupling.velocity
    m = np.ascontiguousarray(finite_array("speeds", speeds, ("samples", n)))
    gyro = np.full(len(m), np.nan) if rate is None else np.ascontiguousarray(finite_array("rate", rate, (len(m),)))
    push = np.full((len(m), 3), np.nan)
    if acceleration is not None:
        push = np.array(acceleration, float)
        if push.shape != (len(m), 3):
            raise ShapeError(f"acceleration has shape {push.shape}; it must be ({len(m)}, 3): ax, ay, wd per sample")
        push[:, 2] *= R
    status, wheels = np.empty(len(m), np.int64), np.empty((len(m), 2), np.int64)
    twist, statistic = np.empty((len(m), 3)), np.empty(len(m))
    slip_samples(params, slip_start(), m, gyro, push, status, wheels, twist, statistic)
    bits = (wheels[:, :, None] >> np.arange(n)) & 1 == 1
    one = bits[:, 0].sum(axis=1) == 1
    residual = m - m @ params.hypotheses[0, INVERSE:].reshape(n, 3) @ D.T
    return SlipReport(
        status, np.where(one, bits[:, 0].argmax(axis=1), -1), bits[:, 0], bits[:, 1], twist / [1.0, 1.0, R],
        residual, statistic, float(params.hypotheses[0, BOUND]),
    )  # fmt: skip


def slip_params(base: WheelBase | Coupling | ArrayLike, settings: SlipSettings) -> SlipParams:
    """Prepare `slip_step` for a base: inverses without one and two wheels, and what noise alone may do to each.

    Raises
    ------
    ModelError
        Wheels that do not determine the twist.
    ShapeError
        `settings.noise` has another number of wheels.
    """
    coupling = coupling_of(base)
    D, R = coupling.velocity, coupling.radius
    n = len(D)
    noise = np.asarray(settings.noise, float)
    if noise.shape not in ((), (n,)):
        raise ShapeError(f"SlipSettings: noise is given for {noise.size} wheels; there are {n}")
    weights = 1.0 / np.broadcast_to(noise, (n,)).astype(float)
    sets = [s for s in ((), *_left_out(n)) if _determined(D, weights, s)]
    if not sets or sets[0]:
        raise ModelError(
            f"slip: these {n} wheels do not determine vx, vy and w: D has rank below 3; slip needs omni "
            "or mecanum wheels, three or more"
        )
    fits = [_without(D, weights, s) for s in sets]
    covariance = np.array([c for _, c in fits])
    p = settings.false_alarm
    dof = [n - 3 - len(s) for s in sets]
    thresholds = np.array([special.chdtri(k, p) if k > 0 else math.inf for k in dof])
    blur = _blur(fits[0], D, weights, sets, math.sqrt(thresholds[0])) if n > 3 else (0.0, 0.0)
    linear, angular = np.linalg.eigvalsh(covariance[:, :2, :2])[:, 1], covariance[:, 2, 2]
    gate, gate2 = -special.ndtri(p / 2.0), math.sqrt(special.chdtri(2, p))
    table = np.column_stack(
        [
            [sum(1 << i for i in s) for s in sets],
            thresholds,
            gate2 * np.sqrt(linear + linear.max()) + blur[0],
            gate * np.sqrt(angular + angular.max()) + blur[1],
            gate * np.sqrt(angular + (R * settings.rate_noise) ** 2) + R * settings.rate_bias,
            [K.T.ravel() for K, _ in fits],
        ]
    )
    return SlipParams(
        dt=float(settings.dt),
        radius=float(R),
        rows=np.column_stack([D, weights]),
        hypotheses=np.ascontiguousarray(table),
        max_acceleration=float(settings.max_acceleration),
        max_turning=float(R * settings.max_angular_acceleration),
        acceleration_error=float(settings.acceleration_error),
        turning_error=float(R * settings.angular_acceleration_error),
        suspects=(1 << n) - 1,
        redundancy=n - 3,
        margin=_MARGIN,
        pivot=_pivot(D) if n == 4 else -1,
        persistence=max(1, math.ceil(settings.persistence / settings.dt - 1e-9)),
        confirmation=max(1, math.ceil(min(settings.confirmation, settings.persistence) / settings.dt - 1e-9)),
        most=settings.most,
    )


def separable_wheels(base: WheelBase | Coupling | ArrayLike) -> NDArray[np.bool_]:
    """(n, n) whether wheel speeds alone can tell slip of one wheel from slip of another.

    The diagonal says whether slip of that wheel shows at all. Columns of `I - D D^+` that are parallel look alike:
    with four wheels all are.
    """
    D = coupling_of(base).velocity
    P = np.eye(len(D)) - D @ np.linalg.pinv(D)
    size = np.sqrt(np.clip(np.diag(P), 0.0, None))
    seen = size > math.sqrt(_RANK)
    cosine = np.abs(P) / np.where(seen, size, 1.0) / np.where(seen, size, 1.0)[:, None]
    apart: NDArray[np.bool_] = (cosine < 1.0 - _RANK) & seen & seen[:, None]
    np.fill_diagonal(apart, seen)
    return apart


def detectable(base: WheelBase | Coupling | ArrayLike) -> bool:
    """Whether wheel speeds alone can show that a wheel slips: more wheels than the twist needs, and it is determined.

    Three omni wheels, or the two of a differential drive, never contradict each other.
    """
    D = coupling_of(base).velocity
    return len(D) > 3 and _determined(D, np.ones(len(D)), ())


def _pivot(D: Array) -> int:
    """Wheel whose speed no twist explains best."""
    return int(np.argmax(1.0 - np.einsum("ij,ji->i", D, np.linalg.pinv(D))))


def _left_out(n: int) -> list[tuple[int, ...]]:
    """Sets of one wheel, then of two, that leave at least three."""
    return [s for size in (1, 2) if n - size >= 3 for s in itertools.combinations(range(n), size)]


def _kept(D: Array, weights: Array, left_out: tuple[int, ...]) -> Array:
    """Weighted D with zero rows for the wheels left out."""
    A: Array = weights[:, None] * D
    A[list(left_out)] = 0.0
    return A


def _determined(D: Array, weights: Array, left_out: tuple[int, ...]) -> bool:
    values = np.linalg.svd(_kept(D, weights, left_out), compute_uv=False)
    return len(values) == 3 and bool(values[2] > _RANK * values[0])


def _without(D: Array, weights: Array, left_out: tuple[int, ...]) -> tuple[Array, Array]:
    """Least-squares inverse (3, n) without those wheels, and covariance (3, 3) of its twist."""
    A = _kept(D, weights, left_out)
    covariance = np.asarray(np.linalg.inv(A.T @ A), np.float64)
    return covariance @ A.T * weights, covariance


def _blur(
    fit: tuple[Array, Array], D: Array, weights: Array, sets: list[tuple[int, ...]], bound: float
) -> tuple[float, float]:
    """How far (linear, angular) slip that stays below the bound of the residual can carry the twist of all wheels."""
    K, _ = fit
    free = 1.0 - np.einsum("ij,ji->i", D, K)
    linear, angular = 0.0, 0.0
    for s in sets:
        if len(s) == 1:
            slip = (bound + 3.0) / (weights[s[0]] * math.sqrt(free[s[0]]))
            shift = K[:, s[0]] * slip
            linear, angular = max(linear, math.hypot(shift[0], shift[1])), max(angular, abs(shift[2]))
    return linear, angular
