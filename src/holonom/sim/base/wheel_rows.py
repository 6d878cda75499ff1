"""What the plant takes of each wheel: a row of `WHEEL` for every kind, and where its lanes are.

A kind is a line of `SIMULATED`: what it adds to a plain tyre. Lanes are the order of `lanes_of`, nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from holonom.arrays import Array
from holonom.devices import Friction, SteeringMotor
from holonom.errors import ModelError
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive, standing_wheels

__all__ = ["SIMULATED", "Lane", "lanes_of", "wheel_row"]

PIVOT_DRAG = 1e-3  # N m s/rad of a castor's bearing per kg of its wheel
BEARS = ("spherical",)
"""Kinds of passive wheels that bear load and feel no friction."""


class Lane(NamedTuple):
    """A wheel, or one of the axes about which a ball is driven; where it stands among the supports."""

    wheel: Wheel
    heading: float  # rad in which it rolls, at rest
    support: int


def _plain(wheel: Wheel, drive: BaseDrive, spin: float) -> dict[str, Any]:
    return {}


def _swedish(wheel: Wheel, drive: BaseDrive, spin: float) -> dict[str, Any]:
    gamma = wheel.roller_angle
    return {
        "turn": gamma, "along": math.cos(gamma), "across": -math.sin(gamma), "rollers": 1.0, "drag": drive.roller_drag
    }  # fmt: skip


def _ball(wheel: Wheel, drive: BaseDrive, spin: float) -> dict[str, Any]:
    """Each drive of a ball lets it roll across without drag: the other one turns it there."""
    return {"rollers": 1.0}


def _steered(wheel: Wheel, drive: BaseDrive, spin: float) -> dict[str, Any]:
    limit = math.inf if wheel.max_steering is None else wheel.max_steering
    return {"turns": 1.0, "servo": 1.0, "steering": drive.steering.params(limit)}


def _castor(wheel: Wheel, drive: BaseDrive, spin: float) -> dict[str, Any]:
    """Its wheel is a disc, whose mass turns with it about the pivot: freely, or by its steering motor if driven."""
    mass = 2.0 * spin / wheel.radius**2
    disc = 0.5 * spin + mass * wheel.castor_offset**2
    if wheel.driven:
        motor = replace(drive.steering, inertia=drive.steering.inertia + disc)
        return {"turns": 1.0, "servo": 1.0, "lever": wheel.castor_offset, "steering": motor.params()}
    pivot = SteeringMotor(inertia=disc)
    return {
        "turns": 1.0, "lever": wheel.castor_offset, "pivot_drag": PIVOT_DRAG * mass, "steering": pivot.params()
    }  # fmt: skip


SIMULATED: Mapping[str, Callable[[Wheel, BaseDrive, float], dict[str, Any]]] = {
    "fixed": _plain,
    "skid": _plain,
    "swedish": _swedish,
    "steered": _steered,
    "castor": _castor,
    "ball": _ball,
}
"""Kinds of wheels that touch the floor with friction."""


def lanes_of(base: WheelBase) -> list[Lane]:
    """Return the wheels that feel the floor, those of `base.driven` first, in its order.

    Raises
    ------
    ModelError
        A kind of wheel that is not simulated.
    """
    found: list[Lane] = []
    for k, wheel in enumerate(standing_wheels(base)):
        if wheel.kind in BEARS and not wheel.driven:
            continue
        if wheel.kind not in SIMULATED:
            raise ModelError(f"wheel {wheel.name!r} is {wheel.kind}; simulated are {', '.join(SIMULATED)}")
        found.append(Lane(wheel, wheel.heading, k))
        if wheel.kind == "ball":
            found.append(Lane(wheel, wheel.heading + 0.5 * math.pi, k))
    return found


def wheel_row(
    lane: Lane, at: Array, share: Array, drive: BaseDrive, dt: float, reach: float, radii: Array
) -> tuple[object, ...]:  # fmt: skip
    """Return a wheel as a row of `WHEEL`: at a place about the centre of mass, with a share of the weight.

    `radii` (m) are those of the wheels whose inertia the drive states: a free one has it by the fourth power.
    """
    usual, largest = float(radii.mean()), float(radii.max())
    wheel, (x, y) = lane.wheel, at.tolist()
    spin = drive.wheel_inertia * (wheel.radius / usual) ** 4
    own = SIMULATED[wheel.kind](wheel, drive, spin)
    motor, gear = drive.motor, drive.gear
    driven = wheel.driven
    ratio, efficiency = (gear.ratio, gear.efficiency) if driven else (1.0, 1.0)
    armature = motor.armature(dt)
    friction = drive.friction if driven else Friction()
    heading = lane.heading + own.get("turn", 0.0)
    return (
        x, y, math.cos(heading), math.sin(heading),
        wheel.radius * own.get("along", 1.0), wheel.radius * own.get("across", 0.0),
        reach, wheel.radius, largest, ratio * efficiency, ratio / efficiency,
        armature.conductance * (1.0 - armature.decay) * armature.back_emf,
        own.get("rollers", 0.0), own.get("drag", 0.0), *share,
        drive.inertia if driven else spin,
        drive.wheel_inertia + ratio * motor.rotor_inertia if driven else spin, motor.torque_constant if driven else 0.0,
        own.get("turns", 0.0), own.get("servo", 0.0), own.get("lever", 0.0), own.get("pivot_drag", 0.0),
        tuple(own.get("steering", drive.steering.params())),
        tuple(armature), tuple(friction.stiction(motor.rotor_inertia, dt)),
        tuple(gear.params()) if driven else (1.0, *tuple(gear.params())[1:]),
        tuple(drive.encoder.params()),
    )  # fmt: skip
