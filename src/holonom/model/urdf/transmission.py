"""Gear ratios and rotor inertias from a URDF's transmissions."""

from __future__ import annotations

from collections.abc import Mapping

from holonom.errors import ModelError, UnknownName
from holonom.model.arm import Motor
from holonom.model.urdf.check import Check
from holonom.model.urdf.elements import Element
from holonom.model.urdf.parts import UrdfJoint

__all__ = ["read_motors"]


STATED = {
    "gear_ratio": ("mechanicalReduction", "mechanical_reduction", "drake:gear_ratio"),
    "rotor_inertia": ("motorInertia", "drake:rotor_inertia"),
}
"""Tags that state a motor: a number as text, or as value=."""


def read_motors(robot: Element, joints: Mapping[str, UrdfJoint], check: Check) -> dict[str, Motor]:
    """The motor of each joint that a transmission with one joint drives, or that states one itself.

    The reduction stands in <mechanicalReduction> or <drake:gear_ratio value=>, the rotor inertia (kg m2, at the motor)
    in <motorInertia> or <drake:rotor_inertia value=>: of the actuator, of the transmission (old files), of the
    transmission's joint or of the joint itself, the first of these; what is not stated is 1 and 0.
    """
    motors: dict[str, Motor] = {}
    for transmission in robot.all("transmission"):
        driven = _driven(transmission, joints, check)
        stated = [*transmission.all("actuator"), transmission, *transmission.all("joint")]
        if len(driven) == 1:
            (name,) = driven
            stated.append(joints[name].element)
        motor = _motor(stated, check)
        if motor is not None and len(driven) == 1:
            motors[name] = motor
        elif motor is not None and driven:
            check.note(transmission, f"{transmission.called()} drives {len(driven)} joints; its reduction is not read")
    for name, joint in joints.items():
        if name not in motors and (motor := _motor([joint.element], check)) is not None:
            motors[name] = motor
    return motors


def _driven(transmission: Element, joints: Mapping[str, UrdfJoint], check: Check) -> list[str]:
    found = []
    for joint in transmission.all("joint"):
        name = joint.attributes.get("name", "")
        if name in joints:
            found.append(name)
            continue
        unknown = UnknownName("joint", name, joints)
        check.doubt(joint, f"{transmission.called()} drives an unknown joint: {unknown}", "it is passed over")
    return found


def _motor(holders: list[Element], check: Check) -> Motor | None:
    ratio, inertia = _stated(holders, "gear_ratio", check), _stated(holders, "rotor_inertia", check)
    if ratio is None and inertia is None:
        return None
    return Motor(gear_ratio=1.0 if ratio is None else ratio, rotor_inertia=0.0 if inertia is None else inertia)


def _stated(holders: list[Element], what: str, check: Check) -> float | None:
    """The first number that is stated; others that differ from it are noted."""
    taken: Element | None = None
    value: float | None = None
    for element in [child for holder in holders for child in holder.children if child.tag in STATED[what]]:
        found = _number(element, what, check)
        if value is None:
            taken, value = element, found
        elif found not in (None, value) and taken is not None:
            check.note(
                element, f"<{element.tag}> is {found:g}; <{taken.tag}> of line {taken.line}, {value:g}, is taken"
            )
    return value


def _number(element: Element, what: str, check: Check) -> float | None:
    text = element.attributes.get("value", element.text)
    try:
        value = Element(element.tag, element.source, element.line, {"value": text}).number("value")
    except ModelError as error:
        if check.strict:
            raise
        check.remark(f"{error}: it is passed over")
        return None
    if (what == "gear_ratio" and value == 0) or (what == "rotor_inertia" and value < 0):
        problem = f"<{element.tag}> is {value}"
        rule = "a gear ratio is not 0, a rotor inertia not negative"
        check.doubt(element, problem, "it is passed over", instead=rule)
        return None
    return value
