"""How the links of a URDF hang together: one root, no loop, every name known; the order of its joints."""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np

from holonom.errors import ModelError, UnknownName
from holonom.model.urdf.check import Check
from holonom.model.urdf.elements import fault
from holonom.model.urdf.parts import UrdfJoint, UrdfLink

__all__ = ["below_floating", "by_name", "in_order", "root_of", "sizes_of"]

Part = TypeVar("Part", UrdfLink, UrdfJoint)


def by_name(parts: Sequence[Part]) -> dict[str, Part]:
    """The parts under their names, in document order; two of one name are an error."""
    found: dict[str, Part] = {}
    for part in parts:
        if part.name in found:
            first = found[part.name].element
            raise fault(part.element, f"a second {part.element.called()}; the first is in line {first.line}; rename it")
        found[part.name] = part
    return found


def root_of(links: Mapping[str, UrdfLink], joints: Sequence[UrdfJoint], source: str) -> str:
    """The one link that no joint carries."""
    carried: dict[str, UrdfJoint] = {}
    for joint in joints:
        _check_ends(joint, links)
        if joint.child in carried:
            other = carried[joint.child]
            raise fault(
                joint.element,
                f"link {joint.child!r} is carried by joint {other.name!r} (line {other.element.line}) and by "
                f"{joint.name!r}: a closed chain. A URDF is a tree; take one of the joints out",
            )
        carried[joint.child] = joint
    roots = [name for name in links if name not in carried]
    if len(roots) > 1:
        named = ", ".join(f"{name!r} (line {links[name].element.line})" for name in roots)
        raise fault(links[roots[1]].element, f"more than one root: no joint carries {named}. add a fixed joint")
    _refuse_loop(roots, joints, source)
    return roots[0]


def _check_ends(joint: UrdfJoint, links: Mapping[str, UrdfLink]) -> None:
    for end, name in (("parent", joint.parent), ("child", joint.child)):
        if name not in links:
            unknown = UnknownName("link", name, links)
            raise fault(joint.element.need(end, ""), f"joint {joint.name!r} has an unknown {end}: {unknown}")


def _refuse_loop(roots: Sequence[str], joints: Sequence[UrdfJoint], source: str) -> None:
    """Links that cannot be reached from the root carry each other in a circle."""
    reached = {joint.name for joint in in_order(joints, roots[0])} if roots else set()
    for joint in joints:
        if joint.name not in reached:
            raise fault(
                joint.element, f"joint {joint.name!r} is part of a loop: it leads to no root link; take one out"
            )
    if not roots:
        raise ModelError(f"{source}: no <link>; a robot needs at least two and a joint between them")


def in_order(joints: Sequence[UrdfJoint], root: str) -> list[UrdfJoint]:
    """The joints below a link, carriers first, else as in the document."""
    below: defaultdict[str, list[int]] = defaultdict(list)
    for number, joint in enumerate(joints):
        below[joint.parent].append(number)
    waiting = list(below[root])
    ordered: list[UrdfJoint] = []
    while waiting:
        joint = joints[heapq.heappop(waiting)]
        ordered.append(joint)
        for number in below[joint.child]:
            heapq.heappush(waiting, number)
    return ordered


def below_floating(ordered: Sequence[UrdfJoint], check: Check) -> tuple[Sequence[UrdfJoint], UrdfJoint | None]:
    """The joints that a freely moving base carries, and the joint that lets it move; all of them if none does.

    Only a floating joint that all that moves hangs on frees the base; others are fixed where they stand.
    """
    floating = [joint for joint in ordered if joint.floats]
    first = next((joint for joint in floating if _carries_all(joint, ordered)), None)
    for joint in floating:
        if joint is not first:
            check.doubt(
                joint.element,
                f"joint {joint.name!r} floats, and not all that moves hangs on it",
                "it is fixed where it stands; only the base of a robot may float",
                instead="only the base of a robot may float, and all else must hang on it. Read the parts with root=",
            )
    if first is None:
        return ordered, None
    below = _below(first, ordered)
    return [joint for joint in ordered if joint.parent in below], first


def _below(joint: UrdfJoint, ordered: Sequence[UrdfJoint]) -> set[str]:
    """The links that a joint carries."""
    below = {joint.child}
    for other in ordered:
        if other.parent in below:
            below.add(other.child)
    return below


def _carries_all(joint: UrdfJoint, ordered: Sequence[UrdfJoint]) -> bool:
    below = _below(joint, ordered)
    return all(other.parent in below for other in ordered if other.moves)


def sizes_of(ordered: Sequence[UrdfJoint]) -> dict[str, float]:
    """How far from a link's origin the joints are that it carries, m."""
    sizes: dict[str, float] = {}
    for joint in ordered:
        sizes[joint.parent] = max(sizes.get(joint.parent, 0.0), float(np.linalg.norm(joint.pose[:3, 3])))
    return sizes
