"""Euler angles with both branches and the degenerate case named; SciPy gives one branch and a warning.

ZYZ: R = Rz(phi) Ry(theta) Rz(psi) (specification 1.1). RPY: R = Rz(yaw) Ry(pitch) Rx(roll), fixed axes x, y, z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.spatial.poses import check_pose, pose

__all__ = ["EulerAngles", "rpy_angles", "zyz_angles"]

DEGENERATE = 1e-9
"""Sine (ZYZ) or cosine (RPY) of the middle angle below which only a sum or difference of the others is defined."""


@dataclass(frozen=True, slots=True)
class EulerAngles:
    """Both branches of the angles, (2, 3) in rad, equal where `degenerate`: then the last angle is chosen 0."""

    angles: Array
    degenerate: bool


def zyz_angles(R: ArrayLike) -> EulerAngles:
    """Angles (phi, theta, psi) of a rotation matrix (3, 3); theta >= 0 in the first branch.

    Raises
    ------
    NotAPose
        Not a rotation matrix.
    """
    m = _rotation(R)
    sine = np.hypot(m[0, 2], m[1, 2])
    if sine < DEGENERATE:
        theta = 0.0 if m[2, 2] > 0 else np.pi
        phi = np.arctan2(-m[0, 1], m[1, 1])  # theta 0: phi + psi; theta pi: phi - psi
        return EulerAngles(np.tile([phi, theta, 0.0], (2, 1)), True)
    first = [np.arctan2(m[1, 2], m[0, 2]), np.arctan2(sine, m[2, 2]), np.arctan2(m[2, 1], -m[2, 0])]
    second = [np.arctan2(-m[1, 2], -m[0, 2]), -first[1], np.arctan2(-m[2, 1], m[2, 0])]
    return EulerAngles(np.array([first, second]), False)


def rpy_angles(R: ArrayLike) -> EulerAngles:
    """Angles (roll, pitch, yaw) of a rotation matrix (3, 3); |pitch| <= 90 deg in the first branch.

    In the degenerate case (pitch +-90 deg) yaw is chosen 0.

    Raises
    ------
    NotAPose
        Not a rotation matrix.
    """
    m = _rotation(R)
    cosine = np.hypot(m[0, 0], m[1, 0])
    pitch = np.arctan2(-m[2, 0], cosine)
    if cosine < DEGENERATE:
        roll = np.arctan2(np.sign(pitch) * m[0, 1], m[1, 1])
        return EulerAngles(np.tile([roll, pitch, 0.0], (2, 1)), True)
    first = [np.arctan2(m[2, 1], m[2, 2]), pitch, np.arctan2(m[1, 0], m[0, 0])]
    second = [np.arctan2(-m[2, 1], -m[2, 2]), np.pi - pitch, np.arctan2(-m[1, 0], -m[0, 0])]
    return EulerAngles(np.array([first, second]), False)


def _rotation(R: ArrayLike) -> Array:
    return check_pose(pose(rotation=np.asarray(R, dtype=float)), "R")[:3, :3]
