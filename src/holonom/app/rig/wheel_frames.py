"""Frames of a base's wheels that are seen to turn: what they are called in a recording, and where they are."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.mobile import Wheel, WheelBase
from holonom.mobile.drive.base_drive import standing_wheels

__all__ = ["framed_wheels", "wheel_frames", "wheel_poses"]


def framed_wheels(base: WheelBase) -> list[tuple[int, Wheel]]:
    """Wheels with a frame of their own, with their lanes: the driven ones, then those that are steered only.

    Balls have none.
    """
    return [
        (lane, wheel)
        for lane, wheel in enumerate(standing_wheels(base))
        if wheel.kind not in ("ball", "spherical") and (wheel.driven or wheel.kind == "steered")
    ]


def wheel_frames(base: WheelBase) -> tuple[str, ...]:
    """Names of the frames that turn with those wheels."""
    return tuple(f"wheel_{number}" for number in range(1, len(framed_wheels(base)) + 1))


def wheel_poses(base: WheelBase, T_base: Array, angles: Array, turned: Array) -> Array:
    """World poses (..., n, 4, 4) of those wheels turned by `angles` (..., n), steered by `turned` (..., n), rad.

    The base is at T_base (..., 4, 4); y lies along the axle.
    """
    wheels = [wheel for _, wheel in framed_wheels(base)]
    angle = np.asarray(angles)
    heading = np.array([wheel.heading for wheel in wheels]) + turned
    c, s = np.cos(heading), np.sin(heading)
    rolled, lifted = np.cos(angle), np.sin(angle)
    T = np.zeros((*angle.shape, 4, 4))
    T[..., 0, 0], T[..., 0, 1], T[..., 0, 2] = c * rolled, -s, c * lifted
    T[..., 1, 0], T[..., 1, 1], T[..., 1, 2] = s * rolled, c, s * lifted
    T[..., 2, 0], T[..., 2, 2], T[..., 3, 3] = -lifted, rolled, 1.0
    T[..., :3, 3] = np.array([(wheel.x, wheel.y, wheel.radius) for wheel in wheels]).reshape(-1, 3)
    swung = np.array([wheel.castor_offset for wheel in wheels])  # driven castors touch the floor beside their pivots
    T[..., 0, 3] += swung * c
    T[..., 1, 3] += swung * s
    return np.asarray(T_base)[..., None, :, :] @ T
