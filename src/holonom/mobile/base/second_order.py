"""Second-order kinematics: how fast wheels have to be steered and accelerated for a twist that changes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.base.wheel_base import WheelBase

__all__ = ["WheelRates", "wheel_rates"]

STANDS = 1e-6  # m/s of a steered contact, below which its direction is none


class WheelRates(NamedTuple):
    """What wheels have to do.

    Attributes
    ----------
    steering
        (..., k) rad, of each steered axle, as `WheelBase.steering`.
    steering_rates
        (..., k) rad/s.
    speeds
        (..., m) rad/s of the driven wheels.
    accelerations
        (..., m) rad/s^2.
    """

    steering: Array
    steering_rates: Array
    speeds: Array
    accelerations: Array


def wheel_rates(base: WheelBase, twist: ArrayLike, acceleration: ArrayLike) -> WheelRates:
    """Return angles and speeds of the wheels for a twist, and their rates for its acceleration.

    Parameters
    ----------
    base : wheels.
    twist : (..., 3) in base_link, m/s, rad/s.
    acceleration : (..., 3) of the origin of base_link along its axes, m/s^2, and of turning, rad/s^2.

    Raises
    ------
    OutOfLimits
        A twist that drags a wheel (as `wheel_speeds`), or a steered wheel whose contact stands: its direction may jump.
    ShapeError

    Notes
    -----
    With c = v + w x p a contact's velocity, its rate along axes that turn is `c' = (a - w x v) + w' x p`. A wheel
    that is steered along it turns by `delta' = (c x c')/|c|^2`; as it does not slide, turning it adds nothing to its
    rim:
    `r phi'' = u . c'` (Siegwart & Nourbakhsh, Autonomous Mobile Robots, 3.2, once more differentiated; Dietrich et al.,
    ICRA 2011). Axles that several wheels share are steered as the first of them. A driven castor, here at rest, turns
    by `delta' = -n . c / d - w` (`castor_rates`), which turns its rim's direction: `r phi'' = u . c' + delta' n . c`.
    """
    xi, a = vectors("twist", twist, 3), vectors("acceleration", acceleration, 3)
    if xi.shape != a.shape:
        raise ShapeError(f"twist has shape {xi.shape}, acceleration {a.shape}; they must be the same")
    angles = base.steering(xi)
    speeds = base.wheel_speeds(xi, angles)
    w = xi[..., 2]
    rate = np.stack([a[..., 0] + w * xi[..., 1], a[..., 1] - w * xi[..., 0], a[..., 2]], axis=-1)
    turning = np.zeros_like(angles)
    swung = np.zeros_like(speeds)
    for k, group in enumerate(base.layout.groups):
        wheel = base.wheels[group[0]]
        cx, cy = _at(xi, wheel.x, wheel.y)
        if wheel.powered_castor:
            across = cx * math.cos(wheel.axle) + cy * math.sin(wheel.axle)
            turning[..., k] = -across / wheel.castor_offset - w
            swung[..., base.driven.index(wheel.name)] = turning[..., k] * across
            continue
        square = cx**2 + cy**2
        if square.min(initial=np.inf) < STANDS**2:
            raise OutOfLimits(
                f"wheel_rates: the contact of {wheel.name} stands at this twist; a twist at which it rolls is needed"
            )
        dx, dy = _at(rate, wheel.x, wheel.y)
        turning[..., k] = (cx * dy - cy * dx) / square
    rows = [base.rolling_names.index(name) for name in base.driven]
    rolling = base.rolling_matrix(angles)[..., rows, :]
    return WheelRates(angles, turning, speeds, ((rolling @ rate[..., None])[..., 0] + swung) / base.wheel_radii)


def _at(twist: Array, x: float, y: float) -> tuple[Array, Array]:
    """Velocity of a point of the base."""
    return twist[..., 0] - twist[..., 2] * y, twist[..., 1] + twist[..., 2] * x
