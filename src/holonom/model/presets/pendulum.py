"""Driven pendulum with a geared motor (specification 02.3).

Model card
----------
::

     1 --> y into the page      (I + I_m k_r^2) thdd + F thd + m g l sin(th) = tau
     |
     |  l to the mass centre    th = 0: hanging down; th > 0 swings towards +x
     v

The equation is the specification's; I is the moment about the pivot. The numbers are made up: a 1.2 m rod of 2 kg
(l = 0.6 m, so I = m (2 l)^2 / 3 for a thin one), a motor of 2e-5 kg m2 behind a gear of 50. The tool is the rod's end.
"""

from __future__ import annotations

import dataclasses

from holonom.model.arm import ArmModel, Friction, Motor, Transform
from holonom.model.dh import DHRow, arm_model_from_dh
from holonom.model.limits import JointLimits
from holonom.model.presets.shapes import cylinder

__all__ = ["model"]

LENGTH = 1.2
HANGING: Transform = ((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (-1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def model() -> ArmModel:
    """Return the driven pendulum (see the module's model card)."""
    arm = arm_model_from_dh(
        [DHRow(a=LENGTH)],
        convention="standard",
        name="pendulum",
        limits=[JointLimits(speed=10.0, acceleration=50.0, torque=30.0)],
        bodies=[cylinder(2.0, LENGTH, 0.01, "x", -LENGTH)],
    )
    motor = Motor(gear_ratio=50.0, rotor_inertia=2e-5, axis=(0.0, 0.0, 1.0))
    joint = dataclasses.replace(arm.joints[0], name="pivot", motor=motor, friction=Friction(0.05, 0.0, 0.0))
    poses = {"zero": (0.0,), "upright": (3.141592653589793,)}
    return dataclasses.replace(arm, joints=(joint,), base=HANGING, poses=poses, card=__doc__ or "")
