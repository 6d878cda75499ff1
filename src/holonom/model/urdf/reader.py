"""A strict reader of URDF: what it accepts is one tree of links that can exist; what it refuses, it names by line."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from holonom.arrays import Array
from holonom.errors import ModelError, UnknownName
from holonom.files import read_bytes
from holonom.model.arm import ArmModel, Body, Frame, Joint, Mimic, Motor, constant_transform
from holonom.model.compound import frame_along, joints_of
from holonom.model.joint_kinds import kind_of
from holonom.model.urdf.elements import Element, fault, parse_xml
from holonom.model.urdf.inertia import check_inertias, fixed_together
from holonom.model.urdf.parts import UrdfJoint, UrdfLink, read_joint, read_link
from holonom.model.urdf.transmission import read_motors
from holonom.model.urdf.tree import by_name, in_order, root_of, tip_of

__all__ = ["arm_model_from_urdf", "read_urdf"]

CheckInertia = bool | Literal["warn"]


def read_urdf(
    source: str | Path,
    *,
    root: str | None = None,
    tip: str | None = None,
    check_inertia: CheckInertia = True,
) -> ArmModel:
    """Return the arm that a URDF describes. Meshes are never opened.

    Parameters
    ----------
    source : a file, or the text of one (any string with a "<").
    root : the link that is the base; only what hangs on it is read. By default the link that no joint carries.
    tip : the link that is the tool. By default the link called `tcp`, `tool0`, `tool`, `tool_link`, `tip`, `ee`,
        `ee_link`, `ee_gripper_link`, `end_effector` or `flange` (in this order, also behind a prefix as in
        `left_tool0`); of several, or where none is so called, the one behind the most joints that move on their own,
        then behind the most links, then the first in the file; if that is the finger of a hand (a link before two or
        more branches of at most two joints each), the hand.
    check_inertia : whether an inertia that no rigid body has is an error (True), a warning ("warn") or read as it is.

    Returns
    -------
    ArmModel
        The base is the root link; joints stand in document order, those that carry others first; joint frames are the
        frames of the links they carry; links on fixed joints are merged into the body that carries them. Every link is
        a `Frame` (it wins over a built-in name such as "link1"). A continuous joint is revolute without position
        limits; a joint that mimics another is not part of q. `damping` and `friction` become `Friction`, a
        transmission's reduction (and rotor inertia, where stated) `Motor`. Without any mass that can move,
        `bodies` is None: kinematics only. Angles within 1e-11 rad of a quarter turn are taken as the quarter turn.

    Raises
    ------
    ModelError
        Not XML, not a URDF, no tree, or impossible values; with file, line and what to do.
    UnknownName
        No link `root` or `tip`.
    """
    if isinstance(source, str) and "<" in source:
        robot = parse_xml(source, "URDF text")
    else:
        robot = parse_xml(read_bytes(source, "robot", ModelError), str(source))
    return arm_model_from_urdf(robot, root=root, tip=tip, check_inertia=check_inertia)


def arm_model_from_urdf(
    robot: Element, *, root: str | None = None, tip: str | None = None, check_inertia: CheckInertia = True
) -> ArmModel:
    """Return the arm of a parsed <robot>; see `read_urdf`."""
    _check_robot(robot)
    links = by_name([read_link(element) for element in robot.all("link")])
    joints = by_name([read_joint(element) for element in robot.all("joint")])
    found = root_of(links, list(joints.values()), robot.source)
    root = _known_link(root or found, links)
    ordered, floats = _below_floating(in_order(list(joints.values()), root))
    moving = [joint for joint in ordered if joint.moves]
    if not moving:
        raise fault(robot, f"no joint below link {root!r} moves; an arm needs a revolute or prismatic joint")
    root = floats.child if floats else root
    places = _places(ordered, root)
    check_inertias(links.values(), {name for name, place in places.items() if place.joint >= 0}, check_inertia)
    tool = places[_tip(tip, ordered, root, links, places)]
    made = _joints(moving, places, read_motors(robot, joints))
    base_body, bodies = _bodies(links, places, len(made))
    return ArmModel(
        robot.word("name"),
        made,
        bodies,
        base_body=base_body,
        floating=floats is not None,
        base=constant_transform(np.eye(4) if floats is None else _rest(floats, joints.values())),
        tip=tool.joint,
        tool=constant_transform(tool.pose),
        frames=tuple(Frame(name, place.joint, constant_transform(place.pose)) for name, place in places.items()),
        card=f"Read from {robot.source}.",
    )


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a link is: the number of the moving joint that carries it (-1: the base) and its pose in that frame."""

    joint: int
    pose: Array


def _check_robot(robot: Element) -> None:
    if robot.tag != "robot":
        raise fault(robot, f"the document is a <{robot.tag}>; a URDF is a <robot>")
    robot.refuse_misspelt(("link", "joint", "material", "transmission", "gazebo"))
    for child in robot.children:
        if child.tag.startswith("xacro:"):
            raise fault(child, f"<{child.tag}>: this is xacro, not URDF; name the file *.xacro and use load_arm")


def _known_link(name: str, links: dict[str, UrdfLink]) -> str:
    if name not in links:
        raise UnknownName("link", name, links)
    return name


def _places(ordered: Sequence[UrdfJoint], root: str) -> dict[str, _Place]:
    places = {root: _Place(-1, np.eye(4))}
    count = 0
    for joint in ordered:
        carrier = places[joint.parent]
        freedoms = len(kind_of(joint.kind).made_of)
        if not freedoms:
            places[joint.child] = _Place(carrier.joint, carrier.pose @ joint.pose)
        else:
            count += freedoms
            places[joint.child] = _Place(count - 1, np.eye(4))
    return places


def _below_floating(ordered: Sequence[UrdfJoint]) -> tuple[Sequence[UrdfJoint], UrdfJoint | None]:
    """The joints that a freely moving base carries, and the joint that lets it move; all of them if none does."""
    floating = [joint for joint in ordered if joint.floats]
    if not floating:
        return ordered, None
    first, below = floating[0], {floating[0].child}
    kept = []
    for joint in ordered:
        if joint.parent in below:
            below.add(joint.child)
            kept.append(joint)
    for joint in ordered:
        if joint is not first and (joint.floats or (joint.moves and joint.parent not in below)):
            raise fault(
                joint.element,
                f"joint {joint.name!r} moves beside or behind the floating {first.name!r}; only the base of a "
                "robot may float, and all else must hang on it. Read the parts with root=",
            )
    return kept, first


def _rest(floating: UrdfJoint, joints: Iterable[UrdfJoint]) -> Array:
    """Where a floating joint's child is while nothing has moved: it hangs on fixed joints only."""
    carrier = {joint.child: joint for joint in joints}
    T, link = floating.pose, floating.parent
    while link in carrier:
        T, link = carrier[link].pose @ T, carrier[link].parent
    return T


def _joints(moving: Sequence[UrdfJoint], places: dict[str, _Place], motors: dict[str, Motor]) -> tuple[Joint, ...]:
    joints: list[Joint] = []
    for joint in moving:
        carrier = places[joint.parent]
        A = frame_along(joint.axis)
        made = joints_of(
            joint.name,
            joint.kind,
            carrier.pose @ joint.pose @ A,
            A.T,
            number=len(joints),
            parent=carrier.joint,
            limits=joint.limits,
        )
        joints += made[:-1]
        last, motor, mimic = made[-1], motors.get(joint.name), _mimic(joint, moving, places)
        joints.append(dataclasses.replace(last, motor=motor, friction=joint.friction, mimic=mimic))
    return tuple(joints)


def _mimic(joint: UrdfJoint, moving: Sequence[UrdfJoint], places: dict[str, _Place]) -> Mimic | None:
    if joint.mimic is None:
        return None
    names = [other.name for other in moving]
    if joint.mimic.joint not in names:
        unknown = UnknownName("moving joint", joint.mimic.joint, names)
        raise fault(joint.mimic.element, f"joint {joint.name!r} mimics an unknown joint: {unknown}")
    number = names.index(joint.mimic.joint)
    if (other := moving[number]).mimic is not None:
        raise fault(
            joint.mimic.element,
            f"joint {joint.name!r} mimics {other.name!r}, which mimics {other.mimic.joint!r}; "
            "name the joint that moves on its own, with the factors multiplied",
        )
    if not kind_of(other.kind).single:
        raise fault(joint.mimic.element, f"joint {joint.name!r} mimics {other.name!r}, which is {other.kind}")
    return Mimic(places[other.child].joint, joint.mimic.multiplier, joint.mimic.offset)


def _bodies(
    links: dict[str, UrdfLink], places: dict[str, _Place], count: int
) -> tuple[Body | None, tuple[Body, ...] | None]:
    """The base's body, and those of all joints; None where there is no mass."""
    parts: list[list[tuple[Body, Array]]] = [[] for _ in range(count + 1)]
    for name, place in places.items():
        body = links[name].body
        if body is not None and (body.mass > 0 or any(body.inertia)):
            parts[place.joint + 1].append((body, place.pose))
    base, *rest = parts
    bodies = tuple(fixed_together(part) for part in rest) if any(rest) else None
    return fixed_together(base) if base else None, bodies


def _tip(
    tip: str | None,
    ordered: Sequence[UrdfJoint],
    root: str,
    links: dict[str, UrdfLink],
    places: dict[str, _Place],
) -> str:
    name = _known_link(tip_of(ordered, root) if tip is None else tip, links)
    if name not in places or places[name].joint < 0:
        raise fault(links[name].element, f"tip {name!r} is not moved by any joint; name a link behind a moving joint")
    return name
