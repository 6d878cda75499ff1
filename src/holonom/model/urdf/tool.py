"""Which link of a URDF is the tool, where nobody says: the one that is called like one, else a guess that is told."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.model.urdf.check import Check
from holonom.model.urdf.parts import UrdfJoint, UrdfLink

__all__ = ["NO_TOOLS", "TOOL_NAMES", "guess_tool"]

TOOL_NAMES = (
    "tcp", "tool0", "tool", "tool center point", "tool centre point", "grasp", "grasp center",
    "grasp centre", "grasp target", "grasptarget", "ee", "eef",
    "ee gripper", "end effector", "endeffector", "tip", "gripper", "hand", "palm", "flange",
)  # fmt: skip
"""What the tool's link is called by convention, best first; also behind a prefix and before `link` or `frame`, in any
case and with any sign between the words: `left_tool0`, `EndEffector_Link`."""

NO_TOOLS = ("camera", "optical", "sensor", "wheel", "caster", "castor", "finger", "thumb", "knuckle", "collision")
NO_TOOLS_ALONE = (
    "sc", "cam", "depth", "color", "colour", "rgb", "infra", "imu", "gyro", "accel", "accelerometer", "laser", "lidar",
    "scan", "sonar", "range", "ranger", "aruco", "marker", "tag", "jaw", "pad", "index", "pinky", "rotor", "propeller",
    "skin", "visual",
)  # fmt: skip
"""Parts of names, and whole words in them, of links that are no tool: cameras and sensors, self-collision bodies (as
`link7_sc`), wheels, fingers."""

HANDS = ("gripper", "hand", "palm")
"""Words in the names of links that carry fingers: what moves on them is no tool, unless it is called like one."""

FINGER_JOINTS = 2
"""The most joints in a row that are still taken for a finger."""
NAMED = 6
"""The most candidates that a warning names."""


class _Link(NamedTuple):
    """A link behind moving joints: how many move on their own, how many links, whether a hand moves it, where it is."""

    name: str
    joints: int
    links: int
    in_hand: bool
    moved_by: str
    pose: Array

    def coincides(self, other: _Link) -> bool:
        """Whether two links are always at the same place."""
        return self.moved_by == other.moved_by and bool(np.abs(self.pose - other.pose).max() < 1e-9)


def guess_tool(ordered: Sequence[UrdfJoint], root: str, links: Mapping[str, UrdfLink], check: Check) -> str:
    """Return the link that carries the tool.

    It is the one with the best of `TOOL_NAMES`. Where several share it in different places, or none has any, it is
    the one behind the most joints that move on their own, then behind the most links, then the first in the file; if
    that is the finger of a hand (a link before two or more branches of at most two joints each), the hand. Links that
    are called like a camera, a sensor, a self-collision body, a wheel or a finger are taken only where nothing else
    moves. Such a guess is noted, with the candidates.
    """
    moved = _moved(ordered, root)
    fit = [link for link in moved if not _no_tool(link.name)] or moved
    called = [link for link in fit if _rank(link.name) < len(TOOL_NAMES)]
    if called:
        best = min(_rank(link.name) for link in called)
        alike = [link for link in called if _rank(link.name) == best]
        taken = max(alike, key=lambda link: (link.joints, link.links))
        rivals = [link for link in alike if not link.coincides(taken)]
        if rivals:
            _note(taken, "several links are called like a tool", [taken, *rivals], links, check)
        return taken.name
    fit = [link for link in fit if not link.in_hand] or fit
    carriers = {joint.parent for joint in ordered if joint.child in {link.name for link in fit}}
    ends = [link for link in fit if link.name not in carriers]
    last = max(ends, key=lambda link: (link.joints, link.links))
    hand = _hand(last.name, ordered, root)
    taken = next((link for link in fit if link.name == hand), last)
    if len(ends) > 1 or len(fit) < len(moved):
        candidates = sorted(
            [taken, *(end for end in ends if end is not taken)],
            key=lambda link: (link is not taken, -link.joints, -link.links),
        )
        _note(taken, "no link is called like a tool", candidates, links, check)
    return taken.name


def _note(taken: _Link, why: str, candidates: Sequence[_Link], links: Mapping[str, UrdfLink], check: Check) -> None:
    names = ", ".join(link.name for link in candidates[:NAMED]) + (", ..." if len(candidates) > NAMED else "")
    check.note(
        links[taken.name].element,
        f"{why}: {taken.name!r} is taken for the tool, a guess; say which link it is with tip= (candidates: {names})",
    )


def _moved(ordered: Sequence[UrdfJoint], root: str) -> list[_Link]:
    """The links that joints move."""
    found = {root: _Link(root, 0, 0, False, "", np.eye(4))}
    for joint in ordered:
        carrier = found[joint.parent]
        alone = joint.moves and joint.mimic is None
        moved_by, pose = (joint.name, np.eye(4)) if joint.moves else (carrier.moved_by, carrier.pose @ joint.pose)
        in_hand = carrier.in_hand or (joint.moves and any(word in HANDS for word in _words(joint.parent)))
        found[joint.child] = _Link(joint.child, carrier.joints + alone, carrier.links + 1, in_hand, moved_by, pose)
    return [link for link in found.values() if link.moved_by]


def _words(name: str) -> list[str]:
    """The words of a name: split at capitals and at what is no letter or digit."""
    spaced = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", name)
    return re.findall(r"[a-z0-9]+", spaced.lower())


def _rank(name: str) -> int:
    """Which of `TOOL_NAMES` a link is called; as many as there are if none."""
    words = _words(name)
    while len(words) > 1 and words[-1] in ("link", "frame"):
        words.pop()
    called = f" {' '.join(words)}"
    return next((i for i, known in enumerate(TOOL_NAMES) if called.endswith(f" {known}")), len(TOOL_NAMES))


def _no_tool(name: str) -> bool:
    words = [word.rstrip("0123456789") for word in _words(name)]
    return any(part in name.lower() for part in NO_TOOLS) or any(word in NO_TOOLS_ALONE for word in words)


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
