"""Denavit-Hartenberg tables as arm models (Denavit & Hartenberg 1955; Craig, Introduction to Robotics, ch. 3)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from holonom.errors import ModelError, UnknownName
from holonom.model.arm import ArmModel, Body, Joint, Transform, constant_transform
from holonom.model.joint_kinds import kind_of
from holonom.model.limits import JointLimits

__all__ = ["DHRow", "arm_model_from_dh", "joint_from_dh"]

Convention = Literal["standard", "modified"]


@dataclass(frozen=True, slots=True)
class DHRow:
    """One row of a DH table (m, rad). The variable of a revolute joint adds to `theta`, of a prismatic one to `d`."""

    a: float = 0.0
    alpha: float = 0.0
    d: float = 0.0
    theta: float = 0.0
    kind: str = "revolute"

    def __post_init__(self) -> None:
        for name in ("a", "alpha", "d", "theta"):
            if not math.isfinite(getattr(self, name)):
                raise ModelError(f"DH parameter {name} is {getattr(self, name)}; a finite number is needed")
        if not kind_of(str(self.kind)).single:
            raise ModelError(f"a row of a DH table is a joint of one freedom, revolute or prismatic, not {self.kind}")


def _turn(axis: Literal["x", "z"], angle: float) -> NDArray[np.float64]:
    """Return a rotation about x or z, exact at multiples of a quarter turn."""
    quarter = angle / (math.pi / 2)
    if abs(quarter - round(quarter)) < 1e-12:
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarter) % 4]
    else:
        c, s = math.cos(angle), math.sin(angle)
    T = np.eye(4)
    i, j = (1, 2) if axis == "x" else (0, 1)
    T[i, i], T[i, j], T[j, i], T[j, j] = c, -s, s, c
    return T


def _shift(x: float, z: float) -> NDArray[np.float64]:
    T = np.eye(4)
    T[0, 3], T[2, 3] = x, z
    return T


def joint_transforms(row: DHRow, convention: Convention) -> tuple[Transform, Transform]:
    """Return (before, after) of a joint's motion about its z axis."""
    along_x = _shift(row.a, 0.0) @ _turn("x", row.alpha)
    along_z = _turn("z", row.theta) @ _shift(0.0, row.d)
    if convention == "standard":
        return constant_transform(np.eye(4)), constant_transform(along_z @ along_x)
    if convention == "modified":
        return constant_transform(along_x), constant_transform(along_z)
    raise UnknownName("DH convention", str(convention), ("standard", "modified"))


def joint_from_dh(name: str, row: DHRow, convention: Convention, limits: JointLimits = JointLimits()) -> Joint:
    """Return a joint from its DH row."""
    before, after = joint_transforms(row, convention)
    return Joint(name, row.kind, before, after, limits)


def arm_model_from_dh(
    rows: Sequence[DHRow],
    *,
    convention: Convention,
    name: str = "arm",
    limits: Sequence[JointLimits] | None = None,
    bodies: Sequence[Body] | None = None,
) -> ArmModel:
    """Return an arm from a DH table; the convention is never guessed."""
    bounds = list(limits) if limits is not None else [JointLimits()] * len(rows)
    if len(bounds) != len(rows):
        raise ModelError(f"{len(rows)} DH rows and {len(bounds)} limits; one each is needed")
    joints = tuple(
        joint_from_dh(f"joint{k + 1}", row, convention, bound)
        for k, (row, bound) in enumerate(zip(rows, bounds, strict=True))
    )
    return ArmModel(name, joints, None if bodies is None else tuple(bodies))
