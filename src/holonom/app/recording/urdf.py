"""An arm as URDF, for tools that draw one: its links are called as frames of the recording are, its joints, too."""

from __future__ import annotations

import math
from collections.abc import Callable
from xml.sax.saxutils import quoteattr

import numpy as np
from scipy.spatial.transform import Rotation

from holonom.arrays import Array
from holonom.model import ArmModel, Body
from holonom.model.arm import Joint

__all__ = ["BASE", "urdf_of"]

BASE = "base"
"""Frame that an arm stands on."""
THICKNESS = 0.03
"""m, radius of the bars that stand for links."""
ENDLESS = 4.0 * math.pi
"""rad or m, range of a joint that states none."""
Named = Callable[[str], str]


def urdf_of(model: ArmModel, *, frame: Named = lambda name: name, joint: Named = lambda name: name) -> str:
    """Return an arm as URDF.

    Parameters
    ----------
    model
        The arm. Its links are `base`, `link1`, ... in the order of its joints, and `tool`.
    frame, joint
        What frames and joints are called.

    Returns
    -------
    str
        Kinematics, limits, masses where they are stated, and bars in the place of shapes.
    """
    count = len(model.joints)
    out = ['<?xml version="1.0"?>', f"<robot name={quoteattr(model.name)}>"]
    out.append(
        _link(frame(BASE), None, [np.array(j.before) for i, j in enumerate(model.joints) if model.parent(i) < 0])
    )
    for i, one in enumerate(model.joints):
        ends = [np.array(j.before) for k, j in enumerate(model.joints) if model.parent(k) == i]
        if model.tool_joint == i:
            ends.append(np.array(model.tool))
        body = None if model.bodies is None else model.bodies[i]
        carrier = frame(f"link{model.parent(i) + 1}") if model.parent(i) >= 0 else frame(BASE)
        mover = frame(f"link{i + 1}_axis")
        out.append(f"<link name={quoteattr(mover)}/>")
        out.append(_link(frame(f"link{i + 1}"), body, ends))
        out.append(_joint(one, joint, model, carrier, mover))
        out.append(_fixed(frame(f"link{i + 1}_end"), mover, frame(f"link{i + 1}"), np.array(one.after)))
    out.append(f"<link name={quoteattr(frame('tool'))}/>")
    last = frame(f"link{model.tool_joint + 1}") if 0 <= model.tool_joint < count else frame(BASE)
    out.append(_fixed(frame("tool_end"), last, frame("tool"), np.array(model.tool)))
    return "\n".join([*out, "</robot>", ""])


def _joint(one: Joint, name: Named, model: ArmModel, carrier: str, mover: str) -> str:
    limits = one.limits
    endless = one.turns and not math.isfinite(limits.lower) and not math.isfinite(limits.upper)
    kind = "continuous" if endless else "revolute" if one.turns else "prismatic"
    low, high = (v if math.isfinite(v) else math.copysign(ENDLESS, v) for v in (limits.lower, limits.upper))
    effort, speed = (v if math.isfinite(v) else 0.0 for v in (limits.torque, limits.speed))
    inside = f'<limit lower="{low!r}" upper="{high!r}" effort="{effort!r}" velocity="{speed!r}"/>'
    if one.mimic is not None:
        leader = quoteattr(name(model.joints[one.mimic.joint].name))
        inside += f'<mimic joint={leader} multiplier="{one.mimic.multiplier!r}" offset="{one.mimic.offset!r}"/>'
    return (
        f'<joint name={quoteattr(name(one.name))} type="{kind}"><parent link={quoteattr(carrier)}/>'
        f'<child link={quoteattr(mover)}/>{_origin(np.array(one.before))}<axis xyz="0 0 1"/>{inside}</joint>'
    )


def _fixed(name: str, parent: str, child: str, T: Array) -> str:
    return (
        f'<joint name={quoteattr(name)} type="fixed"><parent link={quoteattr(parent)}/>'
        f"<child link={quoteattr(child)}/>{_origin(T)}</joint>"
    )


def _link(name: str, body: Body | None, ends: list[Array]) -> str:
    inside = "" if body is None or body.mass == 0.0 else _inertial(body)
    return f"<link name={quoteattr(name)}>{inside}{''.join(_bar(T[:3, 3]) for T in ends)}</link>"


def _inertial(body: Body) -> str:
    xx, yy, zz, xy, yz, xz = map(float, body.inertia)
    T = np.eye(4)
    T[:3, 3] = body.com
    return (
        f'<inertial>{_origin(T)}<mass value="{float(body.mass)!r}"/><inertia ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" '
        f'ixy="{xy!r}" iyz="{yz!r}" ixz="{xz!r}"/></inertial>'
    )


def _bar(end: Array) -> str:
    """A bar from the origin to a place; a ball where that is the origin."""
    length = float(np.linalg.norm(end))
    ball = f'<visual><geometry><sphere radius="{1.3 * THICKNESS!r}"/></geometry></visual>'
    if length < THICKNESS:
        return ball
    T = np.eye(4)
    T[:3, :3] = Rotation.align_vectors(end[None] / length, np.array([[0.0, 0.0, 1.0]]))[0].as_matrix()
    T[:3, 3] = end / 2
    bar = f'<cylinder radius="{THICKNESS!r}" length="{length!r}"/>'
    return f"{ball}<visual>{_origin(T)}<geometry>{bar}</geometry></visual>"


def _origin(T: Array) -> str:
    """As URDF writes a pose: roll, pitch, yaw about fixed axes."""
    if np.array_equal(T, np.eye(4)):
        return ""
    xyz = " ".join(repr(float(v)) for v in T[:3, 3])
    turn = Rotation.from_matrix(T[:3, :3])
    with np.errstate(all="ignore"):
        rpy = " ".join(repr(float(v)) for v in _euler(turn))
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>'


def _euler(turn: Rotation) -> Array:
    """Angles about fixed x, y, z; where two of them are one turn, yaw is zero."""
    R = turn.as_matrix()
    pitch = math.atan2(-R[2, 0], math.hypot(R[0, 0], R[1, 0]))
    if math.hypot(R[0, 0], R[1, 0]) < 1e-9:
        roll = math.atan2(R[0, 1], R[1, 1]) if R[2, 0] < 0.0 else math.atan2(-R[0, 1], R[1, 1])
        return np.array([roll, pitch, 0.0])
    return np.array([math.atan2(R[2, 1], R[2, 2]), pitch, math.atan2(R[1, 0], R[0, 0])])
