"""The words of a recording that say which base it is of: wheels, encoders, gear, as its data sheet has them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from holonom.errors import InputError
from holonom.mobile import Wheel, WheelBase

__all__ = ["ROBOT", "BaseDescription", "WheelCreep", "base_of", "base_words"]

ROBOT = "robot"
"""Name of the words."""


@dataclass(frozen=True, slots=True)
class WheelCreep:
    """What the controller knows of gripping wheels, which creep the more the harder they push.

    Attributes
    ----------
    grip_per_ampere
        Part of its grip that each driven rim uses, per ampere of its motor.
    full
        Slip of each, m/s, with all its grip, were it to grow linearly.
    across
        s, that wheels which do not slide creep against an acceleration.
    """

    grip_per_ampere: tuple[float, ...]
    full: tuple[float, ...]
    across: float


@dataclass(frozen=True, slots=True)
class BaseDescription:
    """What a recording says of its base, nominal.

    Attributes
    ----------
    wheels
        Names of the driven wheels, as the joints are called.
    radii
        Theirs, m.
    rows
        Rim speed of each (m/s) per (vx, vy, w), a row (3,) each.
    counts_per_turn, gear_ratio
        Of the encoder's shaft, and turns of that shaft per turn of a wheel.
    base
        All wheels; None in recordings that do not hold them.
    creep
        None where it is not said.
    """

    wheels: tuple[str, ...]
    radii: tuple[float, ...]
    rows: tuple[tuple[float, float, float], ...]
    counts_per_turn: int
    gear_ratio: float
    base: WheelBase | None = None
    creep: WheelCreep | None = None


def base_words(
    base: WheelBase, counts_per_turn: int, gear_ratio: float, *, robot: str = "", creep: WheelCreep | None = None
) -> dict[str, dict[str, str]]:
    """Return the words for a base, as `Recorder` takes them; of several robots each has words of its own name."""
    rows = base.rest_coupling * [1.0, 1.0, base.radius]
    description = {
        "name": base.name,
        "wheels": list(base.driven),
        "radii": base.wheel_radii.tolist(),
        "rows": rows.tolist(),
        "counts_per_turn": counts_per_turn,
        "gear_ratio": gear_ratio,
        "base": {
            "radius": base.radius,
            "wheels": [asdict(wheel) for wheel in base.wheels],
            "steering_groups": _groups(base),
        },
    }
    if creep is not None:
        description["creep"] = asdict(creep)
    return {_name(robot): {"kind": "base", "description": json.dumps(description)}}


def base_of(metadata: Mapping[str, Mapping[str, str]], robot: str = "") -> BaseDescription | None:
    """Return what the words of a recording say of a base; None where they say nothing.

    Raises
    ------
    InputError
        Words that cannot be read.
    """
    words = metadata.get(_name(robot), {})
    if words.get("kind") != "base":
        return None
    try:
        description = json.loads(words["description"])
        rows = np.array(description["rows"], dtype=np.float64).reshape(len(description["wheels"]), 3)
        return BaseDescription(
            wheels=tuple(description["wheels"]),
            radii=tuple(float(radius) for radius in description["radii"]),
            rows=tuple((float(x), float(y), float(turn)) for x, y, turn in rows),
            counts_per_turn=int(description["counts_per_turn"]),
            gear_ratio=float(description["gear_ratio"]),
            base=_base(description),
            creep=_creep(description),
        )
    except (InputError, KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise InputError(f"the recording's words on its robot cannot be read ({error}); record it again") from None


def _groups(base: WheelBase) -> dict[str, list[str]]:
    """Names of the wheels that are steered together."""
    groups = zip(base.steered, base.layout.groups, strict=True)
    return {name: [base.wheels[i].name for i in members] for name, members in groups if len(members) > 1}


def _base(description: Mapping[str, Any]) -> WheelBase | None:
    words = description.get("base")
    if words is None:
        return None
    wheels = []
    for wheel in words["wheels"]:
        stated: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in wheel.items()
        }
        wheels.append(Wheel(**stated))
    groups = words["steering_groups"]
    return WheelBase(wheels, name=str(description["name"]), radius=float(words["radius"]), steering_groups=groups)


def _creep(description: Mapping[str, Any]) -> WheelCreep | None:
    words = description.get("creep")
    if words is None:
        return None
    per_ampere, full = (tuple(float(x) for x in words[key]) for key in ("grip_per_ampere", "full"))
    if not len(per_ampere) == len(full) == len(description["wheels"]):
        raise ValueError(f"creep of {len(full)} wheels, {len(description['wheels'])} are there")
    return WheelCreep(per_ampere, full, float(words["across"]))


def _name(robot: str) -> str:
    return f"{robot}/{ROBOT}" if robot else ROBOT
