"""Planar 2R arm in a vertical plane.

Model card
----------
::

     z                       2-- a2 --tool      q = (0, 0): both links level along x
     |          a1 ...--'''                     x = a1 cos q1 + a2 cos(q1 + q2)
     1--- x ...--'''                            z = a1 sin q1 + a2 sin(q1 + q2)

The two-link planar arm of B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo, Robotics, section 7.3.2, with the numbers
of its exercises: link lengths 1 m, centres of mass half-way, link masses 50 kg, link inertias 10 kg m2, rotor masses
5 kg, rotor inertias 0.01 kg m2, gear ratios 100. Motor 2 sits on link 1 at joint 2; as a locked rotor it is part of
that link here. With rotors="full" the book's B and g follow; "reflected" (the default) leaves out what couples the
rotor to the other joint, k_r I_m2 = 1 kg m2. Moments across the plane's normal never act and are those of a rod.
No limits are published; the plane stands upright by the base transform (z_0 points along -y of the world).
"""

from __future__ import annotations

import dataclasses
import math

from holonom.model.arm import ArmModel, Body, Motor, Transform
from holonom.model.dh import DHRow, arm_model_from_dh

__all__ = ["model"]

LINK_MASS, LINK_INERTIA, ROTOR_MASS, ROTOR_INERTIA, GEAR = 50.0, 10.0, 5.0, 0.01, 100.0
UPRIGHT: Transform = ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
POSES = {"zero": (0.0, 0.0), "ready": (math.pi / 4, math.pi / 2)}


def _first_link() -> Body:
    """Link 1 with the locked rotor of motor 2 at the origin of its frame (a disc)."""
    mass = LINK_MASS + ROTOR_MASS
    steiner = LINK_MASS * ROTOR_MASS / mass * 0.5**2
    across = LINK_INERTIA + 0.5 * ROTOR_INERTIA + steiner
    normal = LINK_INERTIA + ROTOR_INERTIA + steiner
    return Body(mass, (-0.5 * LINK_MASS / mass, 0.0, 0.0), (0.5 * ROTOR_INERTIA, across, normal, 0.0, 0.0, 0.0))


def model() -> ArmModel:
    """Return the planar 2R arm (see the module's model card)."""
    second = Body(LINK_MASS, (-0.5, 0.0, 0.0), (0.0, LINK_INERTIA, LINK_INERTIA, 0.0, 0.0, 0.0))
    arm = arm_model_from_dh(
        [DHRow(a=1.0), DHRow(a=1.0)], convention="standard", name="planar2r", bodies=[_first_link(), second]
    )
    motor = Motor(gear_ratio=GEAR, rotor_inertia=ROTOR_INERTIA, axis=(0.0, 0.0, 1.0))
    joints = tuple(dataclasses.replace(joint, motor=motor) for joint in arm.joints)
    return dataclasses.replace(arm, joints=joints, base=UPRIGHT, poses=POSES, card=__doc__ or "")
