"""What every arrangement is made with: the body's own numbers, places of wheels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import ModelError
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase

__all__ = ["CORNERS", "Body", "body_of", "corners", "count_of", "evenly"]

CORNERS = ("front left", "front right", "rear left", "rear right")


class Body(TypedDict, total=False):
    """What a base is beside its wheels, handed on to `WheelBase`: every preset takes these by name."""

    name: str
    alpha: float
    mass: float | None
    com: Sequence[float]
    com_height: float
    inertia: ArrayLike | None


def body_of(
    kind: str, wheels: Sequence[Wheel], body: Body, *, radius: float | None = None,
    steering_groups: Mapping[str, Sequence[str]] | None = None, suspension: str = "rigid", balances: bool = False,
) -> WheelBase:  # fmt: skip
    """The base of these wheels, called like its arrangement unless the body says otherwise."""
    stated: Body = {"name": kind, **body}
    return WheelBase(
        wheels, radius=radius, steering_groups=steering_groups, suspension=suspension, balances=balances, **stated
    )


def corners(wheelbase: float, track: float) -> list[tuple[float, float]]:
    """Places of four wheels about the middle, in the order of `CORNERS`."""
    return [(sx * wheelbase / 2, sy * track / 2) for sx in (1.0, -1.0) for sy in (1.0, -1.0)]


def evenly(n: int, start: float) -> Array:
    """Angles of n places on a circle, rad, the first one a part of the step from x."""
    return 2.0 * math.pi * (np.arange(n) + start) / n


def count_of(kind: str, n: int) -> int:
    """n, if it is a whole number from 2; else ModelError."""
    if not isinstance(n, (int, np.integer)) or n < 2:
        raise ModelError(f"{kind} has n = {n} wheels; a whole number from 2 is needed")
    return int(n)
