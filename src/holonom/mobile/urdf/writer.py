"""A base as a URDF: links and joints that any reader knows, and an own element for what a URDF cannot say."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from xml.sax.saxutils import quoteattr

from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.model.urdf.elements import Element, fault

__all__ = ["Own", "base_urdf", "own_words"]

TAG = "holonom"
_NUMBERS = ("radius", "roller_angle", "castor_offset", "max_steering")
_WIDTH = 0.4  # of a wheel's radius, drawn


@dataclass(frozen=True, slots=True)
class Own:
    """What the own element says: fields of wheels by joint, groups that steer together, arguments of the base."""

    wheels: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    groups: Mapping[str, list[str]] = field(default_factory=dict)
    base: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""


def base_urdf(base: WheelBase) -> str:
    """Return a base as the text of a URDF; `load_base` gives the same base back.

    Base_link lies on the floor, x forwards, y left. Every wheel is a link with a cylinder or a ball on a continuous
    joint, a steered wheel or a castor below an upright one; driven wheels have a transmission. All mass is base_link's.
    What a URDF cannot say (kinds, rollers, what steers together) stands in an element `<holonom>`, which other readers
    pass over.
    """
    lines = ['<?xml version="1.0"?>', f"<robot name={quoteattr(base.name)}>", '  <link name="base_link">']
    lines += [*_inertial(base), "  </link>"]
    for wheel in base.wheels:
        lines += _wheel(wheel)
    lines.append(f"  <{TAG}>")
    lines.append(
        f'    <base name={quoteattr(base.name)} radius="{_text(base.radius)}" suspension="{base.suspension}"'
        f' balances="{str(base.balances).lower()}"'
        + ("" if base.mass is not None else f' alpha="{_text(base.alpha)}" com="{_text(*base.com)}"'
           f' com_height="{_text(base.com_height)}"')
        + "/>"
    )  # fmt: skip
    lines += [f"    {_words(wheel)}" for wheel in base.wheels]
    for name, members in zip(base.steered, base.layout.groups, strict=True):
        if len(members) > 1:
            joints = " ".join(joint_name(base.wheels[i]) for i in members)
            lines.append(f"    <steered_together name={quoteattr(name)} wheels={quoteattr(joints)}/>")
    return "\n".join([*lines, f"  </{TAG}>", "</robot>", ""])


def joint_name(wheel: Wheel) -> str:
    """Name of a wheel's joint: its own, without spaces."""
    return wheel.name.replace(" ", "_")


def _text(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)


def _inertial(base: WheelBase) -> list[str]:
    if base.mass is None:
        return []
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = base.inertia.tolist()
    moments = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), (xx, xy, xz, yy, yz, zz), strict=True)
    return [
        "    <inertial>",
        f'      <origin xyz="{_text(*base.com, base.com_height)}"/>',
        f'      <mass value="{_text(base.mass)}"/>',
        "      <inertia " + " ".join(f'{name}="{_text(value)}"' for name, value in moments) + "/>",
        "    </inertial>",
    ]


def _wheel(wheel: Wheel) -> list[str]:
    name, r = joint_name(wheel), wheel.radius
    if wheel.kind in ("spherical", "ball"):
        return _joint(name, "fixed", "base_link", f"{name}_link", (wheel.x, wheel.y, r), 0.0) + _link(
            f"{name}_link", f'<sphere radius="{_text(r)}"/>', 0.0
        )
    lines: list[str] = []
    parent, place, heading = "base_link", (wheel.x, wheel.y, r), wheel.heading
    if wheel.kind in ("steered", "castor"):
        limit = wheel.max_steering
        bounds = (
            "" if limit is None else f'<limit lower="{_text(-limit)}" upper="{_text(limit)}" effort="0" velocity="0"/>'
        )
        lines += _joint(
            f"{name}_pivot", "continuous" if limit is None else "revolute", parent, f"{name}_fork", place, heading,
            axis="0 0 1", more=bounds,
        )  # fmt: skip
        lines.append(f'  <link name="{name}_fork"/>')
        parent, place, heading = f"{name}_fork", (wheel.castor_offset, 0.0, 0.0), 0.0
    lines += _joint(name, "continuous", parent, f"{name}_link", place, heading, axis="0 1 0")
    lines += _link(f"{name}_link", f'<cylinder radius="{_text(r)}" length="{_text(_WIDTH * r)}"/>', math.pi / 2)
    if wheel.driven:
        lines += [
            f'  <transmission name="{name}_motor">',
            "    <type>transmission_interface/SimpleTransmission</type>",
            f'    <joint name="{name}"><hardwareInterface>VelocityJointInterface</hardwareInterface></joint>',
            f'    <actuator name="{name}_motor"/>',
            "  </transmission>",
        ]
    return lines


def _joint(
    name: str, kind: str, parent: str, child: str, place: tuple[float, float, float], yaw: float, *, axis: str = "",
    more: str = "",
) -> list[str]:  # fmt: skip
    lines = [
        f'  <joint name="{name}" type="{kind}">',
        f'    <origin xyz="{_text(*place)}" rpy="{_text(0.0, 0.0, yaw)}"/>',
        f'    <parent link="{parent}"/>',
        f'    <child link="{child}"/>',
    ]
    lines += [f'    <axis xyz="{axis}"/>'] if axis else []
    return [*lines, *([f"    {more}"] if more else []), "  </joint>"]


def _link(name: str, shape: str, roll: float) -> list[str]:
    lines = [f'  <link name="{name}">']
    for what in ("visual", "collision"):
        lines.append(f'    <{what}><origin rpy="{_text(roll, 0.0, 0.0)}"/><geometry>{shape}</geometry></{what}>')
    return [*lines, "  </link>"]


def _words(wheel: Wheel) -> str:
    said = {"joint": joint_name(wheel), "name": wheel.name, "kind": wheel.kind, "driven": str(wheel.driven).lower()}
    for field_ in _NUMBERS:
        value = getattr(wheel, field_)
        if value:
            said[field_] = _text(value)
    if wheel.acts_at is not None:
        said["acts_at"] = _text(*wheel.acts_at)
    return "<wheel " + " ".join(f"{key}={quoteattr(value)}" for key, value in said.items()) + "/>"


def own_words(robot: Element) -> Own:
    """What a file's own element says; nothing where there is none.

    Raises
    ------
    ModelError
        A number that is none, with its line.
    """
    said = next(iter(robot.all(TAG)), None)
    if said is None:
        return Own()
    wheels: dict[str, dict[str, Any]] = {}
    for element in said.all("wheel"):
        stated: dict[str, Any] = {"name": element.word("name"), "kind": element.word("kind")}
        stated["driven"] = element.attributes.get("driven") == "true"
        stated |= {key: element.number(key) for key in _NUMBERS if key in element.attributes}
        if "acts_at" in element.attributes:
            stated["acts_at"] = _two(element, "acts_at")
        wheels[element.word("joint")] = stated
    groups = {
        element.word("name"): [
            str(wheels[joint]["name"]) for joint in element.word("wheels").split() if joint in wheels
        ]
        for element in said.all("steered_together")
    }
    base, name = _base(said)
    return Own(wheels, groups, base, name)


def _base(said: Element) -> tuple[dict[str, Any], str]:
    element = next(iter(said.all("base")), None)
    if element is None:
        return {}, ""
    made: dict[str, Any] = {k: element.number(k) for k in ("radius", "alpha", "com_height") if k in element.attributes}
    if "com" in element.attributes:
        made["com"] = _two(element, "com")
    if "suspension" in element.attributes:
        made["suspension"] = element.word("suspension")
    made["balances"] = element.attributes.get("balances") == "true"
    return made, element.word("name")


def _two(element: Element, attribute: str) -> tuple[float, float]:
    words = element.word(attribute).split()
    try:
        x, y = (float(word) for word in words)
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise fault(element, f'<{element.tag}> {attribute}="{" ".join(words)}": two finite numbers are needed')
    return x, y
