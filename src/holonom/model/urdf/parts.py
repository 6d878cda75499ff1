"""What one link or one joint of a URDF says, each value checked where it stands."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.model.arm import Body, Friction
from holonom.model.joint_kinds import JOINT_KINDS, kind_of
from holonom.model.limits import JointLimits
from holonom.model.urdf.elements import Element, fault

__all__ = ["UrdfJoint", "UrdfLink", "UrdfMimic", "read_joint", "read_link"]


KINDS = {name: name for name in JOINT_KINDS} | {"continuous": "revolute"}
"""Types of a URDF, and our kinds of joints; a continuous one is without position limits."""
JOINT_PARTS = ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller")


@dataclass(frozen=True, slots=True)
class UrdfLink:
    """A link; `body` in the link's frame, None where the file states no inertia."""

    name: str
    element: Element
    body: Body | None


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


def read_link(element: Element) -> UrdfLink:
    """Return a link; whether its inertia can be is asked elsewhere."""
    element.refuse_misspelt(("inertial", "visual", "collision"))
    inertial = element.one("inertial")
    return UrdfLink(element.word("name"), element, None if inertial is None else _body(inertial))


def _body(inertial: Element) -> Body:
    inertial.refuse_misspelt(("origin", "mass", "inertia"))
    mass = inertial.need("mass", 'state <mass value="..."/> in kg').number("value")
    stated = inertial.need("inertia", "state ixx, ixy, ixz, iyy, iyz, izz in kg m2 about the centre of mass")
    xx, xy, xz, yy, yz, zz = (stated.number(name) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
    if mass < 0:
        raise fault(inertial.need("mass", ""), f"the mass is {mass} kg; it must not be negative")
    T = _pose(inertial.one("origin"))
    R = T[:3, :3]
    I = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    values = [float(I[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    return Body(mass, (float(T[0, 3]), float(T[1, 3]), float(T[2, 3])), (*values,))  # type: ignore[arg-type]


def read_joint(element: Element) -> UrdfJoint:
    """Return a joint."""
    element.refuse_misspelt(JOINT_PARTS)
    name, stated = element.word("name"), _kind(element)
    kind = KINDS[stated]
    mimic = element.one("mimic")
    if mimic is not None and not kind_of(kind).single:
        raise fault(mimic, f"joint {name!r} is {kind} and cannot mimic another; delete <mimic>")
    return UrdfJoint(
        name=name,
        kind=kind,
        parent=element.need("parent", 'state <parent link="..."/>').word("link"),
        child=element.need("child", 'state <child link="..."/>').word("link"),
        pose=_pose(element.one("origin")),
        axis=_axis(element) if kind_of(kind).made_of else (1.0, 0.0, 0.0),
        limits=_limits(element, stated) if kind_of(kind).single else JointLimits(),
        friction=_friction(element),
        mimic=None if mimic is None else _mimic(mimic),
        element=element,
    )


def _kind(element: Element) -> str:
    stated = element.word("type")
    if stated in KINDS:
        return stated
    close = difflib.get_close_matches(stated, KINDS, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    raise fault(element, f"{element.called()} has the unknown type {stated!r}; there is {', '.join(KINDS)}{hint}")


def _axis(element: Element) -> tuple[float, float, float]:
    stated = element.one("axis")
    x, y, z = (1.0, 0.0, 0.0) if stated is None else stated.numbers("xyz", (1.0, 0.0, 0.0))
    length = math.hypot(x, y, z)
    if length < 1e-6:
        raise fault(stated or element, f'{element.called()} has the axis "{x} {y} {z}", which has no direction')
    return x / length, y / length, z / length


def _limits(element: Element, kind: str) -> JointLimits:
    """Position, speed and effort; a continuous joint has no position limits and may state none at all."""
    limit = element.one("limit")
    endless = kind not in JOINT_KINDS
    if endless and limit is None:
        return JointLimits()
    if limit is None or (not endless and not {"lower", "upper"} & limit.attributes.keys()):
        raise fault(
            limit or element,
            f"{element.called()} is {kind} and states no position limits; add <limit lower= upper= effort= velocity=>"
            + (', or make it type="continuous"' if kind_of(KINDS[kind]).turns else ""),
        )
    speed, effort = limit.number("velocity"), limit.number("effort")
    if speed < 0 or effort < 0:
        raise fault(limit, f"{element.called()} has velocity {speed} and effort {effort}; both must not be negative")
    if endless:
        return JointLimits(speed=speed, torque=effort)
    lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
    if lower > upper:
        raise fault(limit, f"{element.called()} has the lower limit {lower} above the upper {upper}; swap them")
    return JointLimits(lower, upper, speed=speed, torque=effort)


def _friction(element: Element) -> Friction | None:
    stated = element.one("dynamics")
    if stated is None:
        return None
    viscous, coulomb = stated.number("damping", 0.0), stated.number("friction", 0.0)
    if viscous < 0 or coulomb < 0:
        raise fault(stated, f"{element.called()} has damping {viscous} and friction {coulomb}; neither may be negative")
    return Friction(viscous, coulomb, coulomb) if viscous or coulomb else None


def _mimic(element: Element) -> UrdfMimic:
    return UrdfMimic(element.word("joint"), element.number("multiplier", 1.0), element.number("offset", 0.0), element)


def _pose(origin: Element | None) -> Array:
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
