"""How far, how fast and how hard a joint of a URDF may move."""

from __future__ import annotations

import math

from holonom.model.joint_kinds import JOINT_KINDS, kind_of
from holonom.model.limits import JointLimits
from holonom.model.urdf.check import Check
from holonom.model.urdf.elements import Element

__all__ = ["read_limits"]


def read_limits(element: Element, stated: str, check: Check) -> JointLimits:
    """Return position, speed and effort limits of a joint of the type `stated`; infinite where there is none.

    A continuous joint has no position limits and may state none at all.
    """
    limit, endless = check.one(element, "limit"), stated not in JOINT_KINDS
    if limit is None and endless:
        return JointLimits()
    lower, upper = (-math.inf, math.inf) if endless else _positions(element, limit, stated, check)
    if limit is None:
        return JointLimits(lower, upper)
    speed, effort = (_most(element, limit, name, check) for name in ("velocity", "effort"))
    if speed < 0 or effort < 0:
        problem = f"{element.called()} has velocity {speed} and effort {effort}"
        check.doubt(limit, problem, "what is negative is taken as no limit", instead="both must not be negative")
        speed, effort = (math.inf if value < 0 else value for value in (speed, effort))
    return JointLimits(lower, upper, speed=speed, torque=effort)


def _positions(element: Element, limit: Element | None, stated: str, check: Check) -> tuple[float, float]:
    if limit is None or not {"lower", "upper"} & limit.attributes.keys():
        turns = kind_of(stated).turns
        check.doubt(
            limit or element,
            f"{element.called()} is {stated} and states no position limits",
            "it has none",
            instead="add <limit lower= upper= effort= velocity=>" + (', or make it type="continuous"' if turns else ""),
        )
        return -math.inf, math.inf
    lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
    if lower > upper:
        problem = f"{element.called()} has the lower limit {lower} above the upper {upper}"
        check.doubt(limit, problem, "they are taken the other way round", instead="swap them")
        lower, upper = upper, lower
    return lower, upper


def _most(element: Element, limit: Element, name: str, check: Check) -> float:
    """The largest speed or effort."""
    if not limit.attributes.get(name, "").strip():
        problem = f'<limit> of {element.called()} needs {name}="..."; it is missing or empty'
        check.doubt(limit, problem, "it has no such limit")
        return math.inf
    return limit.number(name)
