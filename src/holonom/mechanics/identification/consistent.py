"""All parameters of an arm from its base parameters such that bodies with these parameters can exist.

A body can exist if its pseudo-inertia P = [S h; h^T m] is positive definite (Wensing, Kim, Slotine 2018). What the
measurement leaves open is taken from a prior, in the entropic distance tr(P0^-1 P) - log det P (Lee, Wensing, Park
2020), which is the barrier at the border as well. The problem is convex: Newton steps, the prior's weight lowered
from large to small.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from holonom.arrays import Array
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.regressor import BODY_PARAMETERS, from_parameters, to_parameters
from holonom.mechanics.identification.columns import parameters
from holonom.model import ArmModel, Body, Friction

__all__ = ["consistent_parameters", "is_consistent", "model_from_parameters", "prior_parameters", "pseudo_inertia"]


ASSUMED_MASS, ASSUMED_RADIUS = 1.0, 0.1  # kg, m: of a homogeneous sphere, where no model states a body
SOFTENING = 1e-3  # least share of that sphere in a stated body: published ones are often flat or without inertia
SMALL = 1e-3  # prior of a drive parameter that the model does not state
NEWTON_STEPS, WEIGHTS = 60, np.geomspace(1e4, 1.0, 9)


def pseudo_inertia(p: Array) -> Array:
    """P (4, 4) of a body's ten parameters."""
    body = from_parameters(p.tolist())
    P = np.zeros((4, 4))
    P[:3, :3], P[:3, 3], P[3, :3], P[3, 3] = body.S, body.h, body.h, body.m
    return P


_BASIS = np.array([pseudo_inertia(unit) for unit in np.eye(len(BODY_PARAMETERS))])
_MOMENT = 0.4 * ASSUMED_MASS * ASSUMED_RADIUS**2
_SPHERE = np.array([ASSUMED_MASS, 0, 0, 0, _MOMENT, 0, _MOMENT, 0, 0, _MOMENT])


def is_consistent(p: Array) -> bool:
    """Whether a body with these ten parameters can exist."""
    return bool(np.linalg.eigvalsh(pseudo_inertia(p)).min() > 0.0)


def prior_parameters(model: ArmModel) -> Array:
    """What the model states, softened so that every body can exist; spheres where it states none."""
    stated, count = parameters(model), len(model.joints)
    for i in range(count):
        at = slice(10 * i, 10 * i + 10)
        stated[at] = _SPHERE if model.bodies is None else _softened(stated[at])
    stated[10 * count :] = np.maximum(stated[10 * count :], SMALL)
    return stated


def _softened(p: Array) -> Array:
    """The nearest body whose pseudo-inertia, measured by the sphere's, has no eigenvalue below `SOFTENING`."""
    root = np.sqrt(np.diagonal(pseudo_inertia(_SPHERE)))
    values, vectors = np.linalg.eigh(pseudo_inertia(p) / np.outer(root, root))
    P = (vectors * np.maximum(values, SOFTENING)) @ vectors.T * np.outer(root, root)
    return np.array(to_parameters(Inertial(P[3, 3], P[:3, 3].tolist(), P[:3, :3].tolist())), dtype=float)


class _Barrier(NamedTuple):
    """Distance from the prior: value, a root F of its Hessian F^T F, and r such that its gradient is -F^T r."""

    value: float
    root: Array
    r: Array


def _distance(p: Array, prior: Array, count: int) -> _Barrier | None:
    """Entropic distance of all bodies and drives; None where they cannot exist."""
    x, x0 = p[10 * count :], prior[10 * count :]
    if (x <= 0.0).any():
        return None
    roots, targets, value = [], [], float(np.sum(x / x0 - np.log(x)))
    for i in range(count):
        at = slice(10 * i, 10 * i + 10)
        try:
            L = np.linalg.cholesky(pseudo_inertia(p[at]))
        except np.linalg.LinAlgError:
            return None
        half = np.linalg.inv(L)
        ratio = L.T @ np.linalg.inv(pseudo_inertia(prior[at])) @ L
        value += float(np.trace(ratio) - 2 * np.sum(np.log(np.diagonal(L))))
        roots.append((half @ _BASIS @ half.T).reshape(10, 16).T)
        targets.append((np.eye(4) - ratio).ravel())
    return _Barrier(value, block_diag(*roots, np.diag(1 / x)), np.concatenate([*targets, 1 - x / x0]))


def consistent_parameters(A: Array, t: Array, prior: Array, count: int, weight: float) -> Array:
    """Minimise 1/2 |A p - t|^2 + weight * distance(p, prior) over all parameters that can exist.

    Parameters
    ----------
    A, t : (r, p), (r,) equations, divided by the standard deviations of their right sides.
    prior : (p,) parameters that can exist.
    count : bodies among them, ten parameters each; the rest are positive numbers.
    weight : how much the prior counts; 1 is as much as a measurement that is wrong by one standard deviation.
    """
    Q, R = np.linalg.qr(A)
    b, p = Q.T @ t, prior
    for factor in WEIGHTS:
        p = _minimise(R, b, p, prior, count, weight * float(factor))
    return p


def _minimise(R: Array, b: Array, p: Array, prior: Array, count: int, weight: float) -> Array:
    """Newton's method with step halving, from a p that can exist."""
    here = _distance(p, prior, count)
    assert here is not None, "the start can exist"
    for _ in range(NEWTON_STEPS):
        step = _newton_step(R, b - R @ p, here, weight)
        slope = float((R @ p - b) @ (R @ step) - weight * here.r @ (here.root @ step))
        if -slope < 1e-8 * weight:
            break
        value = _value(R, b, p, here, weight)
        for halvings in range(40):
            new = p + 0.5**halvings * step
            there = _distance(new, prior, count)
            if there is not None and _value(R, b, new, there, weight) <= value + 1e-4 * 0.5**halvings * slope:
                p, here = new, there
                break
        else:
            break  # no descent left but rounding
    return p


def _value(R: Array, b: Array, p: Array, distance: _Barrier, weight: float) -> float:
    rest = R @ p - b
    return 0.5 * float(rest @ rest) + weight * distance.value


def _newton_step(R: Array, rest: Array, distance: _Barrier, weight: float) -> Array:
    """By least squares, not by the Hessian: the measurement outweighs the prior by more than half the digits."""
    A = np.vstack([R, np.sqrt(weight) * distance.root])
    size = np.linalg.norm(A, axis=0)
    b = np.concatenate([rest, np.sqrt(weight) * distance.r])
    return np.asarray(np.linalg.lstsq(A / size, b, rcond=None)[0] / size)


def model_from_parameters(model: ArmModel, p: Array, *, friction: bool) -> ArmModel:
    """The model with bodies, rotor inertias (of stated motors) and, if wanted, friction from a vector pi (14 N,)."""
    count = len(model.joints)
    rotor, viscous, positive, negative = p[10 * count :].reshape(4, count)
    joints = []
    for i, joint in enumerate(model.joints):
        if joint.motor is not None:
            inertia = float(rotor[i] / joint.motor.gear_ratio**2)
            joint = dataclasses.replace(joint, motor=dataclasses.replace(joint.motor, rotor_inertia=inertia))
        if friction:
            joint = dataclasses.replace(
                joint, friction=Friction(float(viscous[i]), float(positive[i]), float(negative[i]))
            )
        joints.append(joint)
    bodies = tuple(_body(p[10 * i : 10 * i + 10]) for i in range(count))
    return dataclasses.replace(model, joints=tuple(joints), bodies=bodies, links_include_rotors=True)


def _body(p: Array) -> Body:
    m, c = float(p[0]), p[1:4] / p[0]
    xx, xy, yy, xz, yz, zz = p[4:]
    about = m * (c @ c * np.eye(3) - np.outer(c, c))
    I = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - about
    x, y, z = c.tolist()
    return Body(m, (x, y, z), (*np.diagonal(I).tolist(), float(I[0, 1]), float(I[1, 2]), float(I[0, 2])))
