"""Tables that cell files of arms and of mobile bases share."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict

from holonom.app.cell_fields import Angle, Quantity, Section, Text, Vector3

__all__ = ["About", "Placement"]


class About(Section):
    """The cell as a whole."""

    name: Text
    """what the cell is called"""
    description: str = ""
    """one sentence for the report"""
    seed: Annotated[int, Strict(), Field(ge=0, lt=2**63)] = 0
    """seed of everything random; the same seed gives the same recording"""
    time_limit: Annotated[float, Quantity("time", "1ms", "1440min")]
    """simulated time after which the run stops"""


class Placement(Section):
    """Where something stands in the world: turned by `angle` about the vertical, then moved."""

    position: Vector3
    """x, y and z of its origin in the world"""
    angle: Angle
    """turn about the world's z axis"""
