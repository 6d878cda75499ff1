"""`BaseTruth`: what is true of a simulated base over time, whoever drives it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = ["BaseTruth", "columns", "of_wheels", "truth_of"]


@dataclass(frozen=True, slots=True)
class BaseTruth:
    """N samples, a millisecond apart, of a base with m driven wheels; twists in base_link, poses in the world.

    Attributes
    ----------
    time
        (N,) s.
    pose, twist
        (N, 3).
    acceleration
        (N, 2) of the centre of mass, along the axes of base_link, m/s^2.
    wheel_angles, wheel_speeds
        (N, m) rad, rad/s.
    currents, voltages
        (N, m) A, V.
    forces, cross_forces, loads, friction_limits
        (N, m) N: on the base along the drive direction and across it; wheel load; `mu N` at the peak.
    slip
        (N, m) rim faster than the floor, m/s.
    energy
        (N, 5) J since the start: supplied, armature heat, air-gap work, lost in motors and gears, lost on the floor.
    pitch
        (N,) of a body that balances, forwards, rad.
    """

    time: Array
    pose: Array
    twist: Array
    acceleration: Array
    wheel_angles: Array
    wheel_speeds: Array
    currents: Array
    voltages: Array
    forces: Array
    cross_forces: Array
    loads: Array
    friction_limits: Array
    slip: Array
    energy: Array
    pitch: Array


def truth_of(time: Array, body: NDArray[np.void], wheels: NDArray[np.void], count: int) -> BaseTruth:
    """Arrays from the records `BODY_SAMPLE` (N,) and `WHEEL_SAMPLE` (N, k) of the compiled loops."""
    return BaseTruth(
        time=time,
        pose=columns(body, "x", "y", "theta"),
        twist=columns(body, "vx", "vy", "w"),
        acceleration=columns(body, "ax", "ay"),
        wheel_angles=of_wheels(wheels, "angle", count),
        wheel_speeds=of_wheels(wheels, "speed", count),
        currents=of_wheels(wheels, "current", count),
        voltages=of_wheels(wheels, "voltage", count),
        forces=of_wheels(wheels, "force", count),
        cross_forces=of_wheels(wheels, "cross_force", count),
        loads=of_wheels(wheels, "load", count),
        friction_limits=of_wheels(wheels, "friction_limit", count),
        slip=of_wheels(wheels, "slip", count),
        energy=columns(body, "supplied", "heat", "airgap", "drag", "ground"),
        pitch=body["pitch"],
    )


def columns(rows: NDArray[np.void], first: str, *others: str) -> Array:
    """Neighbouring fields of records (N,), all float64, as an array (N, k) on the same memory."""
    start = list(rows.dtype.names or ()).index(first)
    found: Array = rows.view(np.float64).reshape(len(rows), -1)[:, start : start + 1 + len(others)]
    return found


def of_wheels(rows: NDArray[np.void], name: str, count: int) -> Array:
    """A field of records (N, k) of four wheels each as an array (N, count) on the same memory."""
    found: Array = rows[name].reshape(len(rows), -1)[:, :count]
    return found
