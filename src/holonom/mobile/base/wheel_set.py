"""What a base checks about its wheels and numbers when it is made."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, is_finite, shown
from holonom.errors import ModelError, ShapeError, UnknownName
from holonom.mobile.base.wheel import Wheel

__all__ = [
    "SUSPENSIONS",
    "body_inertia",
    "known_suspension",
    "named_wheels",
    "not_below_zero",
    "positive",
    "steering_groups",
]

SUSPENSIONS = ("rigid", "rocker_bogie")
"""How weight comes to wheels."""


def named_wheels(base: str, wheels: Iterable[Wheel]) -> tuple[Wheel, ...]:
    """The wheels of a base, the nameless numbered; ModelError if there are none or two have one name."""
    given = tuple(wheels)
    if not given:
        raise ModelError(f"base {base!r} has no wheels; state at least one")
    for wheel in given:
        if not isinstance(wheel, Wheel):
            raise ModelError(f"base {base!r} has {wheel!r} among its wheels; make each by Wheel(...) or Wheel.at(...)")
    named = tuple(w if w.name else dataclasses.replace(w, name=f"wheel {k + 1}") for k, w in enumerate(given))
    names = [w.name for w in named]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ModelError(f"base {base!r} has several wheels called {', '.join(map(repr, twice))}; name each its own")
    return named


def positive(base: str, what: str, value: float) -> float:
    """The value, if it is a number above zero; else ModelError."""
    if not (is_finite(value) and value > 0.0):
        raise ModelError(f"base {base!r} has {what} {shown(value)}; a number above zero is needed")
    return float(value)


def not_below_zero(base: str, what: str, value: float) -> float:
    """The value, if it is a number from zero on; else ModelError."""
    if not (is_finite(value) and value >= 0.0):
        raise ModelError(f"base {base!r} has {what} {shown(value)}; a height in m that is not below zero is needed")
    return float(value)


def known_suspension(name: str) -> str:
    """The name, if it is one of `SUSPENSIONS`; else UnknownName."""
    if name not in SUSPENSIONS:
        raise UnknownName("suspension", name, SUSPENSIONS)
    return name


def steering_groups(
    base: str, wheels: Sequence[Wheel], stated: Mapping[str, Sequence[str]]
) -> dict[str, tuple[int, ...]]:  # fmt: skip
    """Members of each steering angle by its name: stated groups at the place of their first wheel; castors alone."""
    place = {w.name: i for i, w in enumerate(wheels)}
    owner: dict[int, str] = {}
    for group, members in stated.items():
        for member in members:
            if member not in place:
                raise UnknownName("wheel", member, place)
            if wheels[place[member]].kind != "steered" or place[member] in owner:
                raise ModelError(
                    f"base {base!r}: group {group!r} has {member!r}, which is not steered or in another group"
                )
            owner[place[member]] = group
    alone = {w.name for i, w in enumerate(wheels) if w.steers and i not in owner}
    for group in alone.intersection(stated):
        raise ModelError(f"base {base!r}: group {group!r} has the name of a wheel that steers alone; name it otherwise")
    groups: dict[str, tuple[int, ...]] = {}
    for i, wheel in enumerate(wheels):
        if wheel.steers:
            key = owner.get(i, wheel.name)
            groups[key] = (*groups.get(key, ()), i)
    return groups


def body_inertia(base: str, stated: ArrayLike | None, alpha: float, mass: float | None, radius: float) -> Array:
    """Inertia (3, 3) of a body about its centre of mass, kg m^2: as stated, or `alpha mass radius^2` about every axis.

    NaN without mass.

    Raises
    ------
    ModelError
        An inertia without a mass, or one that no body has.
    ShapeError
    """
    if stated is None:
        return np.eye(3) * (alpha * radius**2 * (math.nan if mass is None else mass))
    if mass is None:
        raise ModelError(f"base {base!r} states an inertia and no mass; state both")
    given = finite("inertia", stated)
    if given.shape == ():
        given = np.diag(np.full(3, float(given)))
    elif given.shape == (3,):
        given = np.diag(given)
    elif given.shape != (3, 3):
        raise ShapeError(f"inertia has shape {given.shape}; (3, 3), (3,) or one number is needed, kg m^2")
    low, middle, high = np.linalg.eigvalsh(given).tolist()
    if not np.allclose(given, given.T, rtol=1e-9) or low <= 0.0 or high > (low + middle) * (1.0 + 1e-9):
        raise ModelError(
            f"base {base!r} has an inertia with principal moments {low:.4g}, {middle:.4g}, {high:.4g} kg m2, which no "
            "body has: they are positive, and none is more than the sum of the others"
        )
    return given
