"""Frames of a base's driven wheels: what they are called in a recording, and where they are."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.mobile import Wheel, WheelBase

__all__ = ["wheel_frames", "wheel_poses"]


def wheel_frames(base: WheelBase) -> tuple[str, ...]:
    """Names of the frames that turn with the driven wheels."""
    return tuple(f"wheel_{number}" for number in range(1, len(base.driven) + 1))


def wheel_poses(base: WheelBase, T_base: Array, angles: Array) -> Array:
    """World poses (..., m, 4, 4) of the driven wheels turned by `angles` (..., m), on a base at T_base (..., 4, 4).

    y lies along the axle.
    """
    wheels = _driven(base)
    angle, c, s = np.asarray(angles), *((f([wheel.heading for wheel in wheels])) for f in (np.cos, np.sin))
    turned, lifted = np.cos(angle), np.sin(angle)
    T = np.zeros((*angle.shape, 4, 4))
    T[..., 0, 0], T[..., 0, 1], T[..., 0, 2] = c * turned, -s, c * lifted
    T[..., 1, 0], T[..., 1, 1], T[..., 1, 2] = s * turned, c, s * lifted
    T[..., 2, 0], T[..., 2, 2], T[..., 3, 3] = -lifted, turned, 1.0
    T[..., :3, 3] = [(wheel.x, wheel.y, wheel.radius) for wheel in wheels]
    return np.asarray(T_base)[..., None, :, :] @ T


def _driven(base: WheelBase) -> list[Wheel]:
    return [wheel for wheel in base.wheels if wheel.driven]
