"""Memory layout of an arm's servos: one record of parameters and one of state per axis, by name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holonom.control.servo.kernels import AccelerationParams, CurrentParams, LimitParams, PositionParams, SpeedParams
from holonom.devices.encoders.kernels import EncoderParams, TrackingParams
from holonom.trace.call.records import layout_of

__all__ = ["SERVO", "SERVO_STATE", "Servo", "ServoTiming"]


class Servo(NamedTuple):
    """What the controller knows of one axis; motor quantities at the motor shaft, limits and law at the joint."""

    encoder: EncoderParams
    tracking: TrackingParams
    current: CurrentParams
    speed: SpeedParams
    position: PositionParams
    law: AccelerationParams
    limits: LimitParams
    ratio: float
    torque_constant: float
    inertia: float


class ServoTiming(NamedTuple):
    """Sample times in steps of the current loop: speed loops, position loops, model law and its computing delay."""

    speed: int
    position: int
    model: int
    delay: int


SERVO = layout_of(Servo)
"""`Servo` as a NumPy record: nested records are what the compiled steps take as their params."""

SERVO_STATE = np.dtype(
    [
        ("count", np.int64),  # encoder, extended
        ("angle", np.float64),  # observer: motor rad, rad/s, rad/s2
        ("rate", np.float64),
        ("load", np.float64),
        ("speed_integral", np.float64),  # A
        ("current_integral", np.float64),  # V
        ("law_integral", np.float64),  # rad/s2
        ("speed_reference", np.float64),  # motor rad/s
        ("current_reference", np.float64),  # A
        ("coming_reference", np.float64),  # A, of the model law, once it is computed
        ("saturated", np.int64),
    ]
)
"""What the controller remembers of one axis."""
