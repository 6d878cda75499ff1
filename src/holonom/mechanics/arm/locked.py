"""All solutions of arms whose axes fit no closed form, but do with one joint locked: offset wrists, seven joints.

With the last joint (or the first) locked at an angle, the rest is an arm of its own whose target is known. Of seven
joints the rest has a closed form at every angle: one family of solutions, over the angle. Of six the rest, five joints,
reaches its target at a few angles only; those are found by following how far each branch misses it round the circle.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite_array
from holonom.errors import InputError, ShapeError
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.equations.freedoms import FREEDOMS
from holonom.mechanics.kernels.inverse.geometry import REACHED, pose_error
from holonom.mechanics.kernels.inverse.result import IkResult
from holonom.model import ArmModel, Joint, constant_transform
from holonom.spatial import check_pose

__all__ = ["all_solutions", "swivel_solutions"]

SAMPLES = 720
"""Angles round the circle at which the branches of five joints are looked at."""
STEPS, LARGEST = 30, 0.1
"""Newton steps of a candidate at most, and the largest of them, rad."""
NEAR, SAME = 0.5, 1e-6
"""How far (m, rad) a candidate may miss its target, and the difference up to which two solutions are the same."""


class _Rest(NamedTuple):
    """An arm without its last joint, or its first; `locked` is that one."""

    arm: Arm
    locked: Joint
    last: bool


def _rest(arm: Arm, joints: int) -> _Rest:
    """What is left of an arm of so many joints, with the last joint locked, or else the first.

    Raises
    ------
    InputError
        Another number of joints, a tree, or no closed form of either.
    """
    model = arm.model
    serial = model.tool_joint == len(model.joints) - 1 and all(
        joint.mimic is None and model.parent(i) == i - 1 for i, joint in enumerate(model.joints)
    )
    if len(model.joints) != joints or not serial:
        raise InputError(f"arm {model.name!r} is no chain of {joints} joints; it has {len(model.joints)}")
    bare = dataclasses.replace(model, bodies=None, frames=(), poses={}, tip=None)
    one = constant_transform(np.eye(4))
    for last in (True, False):
        joint = model.joints[-1 if last else 0]
        kept = model.joints[:-1] if last else (dataclasses.replace(model.joints[1], parent=None), *model.joints[2:])
        part = dataclasses.replace(bare, joints=kept)
        part = dataclasses.replace(part, tool=one) if last else dataclasses.replace(part, base=one)
        if joint.turns and (found := Arm(part)).closed_form is not None:
            return _Rest(found, joint, last)
    raise InputError(
        f"arm {model.name!r} has no closed form with its last or first joint locked; "
        "ik_nearest(T, q0) and solve_inverse find single solutions"
    )


def _left(rest: _Rest, model: ArmModel, T: Array, angle: Array) -> Array:
    """What is left for the other joints to reach (S, 4, 4), with the locked one at angles (S,)."""
    before, after = np.array(rest.locked.before), np.array(rest.locked.after)
    turn = np.array([_turn(rest.locked, float(a)) for a in angle])
    if rest.last:
        return np.asarray(T @ np.linalg.inv(before @ turn @ after @ np.array(model.tool)))
    return np.asarray(np.linalg.inv(np.array(model.base) @ before @ turn @ after) @ T)


def _turn(joint: Joint, angle: float) -> Array:
    T = np.eye(4)
    R, _ = FREEDOMS[joint.kind].displaced(angle)
    T[:3, :3] = np.array(R, dtype=float)
    return T


def _whole(rest: _Rest, q: Array, angle: Array) -> Array:
    """Joints (..., n) of the arm from those of the rest (..., n - 1) and the locked one's (...)."""
    own = np.broadcast_to(angle, q.shape[:-1])[..., None]
    return np.concatenate([q, own] if rest.last else [own, q], axis=-1)


def swivel_solutions(arm: Arm, T: ArrayLike, angles: ArrayLike) -> IkResult:
    """All branches of an arm of seven joints (Panda, iiwa), over the angle of its last joint (or first).

    Every solution is among them, at its angle: what the elbow's swivel is for arms whose shoulder and wrist are
    spherical.

    Parameters
    ----------
    T : (4, 4), T_wt.
    angles : (S,) rad, of the last joint; of the first, where the arm has a closed form only without that one.

    Returns
    -------
    As `Arm.ik`: q (S, k, 7), status (S, k).

    Raises
    ------
    NotAPose, ShapeError, InputError
        No pose, no angles; the arm has no seven joints, or no closed form with one of them locked.
    """
    target, angle = check_pose(T, "T"), finite_array("angles", angles, ("S",))
    if target.ndim != 2:
        raise ShapeError(f"T must be one pose (4, 4); shape {target.shape} came")
    rest: _Rest = arm.prepared[_rest, 7]
    found = rest.arm.ik(_left(rest, arm.model, target, angle))
    return found._replace(q=_whole(rest, found.q, angle[:, None]))


def all_solutions(arm: Arm, T: ArrayLike, *, samples: int = SAMPLES) -> Array:
    """All joint vectors (m, 6) with which an arm of six joints with an offset wrist (CRX, xArm6) reaches a pose.

    Joints lie in (-pi, pi]; limits are not asked.

    Parameters
    ----------
    T : (4, 4), T_wt.
    samples : angles of the locked joint at which branches are looked at. Two solutions whose angles lie closer than
        their distance, where branches meet, may be taken for one.

    Raises
    ------
    NotAPose, ShapeError, InputError
        No pose; the arm has no six joints, or no closed form with one of them locked.
    """
    target = check_pose(T, "T")
    if target.ndim != 2:
        raise ShapeError(f"T must be one pose (4, 4); shape {target.shape} came")
    if samples < 8:
        raise InputError(f"samples is {samples}; at least 8 angles are needed")
    rest: _Rest = arm.prepared[_rest, 6]
    angle = np.linspace(-np.pi, np.pi, samples, endpoint=False)
    q = _whole(rest, rest.arm.ik(_left(rest, arm.model, target, angle)).q, angle[:, None])  # (S, k, 6)
    missed = np.linalg.norm(pose_error(arm.fk(q), target, 6), axis=-1)
    least = (missed <= np.roll(missed, 1, 0)) & (missed <= np.roll(missed, -1, 0)) & (missed < NEAR)
    near = least | np.roll(least, 1, 0) | np.roll(least, -1, 0)
    return _different(_improved(arm, target, q[near]))


def _improved(arm: Arm, T: Array, q: Array) -> Array:
    """Those of some candidates (m, 6) from which Newton's method reaches the target."""
    for _ in range(STEPS):
        step = (np.linalg.pinv(arm.jacobian(q), rcond=1e-9) @ pose_error(arm.fk(q), T, 6)[..., None])[..., 0]
        q = q + np.clip(step, -LARGEST, LARGEST)
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    return np.asarray(q[np.linalg.norm(pose_error(arm.fk(q), T, 6), axis=-1) < REACHED])


def _different(q: Array) -> Array:
    """Joint vectors without repetitions, in (-pi, pi]."""
    q = q - 2.0 * np.pi * np.ceil((q - np.pi) / (2.0 * np.pi))
    kept: list[NDArray[np.float64]] = []
    for one in q:
        apart = [np.abs(np.angle(np.exp(1j * (one - other)))).max() for other in kept]
        if min(apart, default=np.inf) > SAME:
            kept.append(one)
    return np.array(kept).reshape(-1, q.shape[-1])
