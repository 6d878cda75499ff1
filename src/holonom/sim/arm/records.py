"""Memory layout of an arm's drives as they truly are: one record of parameters and one of state per axis, by name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holonom.devices.encoders.kernels import EncoderParams
from holonom.devices.motors.kernels import ArmatureParams
from holonom.devices.transmission.kernels import GearParams, StictionParams
from holonom.trace.call.records import layout_of

__all__ = ["DRIVE", "DRIVE_STATE", "Drive"]


class Drive(NamedTuple):
    """Motor, friction, gear and encoder of one axis; at the motor shaft."""

    armature: ArmatureParams
    friction: StictionParams
    gear: GearParams
    encoder: EncoderParams
    torque_constant: float


DRIVE = layout_of(Drive)
"""`Drive` as a NumPy record: nested records are what the compiled steps take as their params."""

DRIVE_STATE = np.dtype(
    [
        ("position", np.float64),  # joint, rad
        ("speed", np.float64),  # joint, rad/s
        ("current", np.float64),  # A
        ("held", np.float64),  # by Coulomb friction and the gear's, N m at the motor
        ("voltage", np.float64),  # V
        ("torque", np.float64),  # behind the gear, N m
        ("peak_speed", np.float64),  # largest magnitudes since the start, joint side
        ("peak_voltage", np.float64),
        ("peak_current", np.float64),
        ("peak_torque", np.float64),
        ("peak_error", np.float64),  # of the position against the reference
        ("square_error", np.float64),  # sum over the 1 kHz ticks
    ]
)
"""State of one axis, and what its worst was."""
