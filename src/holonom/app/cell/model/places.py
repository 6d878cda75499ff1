"""Places of a cell: where something stands, in the world or on a robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, model_validator
from scipy.spatial.transform import Rotation

from holonom.app.cell.model.refusals import Faults, refuse
from holonom.app.fields.quantities import Angle, Length, Section, Vector3
from holonom.spatial import pose

__all__ = ["Placement", "placement_pose"]

_KEYS = ("x", "y", "z", "roll", "pitch", "yaw")
_LENGTH, _ANGLE = TypeAdapter(Length), TypeAdapter(Angle)


class Placement(Section):
    """Where something stands: `[x, y, z, roll, pitch, yaw]`, or turned by `angle` about the vertical, then moved."""

    position: Vector3
    """x, y and z of its origin"""
    angle: Angle
    """turn about the z axis, the last of the three"""
    roll: Angle = 0.0
    """turn about the x axis, the first of the three"""
    pitch: Angle = 0.0
    """turn about the y axis, the second of the three"""

    @model_validator(mode="wrap")
    @classmethod
    def _of_six(cls, given: Any, handler: Any) -> Placement:
        if not isinstance(given, list | tuple):
            found: Placement = handler(given)
            return found
        return cls._listed(given)

    @classmethod
    def _listed(cls, given: Sequence[Any]) -> Placement:
        if len(given) != len(_KEYS):
            raise refuse((), f"{len(given)} numbers came; {len(_KEYS)} are needed: {', '.join(_KEYS)}", given)
        faults = Faults()
        found = [faults.call((k,), (_LENGTH if k < 3 else _ANGLE).validate_python, given[k]) for k in range(len(_KEYS))]
        faults.raise_any()
        x, y, z, roll, pitch, yaw = found
        return cls.model_construct(position=(x, y, z), angle=yaw, roll=roll, pitch=pitch)


def placement_pose(placement: Placement | None) -> NDArray[np.float64]:
    """T (4, 4) of a placement; the identity for None."""
    if placement is None:
        return np.eye(4)
    if placement.roll == placement.pitch == 0.0:
        return pose(placement.position, Rotation.from_euler("z", placement.angle).as_matrix())
    turn = Rotation.from_euler("xyz", (placement.roll, placement.pitch, placement.angle))
    return pose(placement.position, turn.as_matrix())
