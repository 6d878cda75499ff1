"""What passes between a controller and its drives, simulated or real: arrays that both read and write in turn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = ["JointSignals", "WheelSignals"]

Counters = NDArray[np.int64]


class JointSignals(NamedTuple):
    """Drives of an arm, n axes; written every step of the current loop."""

    counters: Counters  # measured: (n,) 16-bit counters at the motors
    currents: Array  # measured: (n,) A
    voltages: Array  # commanded: (n,) V


class WheelSignals(NamedTuple):
    """Drives and inertial sensors of a base, its wheels filled up to k whole fours; written every millisecond."""

    counters: Counters  # measured: (4 k,) 16-bit counters at the motors
    currents: Array  # measured: (4 k,) A
    inertial: Array  # measured: (3,) turning rate, rad/s; acceleration along x and y of base_link, m/s2; of a body that
    # balances (5,) along its own axes, then rate of pitch, rad/s, and acceleration along its z, m/s2
    voltages: Array  # commanded: (4 k,) V
    speeds: Array  # commanded: (4 k,) of the wheels, rad/s, for drives that close their own speed loops
    turned: Array  # measured: (4 k,) steering angles against rest, rad
    steering: Array  # commanded: (4 k,) steering angles, rad
