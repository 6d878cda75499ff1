"""Small arms with closed-form inverses by hand, for the tests of motion: independent of `holonom.mechanics`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Limits:
    lower: Array
    upper: Array
    speed: Array
    acceleration: Array

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"joint {k + 1}" for k in range(len(self.lower)))

    @property
    def turns(self) -> tuple[bool, ...]:
        return (False,) * min(3, len(self.lower)) + (True,) * max(0, len(self.lower) - 3)


def limits_of(n: int, *, reach: float = 10.0, speed: float = 3.0, acceleration: float = 20.0) -> Limits:
    one = np.ones(n)
    return Limits(-reach * one, reach * one, speed * one, acceleration * one)


@dataclass(frozen=True)
class Solutions:
    q: Array
    status: NDArray[np.int64]


def rot_z(angle: Array) -> Array:
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.stack([c, -s, o, s, c, o, o, o, i], axis=-1).reshape(*angle.shape, 3, 3)


def rot_y(angle: Array) -> Array:
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.stack([c, o, s, o, i, o, -s, o, c], axis=-1).reshape(*angle.shape, 3, 3)


def pose(R: Array, p: Array) -> Array:
    T = np.zeros((*p.shape[:-1], 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, p, 1.0
    return T


@dataclass(frozen=True)
class Gantry:
    """Three slides x, y, z: joint space is the room itself."""

    limits: Limits

    def fk(self, q: Array) -> Array:
        return pose(np.eye(3), q)

    def jacobian(self, q: Array, *, frame: str) -> Array:
        assert frame == "world"
        return np.broadcast_to(np.eye(6, 3), (*q.shape[:-1], 6, 3))

    def ik(self, T: Array, q0: Array) -> Solutions:
        return Solutions(T[..., None, :3, 3], np.zeros((*T.shape[:-2], 1), dtype=np.int64))


@dataclass(frozen=True)
class GantryWrist:
    """Three slides and a ZYZ wrist: two branches, singular where the middle angle is 0 or pi."""

    limits: Limits

    def fk(self, q: Array) -> Array:
        return pose(rot_z(q[..., 3]) @ rot_y(q[..., 4]) @ rot_z(q[..., 5]), q[..., :3])

    def jacobian(self, q: Array, *, frame: str) -> Array:
        assert frame == "world"
        J = np.zeros((*q.shape[:-1], 6, 6))
        J[..., :3, :3] = np.eye(3)
        J[..., 5, 3] = 1.0
        first = rot_z(q[..., 3])
        J[..., 3:, 4] = first[..., :, 1]
        J[..., 3:, 5] = (first @ rot_y(q[..., 4]))[..., :, 2]
        return J

    def ik(self, T: Array, q0: Array) -> Solutions:
        R, p = T[..., :3, :3], T[..., :3, 3]
        q = np.empty((*T.shape[:-2], 2, 6))
        for branch, sign in enumerate((1.0, -1.0)):
            q[..., branch, :3] = p
            q[..., branch, 3] = np.arctan2(sign * R[..., 1, 2], sign * R[..., 0, 2])
            q[..., branch, 4] = np.arctan2(sign * np.hypot(R[..., 0, 2], R[..., 1, 2]), R[..., 2, 2])
            q[..., branch, 5] = np.arctan2(sign * R[..., 2, 1], -sign * R[..., 2, 0])
        return Solutions(q, np.zeros((*T.shape[:-2], 2), dtype=np.int64))


@dataclass(frozen=True)
class Scara:
    """Two links of 0.4 m and 0.3 m, a slide and a turning tool: two elbow branches, a reach."""

    limits: Limits

    def fk(self, q: Array) -> Array:
        a, b = q[..., 0], q[..., 0] + q[..., 1]
        x, y = 0.4 * np.cos(a) + 0.3 * np.cos(b), 0.4 * np.sin(a) + 0.3 * np.sin(b)
        return pose(rot_z(b + q[..., 3]), np.stack([x, y, q[..., 2]], axis=-1))

    def jacobian(self, q: Array, *, frame: str) -> Array:
        assert frame == "world"
        a, b = q[..., 0], q[..., 0] + q[..., 1]
        J = np.zeros((*q.shape[:-1], 6, 4))
        J[..., 0, 1], J[..., 1, 1] = -0.3 * np.sin(b), 0.3 * np.cos(b)
        J[..., 0, 0], J[..., 1, 0] = J[..., 0, 1] - 0.4 * np.sin(a), J[..., 1, 1] + 0.4 * np.cos(a)
        J[..., 2, 2] = 1.0
        J[..., 5, [0, 1, 3]] = 1.0
        return J

    def ik(self, T: Array, q0: Array) -> Solutions:
        x, y, z = T[..., 0, 3], T[..., 1, 3], T[..., 2, 3]
        cosine = (x * x + y * y - 0.4**2 - 0.3**2) / (2 * 0.4 * 0.3)
        q = np.empty((*T.shape[:-2], 2, 4))
        for branch, sign in enumerate((1.0, -1.0)):
            elbow = sign * np.arccos(np.clip(cosine, -1.0, 1.0))
            shoulder = np.arctan2(y, x) - np.arctan2(0.3 * np.sin(elbow), 0.4 + 0.3 * np.cos(elbow))
            tool = np.arctan2(T[..., 1, 0], T[..., 0, 0]) - shoulder - elbow
            q[..., branch, :] = np.stack([shoulder, elbow, z, tool], axis=-1)
        return Solutions(q, np.repeat((np.abs(cosine) > 1.0)[..., None], 2, axis=-1).astype(np.int64))
