"""Gear ratios and rotor inertias from a URDF's transmissions."""

from __future__ import annotations

from collections.abc import Mapping

from holonom.errors import UnknownName
from holonom.model.arm import Motor
from holonom.model.urdf.elements import Element, fault
from holonom.model.urdf.parts import UrdfJoint

__all__ = ["read_motors"]


def read_motors(robot: Element, joints: Mapping[str, UrdfJoint]) -> dict[str, Motor]:
    """The motor of each joint that a transmission with one joint and a stated reduction drives.

    The reduction stands in <mechanicalReduction> (of the actuator, or of the transmission in old files) or in
    <drake:gear_ratio value=>, the rotor inertia in <drake:rotor_inertia value=>; what is not stated is 1 and 0.
    """
    motors: dict[str, Motor] = {}
    for transmission in robot.all("transmission"):
        driven = transmission.all("joint")
        for joint in driven:
            if (name := joint.word("name")) not in joints:
                unknown = UnknownName("joint", name, joints)
                raise fault(joint, f"{transmission.called()} drives an unknown joint: {unknown}")
        motor = _motor(transmission)
        if motor is not None and len(driven) == 1:
            motors[driven[0].word("name")] = motor
    return motors


def _motor(transmission: Element) -> Motor | None:
    holders = [transmission, *transmission.all("actuator")]
    ratio, inertia = _stated(holders, "gear_ratio"), _stated(holders, "rotor_inertia")
    if ratio is None and inertia is None:
        return None
    return Motor(gear_ratio=1.0 if ratio is None else ratio, rotor_inertia=0.0 if inertia is None else inertia)


def _stated(holders: list[Element], what: str) -> float | None:
    for holder in holders:
        for element in holder.children:
            if element.tag == f"drake:{what}":
                return _checked(element, element.number("value"), what)
            if element.tag == "mechanicalReduction" and what == "gear_ratio":
                plain = Element(element.tag, element.source, element.line, {"value": element.text})
                return _checked(element, plain.number("value"), what)
    return None


def _checked(element: Element, value: float, what: str) -> float:
    if (what == "gear_ratio" and value == 0) or (what == "rotor_inertia" and value < 0):
        raise fault(element, f"<{element.tag}> is {value}; a gear ratio is not 0, a rotor inertia not negative")
    return value
