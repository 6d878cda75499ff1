"""Topics of a recording as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = [
    "BaseTrack",
    "ContactTrack",
    "CountTrack",
    "DriveTrack",
    "FrameTrack",
    "InertialTrack",
    "JointTrack",
    "Track",
]


@dataclass(frozen=True, slots=True)
class JointTrack:
    """Joints over time: `time` (N,) in s; `position`, `velocity`, `effort` (N, n) in rad, rad/s, N m.

    A track of references has no effort: (N, 0).
    """

    time: Array
    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class DriveTrack:
    """Motors over time: `time` (N,) in s, `current` (N, n) in A, `voltage` (N, n) in V."""

    time: Array
    current: Array
    voltage: Array


@dataclass(frozen=True, slots=True)
class FrameTrack:
    """A frame in world over time: `time` (N,) in s, `position` (N, 3) in m, `quaternion` (N, 4) x y z w."""

    time: Array
    position: Array
    quaternion: Array

    def poses(self) -> Array:
        """T_wx as matrices (N, 4, 4)."""
        x, y, z, w = self.quaternion.T
        out = np.zeros((len(self.time), 4, 4))
        out[:, 0, 0], out[:, 1, 1], out[:, 2, 2] = (
            1 - 2 * (y * y + z * z),
            1 - 2 * (x * x + z * z),
            1 - 2 * (x * x + y * y),
        )
        out[:, 0, 1], out[:, 1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
        out[:, 0, 2], out[:, 2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
        out[:, 1, 2], out[:, 2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
        out[:, :3, 3] = self.position
        out[:, 3, 3] = 1.0
        return out


@dataclass(frozen=True, slots=True)
class BaseTrack:
    """A base over time: `time` (N,) in s; `pose` (N, 3) x, y, theta in odom; `twist` (N, 3) in base_link.

    `covariance` (N, 3, 3) of the pose; zero for a reference.
    """

    time: Array
    pose: Array
    twist: Array
    covariance: Array


@dataclass(frozen=True, slots=True)
class ContactTrack:
    """Wheels on the ground over time: `time` (N,) in s; `force` (N), `slip` and `residual` (m/s), each (N, n)."""

    time: Array
    force: Array
    slip: Array
    residual: Array


@dataclass(frozen=True, slots=True)
class CountTrack:
    """Encoders over time: `time` (N,) in s, `count` (N, n) integers since the start."""

    time: Array
    count: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class InertialTrack:
    """Gyro and accelerometers over time: `time` (N,) in s, `rate` (N,) in rad/s, `acceleration` (N, 2) in m/s^2."""

    time: Array
    rate: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class Track:
    """Any topic over time: `time` (N,) in s, each of the record's `fields` (N, ...), and names of its joints."""

    time: Array
    fields: Mapping[str, NDArray[Any]]
    names: tuple[str, ...] = ()
