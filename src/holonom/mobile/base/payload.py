"""What a base carries: a load that is a point, and the base that it makes with it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from holonom.errors import ModelError, OutOfLimits
from holonom.mobile.base.wheel_base import WheelBase

__all__ = ["Payload", "loaded"]


@dataclass(frozen=True, slots=True)
class Payload:
    """A load that lies on a base: kg, where its middle is in base_link (x, y), how high over the floor, m.

    Raises
    ------
    OutOfLimits
        A mass or a height below zero, a number that is none.
    """

    mass: float
    com: tuple[float, float] = (0.0, 0.0)
    com_height: float = 0.0

    def __post_init__(self) -> None:
        given = (self.mass, *self.com, self.com_height)
        if not (all(math.isfinite(x) for x in given) and self.mass >= 0.0 and self.com_height >= 0.0):
            raise OutOfLimits(
                f"Payload: mass {self.mass!r} kg, com {self.com!r} m, com_height {self.com_height!r} m; finite numbers "
                "are needed, mass and height not below zero"
            )


def loaded(base: WheelBase, payload: Payload) -> WheelBase:
    """Return a base with a payload: mass, centre of mass and inertia of both, by Steiner's theorem.

    Raises
    ------
    ModelError
        A base that states no mass.
    """
    if base.mass is None:
        raise ModelError(f"base {base.name!r} states no mass, so it carries nothing; state mass= in kg")
    masses = np.array([base.mass, payload.mass])
    places = np.array([(*base.com, base.com_height), (*payload.com, payload.com_height)])
    middle = masses @ places / masses.sum()
    inertia = base.inertia.copy()
    for mass, r in zip(masses, places - middle, strict=True):
        inertia += mass * (r @ r * np.eye(3) - np.outer(r, r))
    groups = {
        name: [base.wheels[i].name for i in group]
        for name, group in zip(base.steered, base.layout.groups, strict=True)
        if len(group) > 1
    }
    return WheelBase(
        base.wheels, name=base.name, radius=base.radius, mass=float(masses.sum()), com=middle[:2].tolist(),
        com_height=float(middle[2]), inertia=inertia, suspension=base.suspension, balances=base.balances,
        steering_groups=groups,
    )  # fmt: skip
