"""How the links of a URDF hang together: one root, no loop, every name known; the order of its joints."""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import TypeVar

from holonom.errors import ModelError, UnknownName
from holonom.model.urdf.elements import fault
from holonom.model.urdf.parts import UrdfJoint, UrdfLink

__all__ = ["by_name", "in_order", "root_of", "tip_of"]

Part = TypeVar("Part", UrdfLink, UrdfJoint)

TOOL_NAMES = ("tcp", "tool0", "tool", "tool_link", "tip", "ee", "ee_link", "ee_gripper_link", "end_effector", "flange")
"""What the tool's link is called by convention, best first; also behind a prefix, as in `left_tool0`."""

FINGER_JOINTS = 2
"""The most joints in a row that are still taken for a finger."""


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


def tip_of(ordered: Sequence[UrdfJoint], root: str) -> str:
    """The link that carries the tool where nobody says which: see `read_urdf`."""
    depth = {root: (0, 0)}
    leaves = dict.fromkeys([root])
    for joint in ordered:
        moving, links = depth[joint.parent]
        depth[joint.child] = (moving + (joint.moves and joint.mimic is None), links + 1)
        leaves.pop(joint.parent, None)
        leaves[joint.child] = None
    for convention in TOOL_NAMES:
        called = [link for link in depth if link.lower() == convention or link.lower().endswith(f"_{convention}")]
        called = [link for link in called if depth[link][0] > 0]
        if called:
            return max(called, key=lambda link: depth[link][0])
    farthest = max(leaves, key=lambda link: depth[link])
    return _hand(farthest, ordered, root) or farthest


def _hand(finger: str, ordered: Sequence[UrdfJoint], root: str) -> str | None:
    """The link before a finger, if the way to it ends in two or more moving branches of a few joints each."""
    body = {root: root}  # the first link of the rigid body that a link belongs to
    for joint in ordered:
        body[joint.child] = joint.child if joint.moves else body[joint.parent]
    moving = [joint for joint in ordered if joint.moves]
    branches = Counter(body[joint.parent] for joint in moving)
    height: defaultdict[str, int] = defaultdict(int)
    for joint in reversed(moving):
        height[body[joint.parent]] = max(height[body[joint.parent]], height[joint.child] + 1)
    carrier = {joint.child: joint for joint in ordered}
    hand = None
    while finger != root:
        joint = carrier[finger]
        finger, palm = joint.parent, body[joint.parent]
        if joint.moves and palm != root and branches[palm] > 1 and height[palm] <= FINGER_JOINTS:
            hand = finger
    return hand
