"""A reader of URDF: what it accepts is one tree of links; what it refuses, passes over or guesses, it names by line."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from holonom.arrays import Array
from holonom.errors import ModelError, ModelWarning, UnknownName
from holonom.files import read_bytes
from holonom.model.arm import ArmModel, Body, Frame, Joint, Mimic, Motor, constant_transform
from holonom.model.compound import frame_along, joints_of
from holonom.model.joint_kinds import kind_of
from holonom.model.urdf.check import Check, CheckMode
from holonom.model.urdf.elements import Element, NotWellFormed, fault, parse_xml
from holonom.model.urdf.inertia import CheckInertia, check_inertias, fixed_together
from holonom.model.urdf.mend import mended
from holonom.model.urdf.mimic import Follows, follow
from holonom.model.urdf.parts import UrdfJoint, UrdfLink, read_joint, read_link
from holonom.model.urdf.tool import guess_tool
from holonom.model.urdf.transmission import read_motors
from holonom.model.urdf.tree import below_floating, by_name, in_order, root_of, sizes_of

__all__ = ["arm_model_from_urdf", "read_urdf", "urdf_document", "urdf_model", "warn_of"]

XACRO = "xacro:"


def read_urdf(
    source: str | Path,
    *,
    root: str | None = None,
    tip: str | None = None,
    check: CheckMode = "warn",
    check_inertia: CheckInertia = True,
) -> ArmModel:
    """Return the arm that a URDF describes. Meshes are never opened.

    Parameters
    ----------
    source : a file, or the text of one (any string with a "<").
    root : the link that is the base; only what hangs on it is read. By default the link that no joint carries.
    tip : the link that is the tool. By default the link that is called like one, else the last one: a guess, of which
        a warning names the candidates (see `tool.guess_tool`).
    check : "warn": what a file may leave out or say too much is taken as the warning says; "strict": it is an error.
    check_inertia : True: a moving link with an inertia that no rigid body has leaves the arm with kinematics only, and
        dynamics say why (in a strict check it is an error); "warn": it is taken with a warning; False: it is taken.

    Returns
    -------
    ArmModel
        The base is the root link; joints stand in document order, those that carry others first; joint frames are the
        frames of the links they carry; links on fixed joints are merged into the body that carries them. Every link is
        a `Frame` (it wins over a built-in name such as "link1"). A continuous joint is revolute without position
        limits; a joint that mimics another is not part of q. A floating joint frees the base if all that moves hangs
        on it; others are fixed where they stand. `damping` and `friction` become `Friction`, a transmission's
        reduction (and rotor inertia, where stated) `Motor`. Without any mass that can move, `bodies` is None:
        kinematics only. `notes` holds what the warnings said. Angles within 1e-11 rad of a quarter turn are taken as
        the quarter turn.

    Raises
    ------
    ModelError
        Not XML, not a URDF, no tree, or impossible values; with file, line and what to do.
    UnknownName
        No link `root` or `tip`; no such `check`.

    Warns
    -----
    ModelWarning
        What was passed over or guessed; with file and line.
    """
    model = urdf_model(source, root=root, tip=tip, check=check, check_inertia=check_inertia)
    warn_of(model)
    return model


def warn_of(model: ArmModel) -> None:
    """Give the warnings of a model that was read, to the caller of the function that calls this one."""
    for note in model.notes:
        warnings.warn(note, ModelWarning, stacklevel=3)


def urdf_model(
    source: str | Path,
    *,
    root: str | None = None,
    tip: str | None = None,
    check: CheckMode = "warn",
    check_inertia: CheckInertia = True,
) -> ArmModel:
    """Return what `read_urdf` does, and give no warnings: they are the model's notes."""
    found = Check(check)
    robot = urdf_document(source, found)
    return arm_model_from_urdf(robot, root=root, tip=tip, check=found, check_inertia=check_inertia)


def urdf_document(source: str | Path, check: Check) -> Element:
    """The parsed document of a file, or of the text of one (any string with a "<")."""
    if isinstance(source, str) and "<" in source:
        return _parsed(source, "URDF text", check)
    return _parsed(read_bytes(source, "robot", ModelError), str(source), check)


def _parsed(content: str | bytes, source: str, check: Check) -> Element:
    """The document; unless the check is strict, mended as far as it can be where it is not well-formed."""
    try:
        return parse_xml(content, source)
    except NotWellFormed:
        again = mended(content.encode() if isinstance(content, str) else content)
        if check.strict or not again.faults:
            raise
    robot = parse_xml(again.content, source, before=again.before)
    for line, what in again.faults:
        check.remark(f"{source}, line {line}: not well-formed XML: {what}; it is passed over")
    return robot


def arm_model_from_urdf(
    robot: Element,
    *,
    root: str | None = None,
    tip: str | None = None,
    check: Check,
    check_inertia: CheckInertia = True,
) -> ArmModel:
    """Return the arm of a parsed <robot>; see `read_urdf`."""
    _check_robot(robot, check)
    links = by_name([read_link(element, check) for element in robot.all("link")])
    joints = by_name([read_joint(element, check) for element in robot.all("joint")])
    found = root_of(links, list(joints.values()), robot.source)
    root = _known_link(root or found, links)
    ordered, floats = below_floating(in_order(list(joints.values()), root), check)
    moving = [joint for joint in ordered if joint.moves]
    if not moving:
        _refuse_xacro(robot)
        raise fault(robot, f"no joint below link {root!r} moves; an arm needs a revolute or prismatic joint")
    root = floats.child if floats else root
    places = _places(ordered, root)
    moved = {name for name, place in places.items() if place.joint >= 0 or floats is not None}
    no_inertia = check_inertias(links.values(), moved, sizes_of(ordered), check_inertia, check)
    tool_frame = _tip(tip, ordered, root, links, places, check)
    tool = places[tool_frame]
    made = _joints(moving, places, read_motors(robot, joints, check), follow(moving, check))
    base_body, bodies = (None, None) if no_inertia else _bodies(links, places, len(made))
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
        tool_frame=tool_frame,
        no_inertia=no_inertia,
        notes=check.notes,
    )


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a link is: the number of the moving joint that carries it (-1: the base) and its pose in that frame."""

    joint: int
    pose: Array


def _check_robot(robot: Element, check: Check) -> None:
    if robot.tag != "robot":
        raise fault(robot, f"the document is a <{robot.tag}>; a URDF is a <robot>")
    check.known(robot, ("link", "joint", "material", "transmission", "gazebo"))
    if check.strict:
        _refuse_xacro(robot)
    for child in robot.children:
        if child.tag.startswith(XACRO):
            check.note(child, f"<{child.tag}>: this is xacro, not URDF: it is passed over")


def _refuse_xacro(robot: Element) -> None:
    for child in robot.children:
        if child.tag.startswith(XACRO):
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


def _rest(floating: UrdfJoint, joints: Iterable[UrdfJoint]) -> Array:
    """Where a floating joint's child is while nothing has moved: it hangs on fixed joints only."""
    carrier = {joint.child: joint for joint in joints}
    T, link = floating.pose, floating.parent
    while link in carrier:
        T, link = carrier[link].pose @ T, carrier[link].parent
    return T


def _joints(
    moving: Sequence[UrdfJoint], places: dict[str, _Place], motors: dict[str, Motor], follows: dict[str, Follows]
) -> tuple[Joint, ...]:
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
        last, motor, mimic = made[-1], motors.get(joint.name), None
        if (way := follows.get(joint.name)) is not None:
            mimic = Mimic(places[way.master.child].joint, way.multiplier, way.offset)
        joints.append(dataclasses.replace(last, motor=motor, friction=joint.friction, mimic=mimic))
    return tuple(joints)


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
    check: Check,
) -> str:
    if tip is None:
        return guess_tool(ordered, root, links, check)
    name = _known_link(tip, links)
    if name not in places or places[name].joint < 0:
        raise fault(links[name].element, f"tip {name!r} is not moved by any joint; name a link behind a moving joint")
    return name
