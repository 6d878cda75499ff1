"""`BaseLog`: what happened to a simulated base, at 1 kHz, and the events in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.closed_loop.base_kernels import LogBuffer
from holonom.closed_loop.base_words import BaseWords
from holonom.mobile import WheelBase
from holonom.signals import Event
from holonom.sim.base.log import columns, truth_of

__all__ = ["BaseLog", "log_of"]


@dataclass(frozen=True, slots=True)
class BaseLog:
    """N samples of a base with m driven wheels; SI units, twists in base_link, poses in the world.

    Attributes
    ----------
    time
        (N,) s.
    wheels
        Names of the m wheels.
    pose, twist
        (N, 3) true.
    estimated_pose, estimated_twist
        (N, 3) as the controller believes.
    reference_pose, reference_twist
        (N, 3) as asked for at that time.
    rate
        (N,) part of the path's speed at which it is driven; below 1 once motors are lost that it would need.
    wheel_angles
        (N, m) rad, true.
    counts
        (N, m) of the encoders, extended to 64 bits.
    wheel_speeds, measured_speeds, reference_speeds
        (N, m) of the wheels, rad/s: true, by the encoders' observers, commanded.
    currents, measured_currents, voltages
        (N, m) A, A, V.
    forces, cross_forces, loads, friction_limits
        (N, m) N: on the base along the drive direction and across it; wheel load; `mu N` at the peak.
    slip
        (N, m) rim faster than the floor, m/s, true.
    residuals
        (N, m) `m - D D^+ m` of the measured rim speeds, m/s.
    status, named
        (N,) codes of `SlipStatus`; (N, m) wheels named as slipping.
    dead, jammed
        (N, m) motors that the controller drives without; those of them that it takes for jammed.
    gyro, acceleration
        (N,) rad/s and (N, 2) m/s^2 as the IMU measures them.
    energy
        (N, 5) J since the start: supplied, armature heat, air-gap work, lost in motors and gears, lost on the floor.
    events
        What a reader of the log wants to know first.
    ended
        How the run ended: "done" at the end of the path, "jammed" where a jammed wheel stopped the base, "tipped" where
        it fell over, "fell" where a body that balances did, "cut off" where it would have taken more than five times as
        long as the path.
    driven
        Part of the path's length that the reference had gone by then, 0 to 1.
    """

    time: Array
    wheels: tuple[str, ...]
    pose: Array
    twist: Array
    estimated_pose: Array
    estimated_twist: Array
    reference_pose: Array
    reference_twist: Array
    rate: Array
    wheel_angles: Array
    counts: NDArray[np.int64]
    wheel_speeds: Array
    measured_speeds: Array
    reference_speeds: Array
    currents: Array
    measured_currents: Array
    voltages: Array
    forces: Array
    cross_forces: Array
    loads: Array
    friction_limits: Array
    slip: Array
    residuals: Array
    status: NDArray[np.int64]
    named: NDArray[np.bool_]
    dead: NDArray[np.bool_]
    jammed: NDArray[np.bool_]
    gyro: Array
    acceleration: Array
    energy: Array
    events: tuple[Event, ...] = ()
    ended: str = "done"
    driven: float = 1.0

    @property
    def path_error(self) -> Array:
        """(N,) m, distance of the true place from where the reference is at that time."""
        error: Array = np.hypot(*(self.pose - self.reference_pose)[:, :2].T)
        return error

    @property
    def heading_error(self) -> Array:
        """(N,) rad, true heading less the reference's, in [-pi, pi)."""
        turn = self.pose[:, 2] - self.reference_pose[:, 2]
        error: Array = (turn + np.pi) % (2.0 * np.pi) - np.pi
        return error

    @property
    def flagged(self) -> NDArray[np.int64]:
        """(N,) index of the wheel named as slipping; -1 where none or two are."""
        one: NDArray[np.int64] = np.where(self.named.sum(axis=1) == 1, self.named.argmax(axis=1), -1)
        return one


def log_of(
    time: Array,
    log: LogBuffer,
    names: Sequence[str],
    told: Sequence[Event],
    residual: Array,
    *,
    ended: str = "done",
    driven: float = 1.0,
    base: WheelBase | None = None,
) -> BaseLog:
    """Arrays and events from the buffer of the compiled loop.

    `told` are events that the caller knows of; `residual` (m, m) is `1 - D D^+` times the wheels' radii; `base` tells
    what lost wheels mean.
    """
    m, controlled = len(names), log.controlled
    truth = truth_of(time, log.body, log.wheels, m)
    measured, reference, shunts, counts = (log.seen[:, row, :m] for row in range(4))
    status = controlled["status"].astype(np.int64)
    named, dead, jammed = (_members(controlled[name].astype(np.int64), m) for name in ("flagged", "dead", "jams"))
    goal = float(controlled["ref_rate"][-1]) if len(controlled) else 1.0
    events = [*told, *BaseWords(names, np.inf, base).events(0, controlled, truth.slip, goal)]
    return BaseLog(
        time=time,
        wheels=tuple(names),
        pose=truth.pose,
        twist=truth.twist,
        estimated_pose=columns(controlled, "seen_x", "seen_y", "seen_theta"),
        estimated_twist=columns(controlled, "seen_vx", "seen_vy", "seen_w"),
        reference_pose=columns(controlled, "ref_x", "ref_y", "ref_theta"),
        reference_twist=columns(controlled, "ref_vx", "ref_vy", "ref_w"),
        rate=controlled["ref_rate"],
        wheel_angles=truth.wheel_angles,
        counts=counts.astype(np.int64),
        wheel_speeds=truth.wheel_speeds,
        measured_speeds=measured,
        reference_speeds=reference,
        currents=truth.currents,
        measured_currents=shunts,
        voltages=truth.voltages,
        forces=truth.forces,
        cross_forces=truth.cross_forces,
        loads=truth.loads,
        friction_limits=truth.friction_limits,
        slip=truth.slip,
        residuals=measured @ residual.T,
        status=status,
        named=named,
        dead=dead,
        jammed=jammed,
        gyro=controlled["gyro"],
        acceleration=columns(controlled, "imu_x", "imu_y"),
        energy=truth.energy,
        events=tuple(sorted(events, key=lambda event: event.time)),
        ended=ended,
        driven=driven,
    )


def _members(sets: NDArray[np.int64], count: int) -> NDArray[np.bool_]:
    """(N, count) whether each wheel is in each set."""
    if not sets.any():
        return np.zeros((len(sets), count), np.bool_)
    members: NDArray[np.bool_] = (sets[:, None] >> np.arange(count)) & 1 == 1
    return members
