"""Whether a base stands: support polygon, margins at rest and under acceleration, wheel loads.

Wheels only push: loads are those of equal springs under a rigid body, none of which can pull.

The base is one rigid body on a plane floor; `acceleration` (ax, ay) is that of its centre of mass along the axes of
base_link, the centripetal one included. It tips where the zero-moment point leaves the support polygon (Vukobratović).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite, is_finite, shown, vectors
from holonom.errors import InputError, ModelError, OutOfLimits
from holonom.geometry import hull, margin, normals_and_offsets
from holonom.mobile.base.wheel_base import WheelBase
from holonom.model.gravity import GRAVITY
from holonom.numeric.contact_loads import pushing_loads

__all__ = [
    "Stance", "acceleration_limit", "contact_points", "dynamic_margin", "lateral_limit", "static_margin",
    "support_polygon", "turning_speed", "wheel_loads", "zero_moment_point",
]  # fmt: skip


def contact_points(base: WheelBase, castors: ArrayLike | None = None) -> Array:
    """Where the wheels touch the floor: (..., wheels, 2) m in base_link.

    Parameters
    ----------
    castors : (..., castors) rad that the castors have turned from their `beta`; None: nothing.
    """
    trailing = [k for k, w in enumerate(base.wheels) if w.kind == "castor"]
    turned = np.zeros(len(trailing)) if castors is None else vectors("castors", castors, len(trailing))
    points = np.tile(np.array([(w.x, w.y) for w in base.wheels]), (*turned.shape[:-1], 1, 1))
    for slot, k in enumerate(trailing):
        wheel = base.wheels[k]
        psi = wheel.heading + turned[..., slot]
        points[..., k, :] += wheel.castor_offset * np.stack([np.cos(psi), np.sin(psi)], axis=-1)
    return points


def support_polygon(base: WheelBase, castors: ArrayLike | None = None) -> Array:
    """Corners (k, 2) of the convex hull of the contact points, counter-clockwise, m in base_link.

    Parameters
    ----------
    castors : (castors,) rad; see `contact_points`.

    Raises
    ------
    ModelError
        Fewer than three contacts, or all on one line: the base cannot stand by itself.
    """
    points = contact_points(base, castors)
    try:
        return hull(points)
    except InputError:
        raise ModelError(
            f"base {base.name!r} touches the floor at {len(points)} points that span no area ("
            f"{', '.join(w.name for w in base.wheels)}): it has to balance; add a castor or a wheel off their line"
        ) from None


def static_margin(base: WheelBase, com: ArrayLike | None = None, *, castors: ArrayLike | None = None) -> Array:
    """Distance (...) of the centre of mass from the nearest edge of the support polygon, m; below zero: it tips.

    Parameters
    ----------
    com : (..., 2) m in base_link, such as that of the base with its load; None: the base's.
    """
    point = base.com if com is None else vectors("com", com, 2)
    return margin(support_polygon(base, castors), point)


def zero_moment_point(
    base: WheelBase, acceleration: ArrayLike, *, com: ArrayLike | None = None, com_height: float | None = None
) -> Array:
    """Point (..., 2) of the floor through which the floor's force goes: com - height a / g."""
    a = vectors("acceleration", acceleration, 2)
    point = base.com if com is None else vectors("com", com, 2)
    return point - _height(base, com_height) / GRAVITY * a


def dynamic_margin(
    base: WheelBase, acceleration: ArrayLike, *, com: ArrayLike | None = None, com_height: float | None = None,
    castors: ArrayLike | None = None,
) -> Array:  # fmt: skip
    """Distance (...) of the zero-moment point from the nearest edge, m; below zero: it tips over that edge."""
    return static_margin(base, zero_moment_point(base, acceleration, com=com, com_height=com_height), castors=castors)


def acceleration_limit(
    base: WheelBase, direction: ArrayLike = 0.0, *, com: ArrayLike | None = None, com_height: float | None = None,
    castors: ArrayLike | None = None,
) -> Array:  # fmt: skip
    """Largest acceleration (...), m/s2, in a direction before the base tips; braking from forwards is direction pi.

    Infinite where the centre of mass lies on the floor.

    Parameters
    ----------
    direction : (...) rad in base_link, counter-clockwise from x.

    Raises
    ------
    OutOfLimits
        The base tips at rest already.
    """
    point = base.com if com is None else vectors("com", com, 2)
    if np.min(static_margin(base, point, castors=castors)) < 0.0:
        raise OutOfLimits(
            f"base {base.name!r} tips at rest: its centre of mass {np.round(point, 6).tolist()} lies outside its "
            "support polygon; move it inside"
        )
    normals, offsets = normals_and_offsets(support_polygon(base, castors))
    angle = finite("direction", direction)
    closing = -np.stack([np.cos(angle), np.sin(angle)], axis=-1) @ normals.T  # the point moves against the acceleration
    room = offsets - point @ normals.T
    distance = np.where(closing > 1e-12, room / np.where(closing > 1e-12, closing, 1.0), np.inf).min(axis=-1)
    height = _height(base, com_height)
    limit: Array = np.asarray(GRAVITY * distance / height if height > 0.0 else np.full_like(distance, np.inf))
    return limit


def lateral_limit(
    base: WheelBase, *, com: ArrayLike | None = None, com_height: float | None = None,
    castors: ArrayLike | None = None,
) -> float:  # fmt: skip
    """Largest sideways acceleration, m/s2, to the weaker side: v^2/rho in a curve of radius rho."""
    sides = np.array([0.5 * np.pi, -0.5 * np.pi])
    return float(acceleration_limit(base, sides, com=com, com_height=com_height, castors=castors).min())


def turning_speed(base: WheelBase, curve: ArrayLike) -> Array:
    """Largest speed (...), m/s, in a curve of radius `curve` (...), m, before the base tips outwards."""
    radius = np.abs(finite("curve", curve))
    speed: Array = np.sqrt(lateral_limit(base) * radius)
    return speed


def wheel_loads(
    base: WheelBase, acceleration: ArrayLike = (0.0, 0.0), *, com: ArrayLike | None = None,
    com_height: float | None = None, castors: ArrayLike | None = None,
) -> Array:  # fmt: skip
    """Vertical forces (..., wheels), N, with which the floor carries the wheels.

    Of more than three wheels, the distribution of least square sum among those that only push: that of equally stiff
    wheels. One at zero has lifted off.

    Parameters
    ----------
    acceleration : (..., 2) m/s2 of the centre of mass.

    Raises
    ------
    InputError
        The base states no mass.
    OutOfLimits
        The base tips over.
    ModelError
        See `support_polygon`.
    """
    if base.mass is None:
        raise InputError(f"base {base.name!r} states no mass; give it one, kg (mass=)")
    support_polygon(base, castors)
    points = contact_points(base, castors)
    zmp = zero_moment_point(base, acceleration, com=com, com_height=com_height)
    loads, stands = pushing_loads(points, zmp)
    if not np.all(stands):
        x, y = zmp.reshape(-1, 2)[int(np.argmin(stands))].tolist()
        raise OutOfLimits(
            f"base {base.name!r} tips over: its zero-moment point ({x:.4g}, {y:.4g}) m lies outside its support "
            "polygon; move its centre of mass between the wheels, build lower, or accelerate less"
        )
    return loads * base.mass * GRAVITY


class Stance(NamedTuple):
    """How a base stands: contacts (w, 2) m about its centre of mass, weight N, height m, which wheels are driven."""

    points: Array
    weight: float
    height: float
    driven: tuple[int, ...]

    def loads(self, acceleration: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Loads (..., n), N, of the driven wheels at accelerations (..., 2) of the centre of mass; if it stands."""
        shares, stands = pushing_loads(self.points, -self.height / GRAVITY * acceleration)
        return self.weight * shares[..., list(self.driven)], stands


def _height(base: WheelBase, com_height: float | None) -> float:
    height = base.com_height if com_height is None else com_height
    if not (is_finite(height) and height >= 0.0):
        raise OutOfLimits(f"com_height is {shown(height)}; a height in m that is not below zero is needed")
    return float(height)
