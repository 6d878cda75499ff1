"""Where the parts of a robot file are while no joint has moved, seen from the base's own frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import UnknownName
from holonom.model.arm import Body
from holonom.model.urdf.check import Check
from holonom.model.urdf.elements import Element, fault
from holonom.model.urdf.inertia import fixed_together
from holonom.model.urdf.parts import UrdfJoint, UrdfLink, pose_of, read_joint, read_link
from holonom.model.urdf.tree import by_name, in_order, root_of

__all__ = ["Parts", "Round", "parts_of", "round_shape"]

BASES = ("base_link", "base_footprint", "base", "chassis")


@dataclass(frozen=True, slots=True)
class Parts:
    """Links and joints of a robot, and where they are.

    Attributes
    ----------
    robot : the document.
    links, joints : by name.
    frame : link in whose frame everything is seen.
    pose : (4, 4) of each link, x forwards, y left, z up.
    """

    robot: Element
    links: Mapping[str, UrdfLink]
    joints: Mapping[str, UrdfJoint]
    frame: str
    pose: Mapping[str, Array]

    def axis(self, joint: UrdfJoint) -> Array:
        """(3,) direction of a joint's axis."""
        return np.asarray(self.pose[joint.parent][:3, :3] @ joint.pose[:3, :3] @ np.array(joint.axis))

    def place(self, joint: UrdfJoint) -> Array:
        """(3,) m, of a joint's origin."""
        return np.asarray((self.pose[joint.parent] @ joint.pose)[:3, 3])

    def carriers(self, joint: UrdfJoint) -> Iterator[UrdfJoint]:
        """Joints between a joint and the base, from it on."""
        carrying = {one.child: one for one in self.joints.values()}
        link = joint.parent
        while link in carrying and link != self.frame:
            yield carrying[link]
            link = carrying[link].parent

    def carried(self, link: str, *, fixed: bool) -> list[str]:
        """A link and all that hangs on it; on fixed joints only, if asked."""
        found = [link]
        for joint in self.joints.values():
            if joint.parent == link and not (fixed and joint.moves):
                found += self.carried(joint.child, fixed=fixed)
        return found

    def body(self) -> Body | None:
        """Everything as one body, in the base's frame; None without any mass."""
        bodies = [(link.body, self.pose[name]) for name, link in self.links.items() if link.body and link.body.mass > 0]
        return fixed_together(bodies) if bodies else None


def parts_of(robot: Element, frame: str | None, check: Check) -> Parts:
    """Return what a robot file describes.

    Raises
    ------
    ModelError
        No robot, or no tree of links.
    UnknownName
        No link of the name `frame`.
    """
    if robot.tag != "robot":
        raise fault(robot, f"the document is a <{robot.tag}>; a URDF is a <robot>")
    links = by_name([read_link(element, check) for element in robot.all("link")])
    joints = by_name([read_joint(element, check) for element in robot.all("joint")])
    root = root_of(links, list(joints.values()), robot.source)
    if frame is not None and frame not in links:
        raise UnknownName("link", frame, links)
    seen = frame or next((name for name in BASES if name in links), root)
    pose: dict[str, Array] = {root: np.eye(4)}
    for joint in in_order(list(joints.values()), root):
        pose[joint.child] = pose[joint.parent] @ joint.pose
    inverse = np.linalg.inv(pose[seen])
    return Parts(robot, links, joints, seen, {name: inverse @ T for name, T in pose.items()})


@dataclass(frozen=True, slots=True)
class Round:
    """A round shape of a link: radius and where its middle is in the base's frame, m; whether a ball."""

    radius: float
    middle: Array
    ball: bool


def round_shape(parts: Parts, names: Sequence[str]) -> Round | None:
    """The largest cylinder or sphere of links, of what collides rather than of what is seen; meshes are not opened."""
    for what in ("collision", "visual"):
        found = [
            one for name in names for shape in parts.links[name].element.all(what) for one in _shape(parts, name, shape)
        ]
        if found:
            return max(found, key=lambda one: one.radius)
    return None


def _shape(parts: Parts, link: str, shape: Element) -> Iterator[Round]:
    for geometry in shape.all("geometry"):
        for kind in ("cylinder", "sphere"):
            for solid in geometry.all(kind):
                radius = solid.number("radius")
                if radius <= 0.0:
                    raise fault(solid, f"<{kind}> has radius {radius} m; state one above zero")
                origin = shape.all("origin")
                T = parts.pose[link] @ pose_of(origin[0] if origin else None)
                yield Round(radius, T[:3, 3], kind == "sphere")
