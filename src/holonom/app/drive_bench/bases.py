"""One base of each arrangement, of 8 kg and about half a metre, that the tables are measured with."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from holonom.mobile import (
    WheelBase,
    ackermann,
    bicycle,
    differential,
    dual_ackermann,
    mecanum,
    omni,
    rocker6,
    segway,
    skid_steer,
    sphere,
    swerve,
    synchro,
    tricycle,
)

__all__ = ["BASES"]

_BODY: dict[str, Any] = {"mass": 8.0, "com_height": 0.05}

BASES: Mapping[str, Callable[[], WheelBase]] = MappingProxyType({
    "differential": lambda: differential(0.3, 0.05, com=(-0.05, 0.0), **_BODY),
    "tricycle": lambda: tricycle(0.4, 0.3, 0.05, com=(0.15, 0.0), **_BODY),
    "bicycle": lambda: bicycle(0.8, 0.1, com=(0.4, 0.0), **_BODY),
    "ackermann": lambda: ackermann(0.4, 0.3, 0.05, max_steering=math.radians(50.0), com=(0.2, 0.0), **_BODY),
    "dual_ackermann": lambda: dual_ackermann(0.5, 0.4, 0.05, **_BODY),
    "skid_steer": lambda: skid_steer(0.2, 0.4, 0.05, effective_track=0.42, **_BODY),
    "rocker6": lambda: rocker6(0.8, 0.6, 0.06, max_steering=math.radians(70.0), **_BODY),
    "segway": lambda: segway(0.4, 0.1, **_BODY),
    "synchro": lambda: synchro(radius=0.2, wheel_radius=0.05, **_BODY),
    "omni": lambda: omni(n=3, radius=0.2, wheel_radius=0.05, **_BODY),
    "mecanum": lambda: mecanum(0.4, 0.3, 0.05, **_BODY),
    "swerve": lambda: swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05, **_BODY),
    "sphere": lambda: sphere(0.1, **_BODY),
})  # fmt: skip
"""Arrangement -> a base of it."""
