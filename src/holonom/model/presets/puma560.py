"""Unimation Puma 560, standard DH.

Model card
----------
Kinematics, masses, centres of mass, inertias, rotor inertias, gear ratios, friction, position limits: P. I. Corke and
B. Armstrong-Helouvry, "A search for consensus among model parameters reported for the PUMA 560 robot", ICRA 1994, as
tabulated in the Robotics Toolbox (numbers only). d1 = 0.67183 m (26.45 in) puts frame 0 on the floor plate.
The link inertias already hold the locked rotors; only `gear_ratio^2 * rotor_inertia` is added to the diagonal.

Torque constants: Armstrong, Khatib and Burdick 1986. Armature resistance: Corke, in-situ measurements, 1996 (about
2.1 ohm for
joints 1-3, 6.7 ohm for 4-6). Joint torque and speed limits: Armstrong 1986, Corke 1996; current limits follow as
`torque / (|gear_ratio| * torque_constant)`. Supply 40 V.

Encoder counts per motor turn: from the counts per joint degree in a posting by S. Graves (comp.robotics, 1990)
divided by the gear ratios; one unofficial source.

ASSUMED, not confirmed by a publication we could read: armature inductance (a few mH are published; 3.4 mH and 6.0
mH give electrical time constants of 1.6 ms and 0.9 ms) and acceleration limits (about half of what peak torque gives
against the configuration's largest inertia: a controller setting, not hardware).

What follows: at rated speed 40 V leave enough for the full current on joints 1 to 3 (34, 39 and 40 V are needed),
but not on joints 4 to 6 (about 50 V would be): their peak torque is to be had up to about half of rated speed only.
"""

from __future__ import annotations

import math

from holonom.model.arm import ArmModel, Body, Friction, Joint, Motor
from holonom.model.dh import DHRow, joint_transforms
from holonom.model.limits import JointLimits

__all__ = ["model"]

NAMES = ("waist", "shoulder", "elbow", "wrist_roll", "wrist_bend", "flange")
D = (0.67183, 0.0, 0.15005, 0.4318, 0.0, 0.0)
A = (0.0, 0.4318, 0.0203, 0.0, 0.0, 0.0)
ALPHA = (0.5, 0.0, -0.5, 0.5, -0.5, 0.0)  # times pi
LIMITS_DEG = ((-160, 160), (-45, 225), (-225, 45), (-110, 170), (-100, 100), (-266, 266))
SPEED_DEG = (82.0, 54.0, 122.0, 228.0, 241.0, 228.0)
ACCELERATION = (6.0, 6.0, 10.0, 25.0, 25.0, 25.0)  # rad/s2, assumed
TORQUE = (97.6, 186.4, 89.4, 24.2, 20.1, 21.3)

MASS = (0.0, 17.4, 4.8, 0.82, 0.34, 0.09)
COM = (
    (0.0, 0.0, 0.0),
    (-0.3638, 0.006, 0.2275),
    (-0.0203, -0.0141, 0.07),
    (0.0, 0.019, 0.0),
    (0.0, 0.0, 0.0),
    (0.0, 0.0, 0.032),
)
INERTIA = (
    (0.0, 0.35, 0.0),
    (0.13, 0.524, 0.539),
    (0.066, 0.086, 0.0125),
    (0.0018, 0.0013, 0.0018),
    (0.0003, 0.0004, 0.0003),
    (0.00015, 0.00015, 0.00004),
)
ROTOR_INERTIA = (200e-6, 200e-6, 200e-6, 33e-6, 33e-6, 33e-6)
GEAR_RATIO = (-62.6111, 107.815, -53.7063, 76.0364, 71.923, 76.686)
MOTOR_VISCOUS = (1.48e-3, 0.817e-3, 1.38e-3, 71.2e-6, 82.6e-6, 36.7e-6)
MOTOR_COULOMB = (
    (0.395, -0.435),
    (0.126, -0.071),
    (0.132, -0.105),
    (11.2e-3, -16.9e-3),
    (9.26e-3, -14.5e-3),
    (3.96e-3, -10.5e-3),
)
TORQUE_CONSTANT = (0.189, 0.219, 0.202, 0.075, 0.066, 0.066)
RESISTANCE = (2.1, 2.1, 2.1, 6.7, 6.7, 6.7)
INDUCTANCE = (3.4e-3, 3.4e-3, 3.4e-3, 6.0e-3, 6.0e-3, 6.0e-3)  # assumed
SUPPLY_VOLTAGE = 40.0
ENCODER_COUNTS = (1000, 800, 1000, 1000, 1000, 1000)  # unofficial, see the card

POSES = {
    "zero": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    "ready": (0.0, math.pi / 2, -math.pi / 2, 0.0, 0.0, 0.0),
    "nominal": (0.0, math.pi / 4, -math.pi, 0.0, math.pi / 4, 0.0),
}


def _joint(k: int) -> Joint:
    before, after = joint_transforms(DHRow(a=A[k], alpha=ALPHA[k] * math.pi, d=D[k]), "standard")
    gear = abs(GEAR_RATIO[k])
    lower, upper = LIMITS_DEG[k]
    return Joint(
        name=NAMES[k],
        kind="revolute",
        before=before,
        after=after,
        limits=JointLimits(
            math.radians(lower), math.radians(upper), math.radians(SPEED_DEG[k]), ACCELERATION[k], TORQUE[k]
        ),
        motor=Motor(
            gear_ratio=GEAR_RATIO[k],
            rotor_inertia=ROTOR_INERTIA[k],
            torque_constant=TORQUE_CONSTANT[k],
            resistance=RESISTANCE[k],
            inductance=INDUCTANCE[k],
            max_voltage=SUPPLY_VOLTAGE,
            max_current=TORQUE[k] / (gear * TORQUE_CONSTANT[k]),
            encoder_counts=ENCODER_COUNTS[k],
        ),
        friction=Friction(gear**2 * MOTOR_VISCOUS[k], gear * MOTOR_COULOMB[k][0], -gear * MOTOR_COULOMB[k][1]),
    )


def model() -> ArmModel:
    """Return the Puma 560 (see the module's model card)."""
    bodies = tuple(Body(m, c, (*i, 0.0, 0.0, 0.0)) for m, c, i in zip(MASS, COM, INERTIA, strict=True))
    return ArmModel("puma560", tuple(_joint(k) for k in range(6)), bodies, poses=POSES, card=__doc__ or "")
