"""What a base can do along each axis alone: speed and acceleration that its motors, its grip and tipping allow."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.mobile.base.drivable import skids
from holonom.mobile.base.dynamics import inertia_over_mass
from holonom.mobile.base.wheel import KINDS
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive, base_mass, rest_loads, roller_cosines, stands_in_line
from holonom.mobile.stability import acceleration_limit

__all__ = ["Ability", "abilities"]

ALONE = 1e-6  # m/s of another motion that comes with one: then it is none alone
DIRECTIONS = {"forwards": (0.0, math.pi), "sideways": (0.5 * math.pi, -0.5 * math.pi)}


class Ability(NamedTuple):
    """Along one axis: greatest speed and acceleration, m/s and m/s2, or rad/s and rad/s2; infinite where unknown."""

    speed: float
    acceleration: float


def abilities(base: WheelBase, drive: BaseDrive, friction: float) -> dict[str, Ability]:
    """What motors and floor allow "forwards", "sideways" and in "turning", from rest, one at a time.

    Parameters
    ----------
    friction : coefficient between wheels and floor.

    Raises
    ------
    ModelError
        A base without mass, or one that tips at rest.

    Notes
    -----
    With e an axis of the twist and M the mass matrix about base_link, rim forces f of least square sum give
    `S^T D^T f = S^T M e`, S the motions that wheels which do not slide leave free. A motor also turns its own wheel:
    per wheel `a |f| <= min(mu N cos(gamma), F)` and `a |f + J d e / r^2| <= F`, F its torque's force at rest. Loads are
    those at rest; forwards and sideways a body does not tip. The speed is that of the fastest rim without load. An
    axis that no motion lies along alone, as turning of a car, is left open; so is turning of wheels that skid, and how
    a body that balances leans.
    """
    found = {}
    for k, name in enumerate(("forwards", "sideways", "turning")):
        axis = np.eye(3)[k]
        moves = np.abs(base.feasible(axis) - axis).max() < ALONE
        if not moves or (name == "turning" and skids(base.wheels)):
            found[name] = Ability(math.inf, math.inf)
            continue
        found[name] = _along(base, drive, friction, axis, DIRECTIONS.get(name, ()))
    return found


def _along(base: WheelBase, drive: BaseDrive, friction: float, axis: Array, directions: tuple[float, ...]) -> Ability:
    steering = base.steering(axis) if base.steered else None
    rows = base.rolling_matrix(steering)[base._driven_rows]
    held = base.sliding_matrix(steering)
    free = np.eye(3)
    if len(held):
        _, size, Vt = np.linalg.svd(held)
        free = Vt[int((size > ALONE).sum()) :].T
    scale = np.array([1.0, 1.0, base.radius])
    inertia = base_mass(base) * inertia_over_mass(base.radius, base.alpha, base.com) * np.outer(scale, scale)
    f = np.abs(np.linalg.pinv((rows @ free).T, rcond=1e-9) @ (free.T @ inertia @ axis))
    rims = np.abs(rows @ axis)
    motor, gear, radii = drive.motor, drive.gear, base.wheel_radii
    torque = motor.torque_constant * min(motor.max_current, motor.max_voltage / motor.resistance)
    push = abs(gear.ratio) * gear.efficiency * torque / radii
    driven = [wheel for wheel in base.wheels if wheel.driven]
    each = [i for i, wheel in enumerate(driven) for _ in KINDS[wheel.kind].speeds(wheel)]
    grip = friction * (rest_loads(base) * roller_cosines(base))[each]
    with np.errstate(divide="ignore"):
        most = min(float((push / (f + drive.inertia * rims / radii**2)).min()), float((grip / f).min()))
        speed = float((motor.no_load_speed / abs(gear.ratio) * radii / rims).min())
    if directions and not (base.balances or stands_in_line(base)):
        most = min(most, float(acceleration_limit(base, list(directions)).min()))
    return Ability(speed, most)
