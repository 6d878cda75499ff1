"""The joints between base and tool of a tree, as an arm of their own."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

from holonom.model.arm import ArmModel

__all__ = ["ToolChain", "tool_chain"]


class ToolChain(NamedTuple):
    """An arm of the joints that move the tool, and the places of its joints in the whole model's q."""

    model: ArmModel
    places: tuple[int, ...]


def tool_chain(model: ArmModel) -> ToolChain | None:
    """What moves the tool, without what hangs beside it: grippers, covers, a second arm.

    A joint that others beside the way follow keeps the limits that they give it (`ArmModel.limits`). None where all
    joints lie on the way, or where one on it follows another: then they are no chain of joints that move on their own.
    """
    way: list[int] = []
    i = model.tool_joint
    while i >= 0:
        way.insert(0, i)
        i = model.parent(i)
    if len(way) == len(model.joints) or not way or any(model.joints[i].mimic is not None for i in way):
        return None
    joints = tuple(dataclasses.replace(model.joints[i], limits=model.limits(i), parent=None) for i in way)
    # Named alike, for its kernels' names; what frames and poses there are belong to the whole.
    chain = dataclasses.replace(model, joints=joints, bodies=None, tip=None, frames=(), poses={}, floating=False)
    return ToolChain(chain, tuple(model.independent.index(i) for i in way))
