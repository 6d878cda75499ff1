"""The log of a base as a recording."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from holonom.app.base.assembly import BaseJob
from holonom.app.base.scene import wheel_frames, wheel_poses
from holonom.app.recording import Recorder
from holonom.closed_loop import BaseLog
from holonom.mobile import SlipStatus
from holonom.signals import (
    BaseCommand,
    BaseState,
    DriveState,
    FramePoses,
    Inertial,
    JointCommand,
    JointState,
    Record,
    Signal,
    WheelContact,
)
from holonom.spatial import pose

__all__ = ["RATE", "record_log"]

Array = NDArray[np.float64]

RATE = 200.0
"""Samples per second that go into the recording; events and signals go in at their own times."""
SLIP_SIGNAL, DEAD_SIGNAL = 1, 2
"""Signals: a wheel slips; a motor is left out."""


def record_log(path: Path, job: BaseJob, log: BaseLog) -> None:
    """Write a log as a recording, every kind of record in order of time.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    records = [*_samples(job, log), *log.events]
    records += _signal(log.time, log.status != SlipStatus.NO_SLIP, SLIP_SIGNAL)
    records += _signal(log.time, log.dead.any(axis=1), DEAD_SIGNAL)
    with Recorder(path, log.wheels, tool="base_link") as recorder:
        for record in sorted(records, key=lambda record: record.time):
            recorder.put(record)


def _samples(job: BaseJob, log: BaseLog) -> Iterator[Record]:
    step = round(1.0 / (RATE * (log.time[1] - log.time[0])))
    angles = np.cumsum(log.wheel_speeds, axis=0) * (log.time[1] - log.time[0])
    torque = log.forces * job.base.wheel_radii
    frames = ("base_link", *wheel_frames(job.base))
    still = np.zeros(len(log.wheels))
    unknown = np.zeros((3, 3))
    for k in range(0, len(log.time), step):
        t = float(log.time[k])
        T = pose((*log.pose[k, :2], 0.0), Rotation.from_euler("z", log.pose[k, 2]).as_matrix())
        yield JointState(t, angles[k], log.measured_speeds[k], torque[k])
        yield JointCommand(t, angles[k], log.reference_speeds[k], still)
        yield DriveState(t, log.currents[k], log.voltages[k])
        yield BaseState(t, log.estimated_pose[k], log.estimated_twist[k], unknown)
        yield BaseCommand(t, log.reference_pose[k], log.reference_twist[k])
        yield Inertial(t, float(log.gyro[k]), log.acceleration[k])
        yield WheelContact(t, log.forces[k], log.slip[k], log.residuals[k])
        yield FramePoses(t, frames, np.concatenate([T[None], wheel_poses(job.base, T, angles[k])]))


def _signal(time: Array, on: ArrayLike, number: int) -> list[Signal]:
    states = np.asarray(on, dtype=bool)
    return [Signal(float(time[k]), number, bool(states[k])) for k in np.flatnonzero(np.diff(states)) + 1]
