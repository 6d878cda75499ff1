"""Memory layout of the simulated axes: one record of parameters and one of state per axis, by name."""

from __future__ import annotations

from typing import NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from holonom.control.kernels import AccelerationParams, CurrentParams, LimitParams, PositionParams, SpeedParams
from holonom.devices.kernels import ArmatureParams, EncoderParams, FrictionParams, GearParams, TrackingParams

__all__ = ["AXIS", "STATE", "Axis", "axis_table"]


class Axis(NamedTuple):
    """Parameters of one axis; motor quantities at the motor shaft, limits and law at the joint."""

    armature: ArmatureParams
    friction: FrictionParams
    gear: GearParams
    encoder: EncoderParams
    tracking: TrackingParams
    current: CurrentParams
    speed: SpeedParams
    position: PositionParams
    law: AccelerationParams
    limits: LimitParams
    torque_constant: float
    inertia: float


def _layout(params: type) -> np.dtype[np.void]:
    return np.dtype(
        [(name, _layout(kind) if kind is not float else np.float64) for name, kind in get_type_hints(params).items()]
    )


AXIS = _layout(Axis)
"""`Axis` as a NumPy record: nested records are what the compiled steps take as their params."""

STATE = np.dtype(
    [
        ("position", np.float64),  # joint, rad
        ("speed", np.float64),  # joint, rad/s
        ("current", np.float64),  # A
        ("voltage", np.float64),  # V
        ("torque", np.float64),  # behind the gear, N m
        ("count", np.int64),  # encoder, extended
        ("angle", np.float64),  # observer: motor rad, rad/s, rad/s2
        ("rate", np.float64),
        ("load", np.float64),
        ("speed_integral", np.float64),  # A
        ("current_integral", np.float64),  # V
        ("law_integral", np.float64),  # rad/s2
        ("speed_reference", np.float64),  # motor rad/s
        ("current_reference", np.float64),  # A
        ("saturated", np.bool_),
        ("peak_speed", np.float64),  # largest magnitudes since the start, joint side
        ("peak_voltage", np.float64),
        ("peak_current", np.float64),
        ("peak_torque", np.float64),
        ("peak_error", np.float64),
        ("square_error", np.float64),  # sum over the 1 kHz ticks
    ]
)
"""State of one axis."""


def axis_table(axes: list[Axis]) -> NDArray[np.void]:
    """Return the axes as an array (n,) of `AXIS` records."""
    return np.array(
        [tuple(tuple(part) if isinstance(part, tuple) else part for part in axis) for axis in axes], dtype=AXIS
    )
