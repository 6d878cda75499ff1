"""One base of each arrangement, of 8 kg and about half a metre, that the tables are measured with."""

from __future__ import annotations

import functools
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
_MADE: tuple[tuple[Callable[..., WheelBase], dict[str, Any]], ...] = (
    (differential, {"track": 0.3, "wheel_radius": 0.05, "com": (-0.05, 0.0)}),
    (tricycle, {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05, "com": (0.15, 0.0)}),
    (bicycle, {"wheelbase": 0.8, "wheel_radius": 0.1, "com": (0.4, 0.0)}),
    (
        ackermann,
        {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05, "max_steering": math.radians(50.0), "com": (0.2, 0.0)},
    ),
    (dual_ackermann, {"wheelbase": 0.5, "track": 0.4, "wheel_radius": 0.05}),
    (skid_steer, {"wheelbase": 0.2, "track": 0.4, "wheel_radius": 0.05, "effective_track": 0.42}),
    (rocker6, {"wheelbase": 0.8, "track": 0.6, "wheel_radius": 0.06, "max_steering": math.radians(70.0)}),
    (segway, {"track": 0.4, "wheel_radius": 0.1, "com_height": 0.3}),
    (synchro, {"radius": 0.2, "wheel_radius": 0.05}),
    (omni, {"n": 3, "radius": 0.2, "wheel_radius": 0.05}),
    (mecanum, {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05}),
    (swerve, {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05}),
    (sphere, {"wheel_radius": 0.1}),
)

BASES: Mapping[str, Callable[[], WheelBase]] = MappingProxyType(
    {make.__name__: functools.partial(make, **{**_BODY, **given}) for make, given in _MADE}
)
"""Arrangement -> makes a base of it."""
