"""An arm as joint axes in space: T_wt = before E1(q1) ... En(qn) home, in the pose in which its axes lie straightest.

The shape of an arm, which of its axes meet or are parallel, is read off here and nowhere else: DH tables and URDF
files of the same arm give the same axes. The reference pose is free, so it is chosen to make entries of the
directions and points zero: zeros cost nothing in a traced equation.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.inverse.subproblems import Screw, Turn
from holonom.model import ArmModel, Transform, constant_transform

__all__ = ["ALIKE", "ScrewChain", "common_point", "parallel", "screw_chain"]

ALIKE = 1e-5
"""Sine or length (m) below which axes count as parallel or meeting: URDF files write pi / 2 with 4 to 12 digits."""


@dataclass(frozen=True, slots=True)
class ScrewChain:
    """Axes in the reference pose, in a frame of their own.

    `reference` (n,) is that pose in the model's joints; `before` is T_w(own frame),
    `home` what carries the own frame to the tool in that pose. `departure` is by how much (m, and entries of rotations)
    these axes miss the model's poses: 0 but for axes that are parallel or coordinate axes only nearly.
    """

    screws: tuple[Screw, ...]
    reference: tuple[float, ...]
    before: Transform
    home: Transform
    departure: float


def screw_chain(model: ArmModel, alike: float = ALIKE) -> ScrewChain | None:
    """The axes of an arm; None for a tree (see `model.tool_chain`), or where joints follow others.

    Axes that are nearly parallel, or nearly meet, to a sine or length of `alike`, are taken to be so.
    """
    n = len(model.joints)
    if any(j.mimic is not None or model.parent(i) != i - 1 for i, j in enumerate(model.joints)):
        return None
    if model.tool_joint != n - 1:
        return None
    axes, home = _at_zero(model)
    own = _own_frame(axes, alike)
    axes, home = _seen_from(own, axes), np.linalg.inv(own) @ home
    kinds = [j.turns for j in model.joints]
    reference, axes, home = _straightened(axes, kinds, home, alike)
    directions = _directions(axes[:, 0], alike)
    screws = tuple(
        Screw(kind, _triple(h), _triple(p), Turn(math.cos(r), -math.sin(r)))
        for kind, h, p, r in zip(kinds, directions, _points(directions, axes[:, 1], alike), reference, strict=True)
    )
    chain = ScrewChain(screws, tuple(reference), _rigid(np.array(model.base) @ own), _rigid(home), 0.0)
    departure = _departure(model, chain)
    return chain if departure < 1e-12 else dataclasses.replace(chain, departure=departure)


def _departure(model: ArmModel, chain: ScrewChain) -> float:
    """Largest difference between the model's poses and the chain's, at a few joint vectors."""
    worst = 0.0
    for k in range(4):
        q = [0.7 * k + 1.3 * i for i in range(len(chain.screws))]
        T = np.array(kinematics.pose(model, q, None), dtype=float).reshape(4, 4)
        worst = max(worst, float(np.abs(_pose(chain, q) - T).max()))
    return worst


def _pose(chain: ScrewChain, q: list[float]) -> Array:
    T = np.array(chain.before)
    for screw, value, reference in zip(chain.screws, q, chain.reference, strict=True):
        E, h, p = np.eye(4), np.array(screw.h), np.array(screw.p)
        if screw.revolute:
            E[:3, :3] = _rotation(h, value - reference)
            E[:3, 3] = p - E[:3, :3] @ p
        else:
            E[:3, 3] = value * h
        T = T @ E
    return np.asarray(T @ np.array(chain.home))


def _at_zero(model: ArmModel) -> tuple[Array, Array]:
    """Directions and points (n, 2, 3) in the base frame at q = 0, and the tool's pose there."""
    T, axes = np.eye(4), []
    for joint in model.joints:
        T = T @ np.array(joint.before)
        axes.append([T[:3, 2], T[:3, 3]])
        T = T @ np.array(joint.after)
    return np.array(axes), T @ np.array(model.tool)


def _own_frame(axes: Array, alike: float) -> Array:
    """Frame with z along axis 1; its origin nearest to the next axis that is not parallel to it."""
    T = np.eye(4)
    h, p = axes[0]
    order = np.argsort(-np.abs(h))
    x = np.eye(3)[order[-1]] - h * h[order[-1]]
    x /= np.linalg.norm(x)
    T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3] = x, np.cross(h, x), h, p
    for k, q in axes[1:]:
        n = np.cross(h, k)
        if np.linalg.norm(n) > alike:
            T[:3, 3] = p + h * (np.cross(q - p, k) @ n) / (n @ n)
            break
    return T


def _seen_from(frame: Array, axes: Array) -> Array:
    R, p = frame[:3, :3], frame[:3, 3]
    return np.stack([axes[:, 0] @ R, (axes[:, 1] - p) @ R], axis=1)


def _straightened(axes: Array, kinds: list[bool], home: Array, alike: float) -> tuple[list[float], Array, Array]:
    """Turn each joint until what follows it points along a coordinate axis; the turns are the reference pose."""
    reference = [0.0] * len(axes)
    axes, home = axes.copy(), home.copy()
    for i, revolute in enumerate(kinds):
        h, p = axes[i]
        if not revolute or np.abs(h).max() < 1.0 - alike:
            continue
        ahead = [v for k, q in axes[i + 1 : i + 2] for v in (k, q - p)] + [home[:3, 0], home[:3, 1]]
        across = [v - h * (h @ v) for v in ahead]
        u = next(v for v in across if np.linalg.norm(v) > alike)
        e = np.eye(3)[np.argmin(np.abs(h))]
        angle = math.atan2(np.cross(h, e) @ u, e @ u)
        turn = round(angle / (math.pi / 2)) * math.pi / 2 - angle
        if abs(turn) < 1e-9:
            continue
        reference[i] = turn
        R = _rotation(h, turn)
        axes[i + 1 :, 0] = axes[i + 1 :, 0] @ R.T
        axes[i + 1 :, 1] = (axes[i + 1 :, 1] - p) @ R.T + p
        home[:3, :3] = R @ home[:3, :3]
        home[:3, 3] = R @ (home[:3, 3] - p) + p
    return reference, axes, home


def _rotation(h: Array, angle: float) -> Array:
    K = np.cross(h, np.eye(3)).T
    return np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K


def _directions(axes: Array, alike: float) -> list[Array]:
    """Directions without entries that are rounding, the same numbers for parallel axes."""
    clean: list[Array] = []
    for h in axes:
        twin = next((k for k in clean if np.linalg.norm(np.cross(h, k)) < alike), None)
        if twin is None:
            h = np.where(np.abs(h) < alike, 0.0, h)
            clean.append(h / np.linalg.norm(h))
        else:
            clean.append(math.copysign(1.0, h @ twin) * twin)
    return clean


def _points(directions: list[Array], axes: Array, alike: float) -> list[Array]:
    """A point per axis, nearest to the one before; axes that nearly meet the one before are moved to meet it."""
    points: list[Array] = []
    last, met = np.zeros(3), np.full(3, np.inf)
    for i, (h, p) in enumerate(zip(directions, axes, strict=True)):
        last = p + h * (h @ (last - p))
        if i and alike > ALIKE:
            at = _nearest_point(directions[i - 1], points[-1], h, last)
            if at is not None and np.linalg.norm((at - last) - h * (h @ (at - last))) < alike:
                last = met = met if np.linalg.norm(at - met) < 2.0 * alike else at
        last = np.where(np.abs(last) < 1e-12, 0.0, last)
        points.append(last)
    return points


def _nearest_point(h: Array, p: Array, k: Array, q: Array) -> Array | None:
    """The point of the line p + s h that is nearest to the line q + t k, if they are not parallel."""
    n = np.cross(h, k)
    square = float(n @ n)
    return None if square < ALIKE**2 else np.asarray(p + h * (np.cross(q - p, k) @ n) / square)


def _rigid(T: Array) -> Transform:
    T = np.where(np.abs(T) < 1e-14, 0.0, T)
    return constant_transform(T)


def _triple(v: Array) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])


def parallel(a: Screw, b: Screw) -> bool:
    """Whether two axes have the same direction, either way round."""
    return float(np.linalg.norm(np.cross(a.h, b.h))) < ALIKE


def common_point(a: Screw, b: Screw) -> tuple[float, float, float] | None:
    """The point in which two axes that are not parallel meet, if they do."""
    h, k, gap = np.array(a.h), np.array(b.h), np.array(b.p) - np.array(a.p)
    n = np.cross(h, k)
    square = float(n @ n)
    if square < ALIKE**2 or abs(gap @ n) > ALIKE * math.sqrt(square):
        return None
    found = np.array(a.p) + h * float(np.cross(gap, k) @ n) / square
    return _triple(np.where(np.abs(found) < 1e-12, 0.0, found))
