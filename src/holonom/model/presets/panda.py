"""Franka Emika Panda, seven joints, to its flange (no hand).

Model card
----------
::

      z_0 up, all joints zero (outside the limits of joint 4):

        4--0.0825          1, 3, 5, 7 roll along the arm; 2, 4, 6 bend it. The elbow is 0.0825 m off the
        |      5           line of the arm, the wrist's last axis 0.088 m in front of the sixth.
        3      |
        2    6-+--0.088    0.333 to joint 2, 0.316 to joint 4, 0.384 to joint 6; the flange is 0.107 below joint 7.
        1      7

Kinematics, limits of position, speed, acceleration and torque: Franka Emika, "Robot and interface specifications"
(Craig's modified DH). The tool is the flange; add a hand with `with_tool` and `with_load`.

Dynamics: C. Gaz, M. Cognetti, A. Oliva, P. Robuffo Giordano, A. De Luca, "Dynamic identification of the Franka Emika
Panda robot with retrieval of feasible parameters using penalty-based optimization", IEEE RA-L 4(4), 2019, as listed
in the maker's description files (numbers only). APPROXIMATE: identification finds base parameters; the values of a
single link are one feasible choice that gives the same torques (rotor inertias are inside: link 1 spins with 0.7
kg m2 across its axis for that reason). Friction of the paper is not included.
"""

from __future__ import annotations

import dataclasses
import math

from holonom.model.arm import ArmModel, Body, Transform
from holonom.model.dh import DHRow, arm_model_from_dh
from holonom.model.limits import JointLimits

__all__ = ["model"]

HALF = math.pi / 2
ROWS = (
    DHRow(d=0.333),
    DHRow(alpha=-HALF),
    DHRow(alpha=HALF, d=0.316),
    DHRow(alpha=HALF, a=0.0825),
    DHRow(alpha=-HALF, a=-0.0825, d=0.384),
    DHRow(alpha=HALF),
    DHRow(alpha=HALF, a=0.088),
)
FLANGE: Transform = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.107), (0.0, 0.0, 0.0, 1.0))
LIMITS = (
    JointLimits(-2.8973, 2.8973, 2.1750, 15.0, 87.0),
    JointLimits(-1.7628, 1.7628, 2.1750, 7.5, 87.0),
    JointLimits(-2.8973, 2.8973, 2.1750, 10.0, 87.0),
    JointLimits(-3.0718, -0.0698, 2.1750, 12.5, 87.0),
    JointLimits(-2.8973, 2.8973, 2.6100, 15.0, 12.0),
    JointLimits(-0.0175, 3.7525, 2.6100, 20.0, 12.0),
    JointLimits(-2.8973, 2.8973, 2.6100, 20.0, 12.0),
)
BODIES = (
    Body(4.970684, (0.003875, 0.002081, -0.04762), (0.70337, 0.70661, 0.009117, -0.000139, 0.019169, 0.006772)),
    Body(0.646926, (-0.003141, -0.02872, 0.003495), (0.007962, 0.02811, 0.025995, -0.003925, 0.000704, 0.010254)),
    Body(3.228604, (0.027518, 0.039252, -0.066502), (0.037242, 0.036155, 0.01083, -0.004761, -0.012805, -0.011396)),
    Body(3.587895, (-0.05317, 0.104419, 0.027454), (0.025853, 0.019552, 0.028323, 0.007796, 0.008641, -0.001332)),
    Body(1.225946, (-0.011953, 0.041065, -0.038437), (0.035549, 0.029474, 0.008627, -0.002117, 0.000229, -0.004037)),
    Body(1.666555, (0.060149, -0.014117, -0.010517), (0.001964, 0.004354, 0.005433, 0.000109, 0.000341, -0.001158)),
    Body(0.735522, (0.010517, -0.004252, 0.061597), (0.012516, 0.010027, 0.004815, -0.000428, -0.000741, -0.001196)),
)
POSES = {"ready": (0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, HALF, math.pi / 4)}


def model() -> ArmModel:
    """Return the Panda (see the module's model card)."""
    arm = arm_model_from_dh(ROWS, convention="modified", name="panda", limits=LIMITS, bodies=BODIES)
    return dataclasses.replace(arm, tool=FLANGE, poses=POSES, card=__doc__ or "")
