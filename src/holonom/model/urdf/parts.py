"""What one link or one joint of a URDF says, each value checked where it stands."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import ModelError
from holonom.model.arm import Body, Friction
from holonom.model.joint_kinds import JOINT_KINDS, kind_of
from holonom.model.limits import JointLimits
from holonom.model.urdf.check import Check
from holonom.model.urdf.elements import Element, fault
from holonom.model.urdf.limits import read_limits

__all__ = ["MOMENTS", "UrdfJoint", "UrdfLink", "UrdfMimic", "pose_of", "read_joint", "read_link"]


KINDS = {name: name for name in JOINT_KINDS} | {"continuous": "revolute"}
"""Types of a URDF, and our kinds of joints; a continuous one is without position limits."""
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
JOINT_PARTS = ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller")


@dataclass(frozen=True, slots=True)
class UrdfLink:
    """A link; `body` in the link's frame, None where the file states no inertia or, as `problem` says, none to read."""

    name: str
    element: Element
    body: Body | None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class UrdfMimic:
    """Follows the joint called `joint`: q = multiplier * q_joint + offset."""

    joint: str
    multiplier: float
    offset: float
    element: Element


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """A joint between two links: `pose` is T_parent,joint at q = 0, `axis` a unit vector in the joint's frame."""

    name: str
    kind: str
    parent: str
    child: str
    pose: Array
    axis: tuple[float, float, float]
    limits: JointLimits
    friction: Friction | None
    mimic: UrdfMimic | None
    element: Element

    @property
    def moves(self) -> bool:
        """Whether it has a place in q, or follows what has."""
        return bool(kind_of(self.kind).made_of)

    @property
    def floats(self) -> bool:
        """Whether what it carries moves freely."""
        return kind_of(self.kind).free


def read_link(element: Element, check: Check) -> UrdfLink:
    """Return a link; whether its inertia can be is asked elsewhere."""
    check.known(element, ("inertial", "visual", "collision"))
    name, inertial = element.word("name"), check.one(element, "inertial")
    if inertial is None:
        return UrdfLink(name, element, None)
    try:
        return UrdfLink(name, element, _body(inertial, check))
    except ModelError as error:  # kinematics do without it
        if check.strict:
            raise
        return UrdfLink(name, element, None, str(error))


def _body(inertial: Element, check: Check) -> Body:
    check.known(inertial, ("origin", "mass", "inertia"))
    for tag in ("origin", "mass", "inertia"):
        check.one(inertial, tag)
    mass = inertial.need("mass", 'state <mass value="..."/> in kg').number("value")
    stated = inertial.need("inertia", "state ixx, ixy, ixz, iyy, iyz, izz in kg m2 about the centre of mass")
    xx, xy, xz, yy, yz, zz = (stated.number(name) for name in MOMENTS)
    if mass < 0:
        raise fault(inertial.need("mass", ""), f"the mass is {mass} kg; it must not be negative")
    T = pose_of(check.one(inertial, "origin"))
    R = T[:3, :3]
    I = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    values = [float(I[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    return Body(mass, (float(T[0, 3]), float(T[1, 3]), float(T[2, 3])), (*values,))  # type: ignore[arg-type]


def read_joint(element: Element, check: Check) -> UrdfJoint:
    """Return a joint."""
    check.known(element, JOINT_PARTS)
    for tag in ("parent", "child"):
        check.one(element, tag)
    name, stated = element.word("name"), _kind(element)
    kind = KINDS[stated]
    return UrdfJoint(
        name=name,
        kind=kind,
        parent=element.need("parent", 'state <parent link="..."/>').word("link"),
        child=element.need("child", 'state <child link="..."/>').word("link"),
        pose=pose_of(check.one(element, "origin")),
        axis=_axis(element, check) if kind_of(kind).made_of else (1.0, 0.0, 0.0),
        limits=read_limits(element, stated, check) if kind_of(kind).single else JointLimits(),
        friction=_friction(element, check),
        mimic=_mimic(element, kind, check),
        element=element,
    )


def _kind(element: Element) -> str:
    stated = element.word("type")
    if stated in KINDS:
        return stated
    close = difflib.get_close_matches(stated, KINDS, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    raise fault(element, f"{element.called()} has the unknown type {stated!r}; there is {', '.join(KINDS)}{hint}")


def _axis(element: Element, check: Check) -> tuple[float, float, float]:
    stated = check.one(element, "axis")
    x, y, z = (1.0, 0.0, 0.0) if stated is None else stated.numbers("xyz", (1.0, 0.0, 0.0))
    length = math.hypot(x, y, z)
    if length < 1e-6:
        raise fault(stated or element, f'{element.called()} has the axis "{x} {y} {z}", which has no direction')
    return x / length, y / length, z / length


def _friction(element: Element, check: Check) -> Friction | None:
    stated = check.one(element, "dynamics")
    if stated is None:
        return None
    viscous, coulomb = stated.number("damping", 0.0), stated.number("friction", 0.0)
    if viscous < 0 or coulomb < 0:
        problem = f"{element.called()} has damping {viscous} and friction {coulomb}"
        check.doubt(stated, problem, "what is negative is taken as 0", instead="neither may be negative")
        viscous, coulomb = max(viscous, 0.0), max(coulomb, 0.0)
    return Friction(viscous, coulomb, coulomb) if viscous or coulomb else None


def _mimic(element: Element, kind: str, check: Check) -> UrdfMimic | None:
    stated = check.one(element, "mimic")
    if stated is None:
        return None
    if not kind_of(kind).single:
        problem = f"joint {element.word('name')!r} is {kind} and cannot mimic another"
        check.doubt(stated, problem, "its <mimic> is passed over", instead="delete <mimic>")
        return None
    return UrdfMimic(stated.word("joint"), stated.number("multiplier", 1.0), stated.number("offset", 0.0), stated)


def pose_of(origin: Element | None) -> Array:
    """T from xyz and rpy: R = Rz(yaw) Ry(pitch) Rx(roll)."""
    T = np.eye(4)
    if origin is not None:
        (cr, sr), (cp, sp), (cy, sy) = (_cos_sin(angle) for angle in origin.numbers("rpy", (0.0, 0.0, 0.0)))
        Rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
        Ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
        Rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
        T[:3, :3] = Rz @ Ry @ Rx
        T[:3, 3] = origin.numbers("xyz", (0.0, 0.0, 0.0))
    return T


def _cos_sin(angle: float) -> tuple[float, float]:
    """Exact at quarter turns, which files write with as few as eleven decimals."""
    quarters = round(angle / (math.pi / 2))
    if abs(angle - quarters * (math.pi / 2)) < 1e-11:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarters % 4]
    return math.cos(angle), math.sin(angle)
