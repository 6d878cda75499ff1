"""Which joints of a robot file are wheels, and of which kind: by their names, how they turn, what drives them."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.errors import InputError, ModelError, UnknownName
from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.urdf.places import Parts, round_shape
from holonom.model.urdf.elements import fault
from holonom.model.urdf.parts import UrdfJoint

__all__ = [
    "Found",
    "candidates",
    "driven_joints",
    "nothing_found",
    "recognised",
    "skidding",
    "stated_wheels",
]

_WHEEL, _CASTOR = ("wheel", "tyre", "tire"), ("caster", "castor", "ballbearing", "ball_bearing", "omni_ball")
_FREE = (*_CASTOR, "passive", "idler", "free")
_LEVEL, _UPRIGHT = math.sin(math.radians(10.0)), math.cos(math.radians(10.0))
"""An axle may be cambered, a pivot raked, by so much."""
_TRAIL = 0.1  # of a wheel's radius: a pivot farther from the axle drags its wheel behind it
_WORDS = {"continuous", "revolute"}
_STATED = ("kind", "radius", "roller_angle", "driven", "max_steering", "castor_offset", "acts_at", "name")


@dataclass(frozen=True, slots=True)
class Found:
    """A wheel, the joint that it turns on and, where it is steered, the pivot; height of its middle in the frame, m."""

    wheel: Wheel
    joint: UrdfJoint
    pivot: UrdfJoint | None
    height: float

    def told(self) -> str:
        """One line on it."""
        w = self.wheel
        steered = f", turned by {self.pivot.name!r}" if self.pivot else ""
        return (
            f"{self.joint.name!r}: {'driven' if w.driven else 'free'} {w.kind} wheel, radius {w.radius:.4g} m, at "
            f"({w.x:.4g}, {w.y:.4g}) m{steered}"
        )


def candidates(parts: Parts) -> list[str]:
    """Names of the joints that look like wheels, in the order of the file.

    Of those that turn about a level axle: the ones that a motor turns without end, and those whose joint or link is
    called wheel, tyre or castor; where neither tells of more than castors, all that turn without end and are round.
    Fixed parts called castor are balls.
    """
    driven = driven_joints(parts)
    wheels, castors, rolling = set(), set(), set()
    for joint in parts.joints.values():
        words = f"{joint.name} {joint.child}".lower()
        castor = any(word in words for word in _CASTOR)
        if any(parts.joints[name].moves for name in _below(parts, joint.child)):
            continue
        if _turns(joint) and _level(parts, joint):
            if castor:
                castors.add(joint.name)
            elif any(word in words for word in _WHEEL) or (_endless(joint) and joint.name in driven):
                wheels.add(joint.name)
            elif _endless(joint) and round_shape(parts, parts.carried(joint.child, fixed=True)) is not None:
                rolling.add(joint.name)
        elif not joint.moves and castor and not _holds_wheel(parts, joint):
            castors.add(joint.name)
    found = castors | (wheels or rolling)
    return [name for name in parts.joints if name in found]


def _below(parts: Parts, link: str) -> list[str]:
    under = set(parts.carried(link, fixed=False))
    return [joint.name for joint in parts.joints.values() if joint.parent in under]


def _holds_wheel(parts: Parts, joint: UrdfJoint) -> bool:
    """Whether a fixed part hangs below another castor's part, or holds another: one ball is one wheel."""
    return any(
        not one.moves and one is not joint and any(word in f"{one.name} {one.child}".lower() for word in _CASTOR)
        for one in parts.carriers(joint)
    )


def _turns(joint: UrdfJoint) -> bool:
    return joint.element.word("type") in _WORDS


def _level(parts: Parts, joint: UrdfJoint) -> bool:
    return abs(float(parts.axis(joint)[2])) < _LEVEL


def driven_joints(parts: Parts) -> set[str]:
    """Names of the joints that a transmission, a velocity interface of ros2_control or a drive plugin names."""
    found = {
        joint.attributes.get("name", "")
        for transmission in parts.robot.all("transmission")
        for joint in transmission.all("joint")
    }
    for control in parts.robot.all("ros2_control"):
        for joint in control.all("joint"):
            if any(one.attributes.get("name") in ("velocity", "effort") for one in joint.all("command_interface")):
                found.add(joint.attributes.get("name", ""))
    for gazebo in parts.robot.all("gazebo"):
        for plugin in gazebo.all("plugin"):
            for element in plugin.children:
                if re.search("joint", element.tag, re.IGNORECASE) and "steer" not in element.tag.lower():
                    found.add(element.text.strip())
    return found & set(parts.joints)


def recognised(
    parts: Parts, name: str, stated: Mapping[str, Any], driven: Collection[str], floor: float | None,
    wheel_radius: float | None,
) -> Found:  # fmt: skip
    """The wheel on a joint.

    Parameters
    ----------
    stated : fields of `Wheel.at` that are stated for it.
    driven : names of the joints with motors.
    floor : height of the floor in the base's frame, m, where it is known: a ball's radius without a shape.
    wheel_radius : m, where a link says none.

    Raises
    ------
    UnknownName
        No such joint, kind, or field.
    ModelError
        An axle that is not level; a wheel without a radius.
    """
    if name not in parts.joints:
        raise UnknownName("joint of a wheel", name, parts.joints)
    for field in stated:
        if field not in _STATED:
            raise UnknownName(f"key of the wheel on joint {name!r}", field, _STATED)
    kind = stated.get("kind")
    if kind is not None and kind not in KINDS:
        raise UnknownName("kind of wheel", str(kind), KINDS)
    joint = parts.joints[name]
    shape = round_shape(parts, parts.carried(joint.child, fixed=True))
    ball = not joint.moves or kind in ("spherical", "ball")
    if not ball and not _level(parts, joint):
        x, y, z = parts.axis(joint)
        raise fault(
            joint.element,
            f"joint {name!r} has its axle along ({x:.3g}, {y:.3g}, {z:.3g}) of {parts.frame!r}; a wheel's is level, "
            "see <axis> and the origin's rpy, or leave the joint out of wheels=",
        )
    place = parts.place(joint)
    if ball and shape is not None:
        place = shape.middle
    radius = stated.get("radius", shape.radius if shape else wheel_radius)
    if radius is None and ball and floor is not None and place[2] > floor:
        radius = float(place[2] - floor)
    if radius is None:
        raise fault(
            joint.element,
            f"joint {name!r}: link {joint.child!r} has no cylinder or sphere, and a mesh tells no radius; state "
            "wheel_radius=, or the wheel's own radius in wheels=",
        )
    word = str(stated.get("name", name))
    if ball:
        wheel = Wheel.at(
            kind or "spherical", float(place[0]), float(place[1]), radius=radius, name=word,
            driven=bool(stated.get("driven", False)),
        )  # fmt: skip
        return Found(wheel, joint, None, float(place[2]))
    return _rolling(parts, joint, place, dict(stated), word, radius, driven)


def _rolling(
    parts: Parts, joint: UrdfJoint, place: Array, stated: dict[str, Any], word: str, radius: float,
    driven: Collection[str],
) -> Found:  # fmt: skip
    axle = parts.axis(joint)
    heading = math.atan2(-axle[0], axle[1])  # it rolls along u, its axle points to the left of u
    kind, pivot, spot = str(stated.get("kind", "")), _pivot(parts, joint), place
    motor = bool(stated.get("driven", joint.name in driven))
    offset = 0.0
    if pivot is not None and kind in ("", "castor", "steered"):
        at = parts.place(pivot)
        along = np.array([math.cos(heading), math.sin(heading)])
        trail = float((place - at)[:2] @ along)
        free = any(w in f"{pivot.name} {pivot.child}".lower() for w in _FREE) and pivot.name not in driven
        if not kind:
            trails = abs(trail) > _TRAIL * radius and (free or _endless(pivot))
            kind = "castor" if trails and (not motor or pivot.name in driven) else "steered"
        if kind == "castor":
            offset, spot = float(stated.get("castor_offset", abs(trail))), at
            heading += math.pi if trail * offset < 0.0 else 0.0
    if pivot is None or kind not in ("castor", "steered"):
        pivot = None
    limit = stated.get("max_steering", None if pivot is None or kind != "steered" else _limit(pivot))
    acts = stated.get("acts_at")
    wheel = Wheel.at(
        kind or "fixed", float(spot[0]), float(spot[1]), heading, radius=radius, driven=motor, name=word,
        roller_angle=float(stated.get("roller_angle", 0.0)), castor_offset=offset,
        max_steering=limit if (kind or "fixed") == "steered" else None,
        acts_at=None if acts is None else (float(acts[0]), float(acts[1])),
    )  # fmt: skip
    return Found(wheel, joint, pivot, float(place[2]))


def _pivot(parts: Parts, joint: UrdfJoint) -> UrdfJoint | None:
    """The joint with an upright axis that carries a wheel, if there is one."""
    for carrier in parts.carriers(joint):
        if _turns(carrier) and abs(float(parts.axis(carrier)[2])) > _UPRIGHT:
            return carrier
    return None


def _endless(joint: UrdfJoint) -> bool:
    return joint.element.word("type") == "continuous"


def _limit(pivot: UrdfJoint) -> float | None:
    """Smaller of a pivot's two limits, rad, at most a quarter turn; None where it turns all around."""
    low, high = pivot.limits.lower, pivot.limits.upper
    if not (math.isfinite(low) and math.isfinite(high)):
        return None
    if not low < 0.0 < high:
        raise fault(
            pivot.element,
            f"joint {pivot.name!r} steers from {low:.4g} to {high:.4g} rad; limits on both sides of zero, where the "
            "wheel heads along its rest, are needed",
        )
    return min(-low, high, 0.5 * math.pi)


def skidding(found: list[Found]) -> list[Found]:
    """Fixed wheels on several axles skid as they turn: the same wheels, of kind "skid"."""
    fixed = [one.wheel for one in found if one.wheel.kind == "fixed"]
    if not fixed:
        return found
    along = np.array([math.cos(fixed[0].heading), math.sin(fixed[0].heading)])
    at = np.array([[w.x, w.y] for w in fixed])
    parallel = all(abs(math.sin(w.heading - fixed[0].heading)) < 1e-6 for w in fixed)
    if not parallel or float(np.ptp(at @ along)) < 1e-3:
        return found
    centre, across = at.mean(axis=0), np.array([-along[1], along[0]])
    made = []
    for one in found:
        w = one.wheel
        if w.kind == "fixed":
            side = float((np.array([w.x, w.y]) - centre) @ across)
            acts = centre + 1.5 * side * across
            w = Wheel.at(
                "skid", w.x, w.y, w.heading, radius=w.radius, driven=w.driven, name=w.name,
                acts_at=(float(acts[0]), float(acts[1])),
            )  # fmt: skip
        made.append(replace(one, wheel=w))
    return made


def nothing_found(parts: Parts) -> ModelError:
    """What to say of a file without wheels."""
    turning = [joint.name for joint in parts.joints.values() if _turns(joint)]
    return ModelError(
        f"{parts.robot.source}: no joint looks like a wheel: none that turns about a level axle is called wheel, tyre "
        f"or castor, or has a round link; name them in wheels=, of {', '.join(turning) or 'no joint that turns'}"
    )


def stated_wheels(wheels: object) -> dict[str, dict[str, Any]]:
    """What the caller says of wheels: name of a joint -> fields of `Wheel.at`.

    Raises
    ------
    InputError
    """
    if isinstance(wheels, str):
        return {wheels: {}}
    if isinstance(wheels, Mapping):
        return {str(n): {"kind": v} if isinstance(v, str) else dict(v or {}) for n, v in wheels.items()}
    try:
        return {str(name): {} for name in wheels}  # type: ignore[attr-defined]
    except TypeError:
        raise InputError(
            f"wheels is {wheels!r}; it is names of joints, or name -> kind, or name -> fields of Wheel.at"
        ) from None
