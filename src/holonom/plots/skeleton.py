"""An arm as sticks: the places of its joints in the room, branch by branch."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import ShapeError
from holonom.mechanics import Arm

__all__ = ["configurations", "reach", "sticks"]


def configurations(arm: Arm, q: ArrayLike) -> Array:
    """`q` as finite rows (k, n)."""
    rows = np.atleast_2d(np.asarray(q, dtype=np.float64))
    if rows.ndim != 2 or rows.shape[1] != arm.n or not np.isfinite(rows).all():
        raise ShapeError(f"q has shape {np.shape(q)}; give one finite configuration ({arm.n},) or several (k, {arm.n})")
    return rows


def sticks(arm: Arm, frames: Array) -> list[Array]:
    """Polylines (m, 3) of one configuration from `Arm.frames` (n + 2, 4, 4).

    Each goes from the base, or from the joint where it branches off, outward along the axes and links to a tip.
    """
    model = arm.model
    count = len(model.joints)
    parents = [model.parent(i) for i in range(count)]
    ends = [i for i in range(count) if i not in parents]
    drawn: set[int] = set()
    lines = []
    for end in ends:
        chain, i = [], end
        while i >= 0 and i not in drawn:
            chain.append(i)
            i = parents[i]
        drawn |= set(chain)
        points = [frames[i + 1][:3, 3]]
        for j in reversed(chain):
            points += [*_along_axis(arm, frames, parents[j], j), frames[j + 1][:3, 3]]
        if end == model.tool_joint:
            points.append(frames[-1][:3, 3])
        lines.append(np.array(points))
    if model.tool_joint not in ends:
        lines.append(frames[[model.tool_joint + 1, -1], :3, 3])
    return lines


def _along_axis(arm: Arm, frames: Array, parent: int, joint: int) -> list[Array]:
    """Where the joint sits, and the point of its axis that is next to the frame that it moves."""
    T = frames[parent + 1] @ np.array(arm.model.joints[joint].before)
    place, axis = T[:3, 3], T[:3, 2]
    return [place, place + axis * (axis @ (frames[joint + 1][:3, 3] - place))]


def reach(lines: list[Array]) -> tuple[Array, float]:
    """Middle of all sticks (3,) and half the side of the cube around them (m)."""
    points = np.concatenate(lines)
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), max(0.55 * float((high - low).max()), 1e-3)
