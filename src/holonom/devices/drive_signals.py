"""What passes between a controller and its drives, simulated or real: arrays that both read and write in turn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["JointSignals", "WheelSignals"]

Floats = NDArray[np.float64]
Counters = NDArray[np.int64]


class JointSignals(NamedTuple):
    """Drives of an arm, n axes; written every step of the current loop."""

    counters: Counters  # measured: (n,) 16-bit counters at the motors
    currents: Floats  # measured: (n,) A
    voltages: Floats  # commanded: (n,) V


class WheelSignals(NamedTuple):
    """Drives and inertial sensors of a base, its wheels filled up to k whole fours; written every millisecond."""

    counters: Counters  # measured: (4 k,) 16-bit counters at the motors
    currents: Floats  # measured: (4 k,) A
    inertial: Floats  # measured: (3,) turning rate, rad/s; acceleration along x and y of base_link, m/s2
    voltages: Floats  # commanded: (4 k,) V
    speeds: Floats  # commanded: (4 k,) of the wheels, rad/s, for drives that close their own speed loops
