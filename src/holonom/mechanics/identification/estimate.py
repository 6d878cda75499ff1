"""Identification from a recorded motion: base parameters with confidence, and a model that can exist."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import InputError
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.identification.base import BaseParameters, base_parameters
from holonom.mechanics.identification.columns import parameters, regressor_of_rows, stated_columns
from holonom.mechanics.identification.consistent import (
    consistent_parameters,
    model_from_parameters,
    prior_parameters,
)
from holonom.mechanics.identification.measurement import equations_of
from holonom.mechanics.identification.misfit import doubts_of, misfit_of
from holonom.model import ArmModel

__all__ = ["Identification", "identify"]


WEAK = 0.3  # relative standard deviation above which a base parameter is called weak
DEFICIENT = 1e-9  # smallest singular value of the scaled base regressor, relative to the largest


@dataclass(frozen=True, slots=True)
class Identification:
    """What a motion told about an arm.

    Attributes
    ----------
    base : the base parameters; `base.formulas()` says of what each is the sum.
    values, deviations : (b,) their estimates and standard deviations, SI units.
    covariance : (b, b).
    condition : of the base regressor on this motion, columns scaled to 1.
    weak : columns' names of the base parameters whose deviation is above 30 % of their value.
    without_effect : parameters that no torque of this arm depends on.
    noise : (n,) standard deviation of the filtered torques about the fit, N m.
    parameters : (14 N,) a full set that can exist, closest to the estimate; what is not in `base` comes from the prior.
    model : the arm with these parameters.
    misfit : (n,) root mean square of the filtered torques about those of `model`, N m.
    explained : (n,) how much of it the torques' noise explains, as it is seen above the cutoff, N m.
    doubts : what speaks against the record, in sentences: torques missed far beyond their noise, as by a joint of
        wrong sign, degrees or swapped joints; positions out of the arm's limits then.
    """

    base: BaseParameters
    values: Array
    deviations: Array
    covariance: Array
    condition: float
    weak: tuple[str, ...]
    without_effect: tuple[str, ...]
    noise: Array
    parameters: Array
    model: ArmModel
    misfit: Array
    explained: Array
    doubts: tuple[str, ...]

    def interval(self, deviations: float = 1.96) -> tuple[Array, Array]:
        """Bounds of the base parameters; 1.96 standard deviations hold 95 %."""
        return self.values - deviations * self.deviations, self.values + deviations * self.deviations


def identify(
    arm: Arm,
    time: ArrayLike,
    q: ArrayLike,
    tau: ArrayLike,
    *,
    cutoff: float = 10.0,
    friction: bool = True,
    prior: ArmModel | None = None,
    prior_weight: float = 0.01,
) -> Identification:
    """Identify masses, moments, rotor inertias and friction from a recorded motion.

    Parameters
    ----------
    arm : its kinematics, gravity and motors' gear ratios count; its bodies serve as prior.
    time : (N,) s, even steps.
    q : (N, n) measured positions, rad or m.
    tau : (N, n) joint torques, N m or N.
    cutoff : Hz, of the zero-phase filter (above what the motion holds, below what is noise).
    friction : whether viscous and Coulomb friction are identified too; otherwise the arm's own is taken.
    prior : another model to take from what the motion leaves open.
    prior_weight : of the prior beside the measurement; 1 is as much as an error of one standard deviation.

    Raises
    ------
    ShapeError
        Arrays that do not go together, NaN.
    InputError
        Uneven times, an unusable cutoff, too short a record, or a motion that leaves base parameters without any
        effect; it names them.

    Source: weighted least squares on base parameters, Gautier 1997; Swevers et al. 2007. Physical consistency: see
    `identification.consistent`.
    """
    base = base_parameters(arm, friction=friction)
    known = parameters(arm.model) * ~stated_columns(arm.model, friction=friction)
    found = equations_of(arm.n, _rows(arm.model, base, known), time, q, tau, cutoff)
    keep = found.moving.T if friction else np.ones_like(found.moving.T)
    W = [found.Y[keep[j], j] for j in range(arm.n)]
    t = [found.tau[keep[j], j] for j in range(arm.n)]
    _check_excitation(np.concatenate(W), base)
    noise = _noise(W, t)
    weighted = np.concatenate([w / s for w, s in zip(W, noise, strict=True)])
    size = np.linalg.norm(weighted, axis=0)
    U, s, Vt = np.linalg.svd(weighted / size, full_matrices=False)
    target = np.concatenate([v / s_j for v, s_j in zip(t, noise, strict=True)])
    values = Vt.T @ ((U.T @ target) / s) / size
    covariance = (Vt.T / s**2) @ Vt / np.outer(size, size)
    deviations = np.sqrt(np.diagonal(covariance))

    p = _full(arm.model if prior is None else prior, base, weighted, target, prior_weight)
    identified = model_from_parameters(arm.model, p, friction=friction)
    misfit = misfit_of([w @ (base.grouping @ p) - v for w, v in zip(W, t, strict=True)], t, found.noise)
    limits = arm.limits
    doubts = doubts_of(misfit, limits.names, np.asarray(q, dtype=float), limits.lower, limits.upper)
    weak = tuple(base.names[k] for k in base.columns[deviations > WEAK * np.abs(values)])
    return Identification(
        base, values, deviations, covariance, float(s[0] / s[-1]), weak, base.without_effect,
        noise, p, identified, misfit.missed, misfit.explained, doubts,
    )  # fmt: skip


def _rows(model: ArmModel, base: BaseParameters, known: Array) -> Callable[..., Array]:
    """Columns of the base parameters, and last the torque that is known beforehand."""
    rows = regressor_of_rows(model)

    def columns(q: Array, qd: Array, qdd: Array) -> Array:
        Y = rows(q, qd, qdd)
        return np.concatenate([Y[..., base.columns], (Y @ known)[..., None]], axis=-1)

    return columns


def _check_excitation(W: Array, base: BaseParameters) -> None:
    if W.shape[0] < base.number:
        raise InputError(
            f"{W.shape[0]} equations are left for {base.number} base parameters: the record is too short or the arm "
            "hardly moves; record a motion such as `excitation` finds"
        )
    _, s, Vt = np.linalg.svd(W / base.scale, full_matrices=False)
    lost = s < DEFICIENT * s[0]
    if lost.any():
        share = np.sqrt((Vt[lost] ** 2).sum(0))
        names = ", ".join(base.names[base.columns[k]] for k in np.flatnonzero(share > 0.1))
        raise InputError(
            f"the motion tells nothing about {int(lost.sum())} of {base.number} base parameters, among {names}; "
            "record one that moves every joint, such as `excitation` finds"
        )


def _noise(W: list[Array], t: list[Array]) -> Array:
    """Standard deviation of each joint's torque about an unweighted fit, then about the weighted one."""
    sigma = np.ones(len(W))
    for _ in range(3):
        A = np.concatenate([w / s for w, s in zip(W, sigma, strict=True)])
        b = np.concatenate([v / s for v, s in zip(t, sigma, strict=True)])
        size = np.linalg.norm(A, axis=0)
        beta = np.linalg.lstsq(A / size, b, rcond=None)[0] / size
        free = max(1.0 - A.shape[1] / A.shape[0], 1e-3)
        sigma = np.array([np.sqrt(np.mean((w @ beta - v) ** 2) / free) for w, v in zip(W, t, strict=True)])
        sigma = np.maximum(sigma, 1e-9 * max(float(sigma.max()), 1e-9))
    return sigma


def _full(model: ArmModel, base: BaseParameters, W: Array, t: Array, weight: float) -> Array:
    """All parameters: those that count by measurement and prior, the others (no motor, no friction) zero."""
    prior, count = prior_parameters(model), len(model.joints)
    active = np.ones(len(prior), dtype=bool)
    named = set(base.without_effect) | {base.names[k] for k in np.flatnonzero(base.grouping.any(0))}
    active[10 * count :] = [name in named for name in base.names[10 * count :]]
    A = W @ base.grouping[:, active]
    p = np.zeros(len(prior))
    p[active] = consistent_parameters(A, t, prior[active], count, weight)
    return p
