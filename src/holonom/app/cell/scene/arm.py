"""What the replay shows of an arm: its shapes in the frames of its links, whatever its model."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np

from holonom.app.cell.model.robot import GripperTool, Robot
from holonom.app.recording.scope import Scope
from holonom.app.report import Box, Disc, Label, Shape, Tube, arm_shapes, gripper_shapes
from holonom.app.report.drawing.arms import drawn_arms
from holonom.arrays import Array
from holonom.model import STROKE, ArmModel, reach
from holonom.spatial import inverse

__all__ = ["shapes_of_arm"]

BODY, JOINT, METAL = "#eef1f5", "#33415c", "#aab4c3"
THICK = 0.045
"""Radius of the first link over the arm's reach; the last one's is half of it."""


def shapes_of_arm(robot: Robot, foot: str, T_foot: Array) -> list[Shape]:
    """Shapes of an arm with its tool; its base is drawn in the frame `foot`, in which it stands at T_foot (4, 4)."""
    model: ArmModel = robot.source.model
    scope = Scope(robot.name, ())
    if robot.source.preset in drawn_arms():
        body: Iterable[Shape] = arm_shapes(robot.source.preset)
    else:
        body = _links(model, tool=robot.tool is None)
    return [_placed(shape, scope, foot, T_foot) for shape in (*body, *_tool(robot))]


def _placed(shape: Shape, scope: Scope, foot: str, T: Array) -> Shape:
    """A shape in its robot's frame; what is fixed to the ground goes where the arm stands."""
    if shape.frame != "world":
        return dataclasses.replace(shape, frame=scope.frame(shape.frame))
    if isinstance(shape, Tube):
        start, end = (_point(T[:3, :3] @ np.array(p) + T[:3, 3]) for p in (shape.start, shape.end))
        return dataclasses.replace(shape, frame=foot, start=start, end=end)
    if isinstance(shape, Box | Label):
        return dataclasses.replace(shape, frame=foot, pose=T @ shape.pose)
    assert isinstance(shape, Disc)
    return shape


def _tool(robot: Robot) -> tuple[Shape, ...]:
    tool = robot.tool
    if tool is None:
        return ()
    if isinstance(tool, GripperTool):
        width, thickness, length = tool.finger
        return gripper_shapes(length=tool.length, finger=(width, thickness, length))
    radius = 0.05 * tool.length
    return (Tube("tool", (0, 0, -tool.length), (0, 0, 0), radius, METAL, end_radius=0.6 * radius),)


def _links(model: ArmModel, *, tool: bool) -> list[Shape]:
    """Tubes between the joints of any arm, and a short one about each joint's axis."""
    base, length = np.array(model.base), max(reach(model), 0.05)
    shapes: list[Shape] = []
    carried = _carried(model)
    for child in carried[-1]:
        shapes += _ground(base, np.array(model.joints[child].before), _radius(length, 0.0))
    for i, joint in enumerate(model.joints):
        frame, r = f"link{i + 1}", _radius(length, i / len(model.joints))
        start = inverse(np.array(joint.after))
        axis = start[:3, 2]
        own = start[:3, 3]
        ends = [np.array(model.joints[child].before)[:3, 3] for child in carried[i]]
        if tool and i == model.tool_joint:
            ends.append(np.array(model.tool)[:3, 3])
        elif i == model.tool_joint and not carried[i]:
            ends.append(np.zeros(3))
        shapes += [_bar(frame, own, end, 0.8 * r) for end in ends if np.linalg.norm(end - own) > r]
        half = 0.9 * r
        shapes.append(Tube(frame, _point(own - half * axis), _point(own + half * axis), 1.1 * r, JOINT))
        if not joint.turns:
            shapes.append(_rail(model, i, 0.5 * r))
    return shapes


def _carried(model: ArmModel) -> dict[int, list[int]]:
    """Joints by the joint that carries them, -1 for the base."""
    found: dict[int, list[int]] = {i: [] for i in range(-1, len(model.joints))}
    for i in range(len(model.joints)):
        found[model.parent(i)].append(i)
    return found


def _radius(length: float, along: float) -> float:
    return THICK * length * (1.0 - 0.5 * along)


def _ground(base: Array, before: Array, r: float) -> list[Shape]:
    """From where the arm stands to its first joint; a foot where that is the same place."""
    first = (base @ before)[:3, 3]
    foot: list[Shape] = [Tube("world", (0.0, 0.0, -0.3 * r), (0.0, 0.0, 0.3 * r), 1.6 * r, JOINT)]
    return [*foot, _bar("world", np.zeros(3), first, r)] if np.linalg.norm(first) > r else foot


def _rail(model: ArmModel, i: int, r: float) -> Shape:
    """The way of a sliding joint, in the frame that carries it."""
    joint, parent = model.joints[i], model.parent(i)
    T = np.array(joint.before)
    low, high = np.clip((joint.limits.lower, joint.limits.upper), -STROKE, STROKE)
    start, end = (T[:3, 3] + q * T[:3, 2] for q in (min(low, 0.0), max(high, 0.0)))
    if parent >= 0:
        return _bar(f"link{parent + 1}", start, end, r, METAL)
    base = np.array(model.base)
    start, end = (base[:3, :3] @ p + base[:3, 3] for p in (start, end))
    return _bar("world", start, end, r, METAL)


def _bar(frame: str, start: Array, end: Array, radius: float, colour: str = BODY) -> Tube:
    return Tube(frame, _point(start), _point(end), radius, colour, rounded=True)


def _point(p: Sequence[float] | Array) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in p)
    return x, y, z
