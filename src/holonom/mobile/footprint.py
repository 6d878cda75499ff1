"""What a base covers of the floor, seen from above."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.geometry import hull
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.stability import contact_points

__all__ = ["footprint"]

CORNERS = 24
"""Of the circle about a wheel."""


def footprint(base: WheelBase, *, pad: float = 0.0) -> Array:
    """Corners (k, 2) of the convex hull of circles about all wheels, counter-clockwise, m in base_link.

    A wheel's circle has its radius: no steering takes it out of there. Castors trail as at rest.

    Parameters
    ----------
    pad : m that is added to each radius, for a skin around the wheels.
    """
    turn = (np.arange(CORNERS) + 0.5) * 2.0 * np.pi / CORNERS
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1) / np.cos(np.pi / CORNERS)  # around the circle
    places = zip(base.wheels, contact_points(base), strict=True)
    return hull(np.concatenate([place + (wheel.radius + pad) * ring for wheel, place in places]))
