"""The kinds of joints with one degree of freedom."""

from __future__ import annotations

from holonom.registry import Method, Table

__all__ = ["JOINT_KINDS"]

_CRAIG = "Craig, Introduction to Robotics, 3.2"

JOINT_KINDS = Table(
    "joint_kinds",
    "joint kind",
    "the unit of its position",
    {
        "revolute": Method("turns about its z axis", lambda _: "rad", _CRAIG),
        "prismatic": Method("slides along its z axis", lambda _: "m", _CRAIG),
    },
    closed=True,
)
"""The equations of motion are written for these two, so entry points add none."""
