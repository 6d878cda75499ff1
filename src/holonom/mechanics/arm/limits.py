"""An arm's joints with other limits: what `Arm.with_limits` makes."""

from __future__ import annotations

import dataclasses
import math
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import real_array, shown
from holonom.errors import InputError, ShapeError, UnknownName
from holonom.model import ArmModel, Joint

__all__ = ["LimitValues", "changed_limits"]


class LimitValues(TypedDict, total=False):
    """Limits that may be set, (n,) or one for all joints: rad or m, per s, per s2, N m or N."""

    lower: ArrayLike
    upper: ArrayLike
    speeds: ArrayLike
    accelerations: ArrayLike
    torques: ArrayLike


FIELDS = {"lower": "lower", "upper": "upper", "speeds": "speed", "accelerations": "acceleration", "torques": "torque"}


def changed_limits(model: ArmModel, speed: float, acceleration: float, values: LimitValues) -> tuple[Joint, ...]:
    """Arguments and errors as for `Arm.with_limits`."""
    joints, moving = list(model.joints), model.independent
    for name, value in values.items():
        if name not in FIELDS:
            raise UnknownName("limit", name, FIELDS)
        given = real_array(name, value)
        if given.shape not in ((), (len(moving),)) or np.isnan(given).any():
            raise ShapeError(f"{name} must be one number or {len(moving)}, one for each joint; {value!r} came")
        if FIELDS[name] not in ("lower", "upper") and not (given > 0.0).all():
            raise InputError(f"{name} must be positive; {value!r} came")
        for i, one in zip(moving, np.broadcast_to(given, len(moving)).tolist(), strict=True):
            limits = dataclasses.replace(joints[i].limits, **{FIELDS[name]: one})
            joints[i] = dataclasses.replace(joints[i], limits=limits)
    for i in moving:
        if not joints[i].limits.lower <= joints[i].limits.upper:
            bounds = joints[i].limits
            raise InputError(f"joint {joints[i].name!r} would have limits {bounds.lower:g} .. {bounds.upper:g}")
    for what, factor in (("speed", speed), ("acceleration", acceleration)):
        number = real_array(what, factor)
        if number.shape != () or not (math.isfinite(number) and number > 0.0):
            raise InputError(
                f"{what} is {shown(factor)}; one positive factor of all joints' limits is needed; "
                f"{what}s= takes the limits of each"
            )
        factor = float(number)
        open_ = [joints[i].name for i in moving if math.isinf(getattr(joints[i].limits, what))]
        if factor != 1.0 and open_:
            raise InputError(
                f"{what} = {factor:g} is to scale limits that are not stated: those of {', '.join(open_)}; "
                f"give {what}s= in their units"
            )
    return tuple(joint.scaled(float(speed), float(acceleration)) for joint in joints)
