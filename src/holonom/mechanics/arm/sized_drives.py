"""Drives for an arm that states none: a motor, a gear and an encoder per joint, sized from the joint's limits.

A design rule, not a catalogue: each motor reaches its joint's speed limit with a margin at no load, and at its current
limit more than the joint's torque limit. Chosen are a supply, a motor speed and an encoder; everything else follows.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import vectors
from holonom.errors import MissingInertia, ModelError
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.equations.dynamics.composite_body import mass_matrix
from holonom.mechanics.kernels.placement import bodies_of
from holonom.model import Joint, Motor

__all__ = ["SUPPLY", "sized_drives", "sized_motor"]

SUPPLY = 48.0
"""V."""
SPEED_MARGIN = 1.3
"""Speed of the free motor over the joint's speed limit."""
TORQUE_MARGIN = 1.5
"""Torque at the current limit over the joint's torque limit."""
MOTOR_SPEED = 400.0
"""rad/s of the free motor: about 3,800 rpm."""
DROP = 0.12
"""Part of the supply that the armature takes at the current limit; the speed margin leaves 0.23 of it at full speed."""
ELECTRICAL_TIME = 1e-3
"""L/R, s."""
ROTOR_PART = 0.5
"""Reflected rotor inertia over the joint's own."""
LEAST_RUN_UP = 0.01
"""s that torque takes at least to bring the reflected rotor to the speed limit: a light link still has a real motor."""
COUNTS = 4 * 4096
"""Encoder counts per motor turn."""


def sized_drives(arm: Arm, q: ArrayLike) -> Arm:
    """Return the arm with a motor, a gear ratio and an encoder for each joint, sized from its limits.

    Parameters
    ----------
    arm : with masses and inertias; every joint states a speed and a torque (force) limit.
    q : (n,) rad or m, where the joints' inertia is taken from.

    Raises
    ------
    ModelError
        A joint without a speed or torque limit, which is named; joints that follow others.
    MissingInertia
        No masses and inertias.
    """
    model = arm.model
    if model.bodies is None:
        why = f" ({model.no_inertia})" if model.no_inertia else ""
        raise MissingInertia(
            f"arm {model.name!r} states no inertia{why}, so its drives cannot be sized; "
            'state it or use drives = "ideal"'
        )
    if len(model.independent) < len(model.joints):
        raise ModelError(f"arm {model.name!r} has joints that follow others; their drives cannot be sized")
    for joint in model.joints:
        _check_limits(joint)
    bare = tuple(dataclasses.replace(joint, motor=None) for joint in model.joints)
    # Once, so as floats: to compile it would take a thousand times as long.
    B = mass_matrix(dataclasses.replace(model, joints=bare), bodies_of(model), vectors("q", q, arm.n).tolist())
    own = np.diagonal(np.array(B, dtype=float))
    joints = tuple(
        dataclasses.replace(joint, motor=sized_motor(joint.limits.speed, joint.limits.torque, float(inertia)))
        for joint, inertia in zip(bare, own, strict=True)
    )
    return arm.remade(joints=joints, rotors="reflected")


def sized_motor(speed: float, torque: float, inertia: float, supply: float = SUPPLY) -> Motor:
    """Return the motor, with its gear ratio and encoder, of an axis.

    Parameters
    ----------
    speed, torque : greatest of the axis, rad/s and N m (m/s and N).
    inertia : of the axis without the rotor, kg m2 (kg).
    supply : V.
    """
    ratio = MOTOR_SPEED / (SPEED_MARGIN * speed)
    constant = supply / MOTOR_SPEED
    current = TORQUE_MARGIN * torque / (ratio * constant)
    resistance = DROP * supply / current
    rotor = max(ROTOR_PART * inertia, LEAST_RUN_UP * torque / speed)
    return Motor(
        gear_ratio=ratio,
        rotor_inertia=rotor / ratio**2,
        torque_constant=constant,
        resistance=resistance,
        inductance=ELECTRICAL_TIME * resistance,
        max_voltage=supply,
        max_current=current,
        encoder_counts=COUNTS,
    )


def _check_limits(joint: Joint) -> None:
    what = ("torque", "rad/s and N m") if joint.turns else ("force", "m/s and N")
    for name, value in (("speed", joint.limits.speed), (what[0], joint.limits.torque)):
        if not (value > 0.0 and math.isfinite(value)):
            raise ModelError(
                f"joint {joint.name!r} has no {name} limit (in {what[1]}), so its drive cannot be sized; "
                'state it or use drives = "ideal"'
            )
