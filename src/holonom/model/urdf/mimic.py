"""Which joint of a URDF follows which."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from holonom.errors import UnknownName
from holonom.model.joint_kinds import kind_of
from holonom.model.urdf.check import Check
from holonom.model.urdf.parts import UrdfJoint, UrdfMimic

__all__ = ["Follows", "follow"]

ALONE = "it moves on its own"


@dataclass(frozen=True, slots=True)
class Follows:
    """q = multiplier * q_master + offset, of a master that moves on its own."""

    master: UrdfJoint
    multiplier: float
    offset: float


def follow(moving: Sequence[UrdfJoint], check: Check) -> dict[str, Follows]:
    """What the joints follow that do, by their names; of joints that follow each other, the one that moves on its own.

    Raises
    ------
    ModelError
        In a strict check, one that does not name a joint that moves on its own.
    """
    named = {joint.name: joint for joint in moving}
    masters = {joint.name: master for joint in moving if (master := _master(joint, named, check)) is not None}
    found = {name: _to_the_end(named[name], named, masters, check) for name in masters}
    return {name: way for name, way in found.items() if way is not None}


def _master(joint: UrdfJoint, named: Mapping[str, UrdfJoint], check: Check) -> UrdfMimic | None:
    """What a joint says that it follows, if that can be followed."""
    mimic = joint.mimic
    if mimic is None:
        return None
    if mimic.joint not in named:
        unknown = UnknownName("moving joint", mimic.joint, named)
        check.doubt(mimic.element, f"joint {joint.name!r} mimics an unknown joint: {unknown}", ALONE)
        return None
    if not kind_of(kind := named[mimic.joint].kind).single:
        check.doubt(mimic.element, f"joint {joint.name!r} mimics {mimic.joint!r}, which is {kind}", ALONE)
        return None
    return mimic


def _to_the_end(
    joint: UrdfJoint, named: Mapping[str, UrdfJoint], masters: Mapping[str, UrdfMimic], check: Check
) -> Follows | None:
    first = masters[joint.name]
    multiplier, offset, master, passed = first.multiplier, first.offset, first.joint, {joint.name}
    while master in masters:
        onwards = masters[master]
        problem = f"joint {joint.name!r} mimics {master!r}, which mimics {onwards.joint!r}"
        advice = "name the joint that moves on its own, with the factors multiplied"
        if master in passed:
            check.doubt(first.element, problem, f"they follow each other, so {ALONE}", instead=advice)
            return None
        check.doubt(first.element, problem, "it follows that one, with the factors multiplied", instead=advice)
        passed.add(master)
        # q = multiplier * q_master + offset, and q_master = onwards.multiplier * q_next + onwards.offset
        offset += multiplier * onwards.offset
        multiplier *= onwards.multiplier
        master = onwards.joint
    return Follows(named[master], multiplier, offset)
