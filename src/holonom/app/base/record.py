"""The log of a base as a recording."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.app.base.assembly import BaseJob
from holonom.app.base.uncertainty import uncertainty
from holonom.app.recording import Recorder
from holonom.app.recording.robot import base_words
from holonom.app.wheel_frames import wheel_frames, wheel_poses
from holonom.closed_loop import BaseLog
from holonom.control.base_uncertainty import covariance_along
from holonom.mobile import SlipStatus, WheelBase
from holonom.signals import (
    BaseCommand,
    BaseState,
    BaseTruth,
    DriveState,
    DriveTruth,
    EncoderCounts,
    FramePoses,
    FrameTree,
    Inertial,
    JointCommand,
    JointState,
    JointTruth,
    Record,
    Signal,
    WheelContact,
)

__all__ = ["RATE", "record_log"]

Array = NDArray[np.float64]

RATE = 100.0
"""Samples per second that go into the recording; events and signals go in at their own times."""
SLIP_SIGNAL, DEAD_SIGNAL = 1, 2
"""Signals: a wheel slips; a motor is left out."""
MAP = np.eye(4)[None]
"""Of odom in the map: without a localiser the map is where odometry began (REP 105)."""
SLIPS = (SlipStatus.SLIP, SlipStatus.AMBIGUOUS)


def record_log(path: Path, job: BaseJob, log: BaseLog, *, attachments: Mapping[str, bytes] | None = None) -> None:
    """Write a log as a recording, every kind of record in order of time.

    Raises
    ------
    OutputError
        The file cannot be made.
    OutputFault
        The disk is full, or gone.
    """
    records = [*_samples(job, log), *log.events]
    records += _signal(log.time, np.isin(log.status, SLIPS), SLIP_SIGNAL)
    records += _signal(log.time, log.dead.any(axis=1), DEAD_SIGNAL)
    drive = job.drive
    words = base_words(job.base, drive.encoder.counts_per_rev, drive.gear.ratio)
    with Recorder(path, log.wheels, tool="base_link", attachments=attachments, metadata=words) as recorder:
        for record in sorted(records, key=lambda record: record.time):
            recorder.put(record)


def _samples(job: BaseJob, log: BaseLog) -> Iterator[Record]:
    dt = log.time[1] - log.time[0]
    step = round(1.0 / (RATE * dt))
    motor = 2.0 * np.pi / job.drive.encoder.counts_per_rev / job.drive.gear.ratio
    torque = job.drive.motor.torque_constant * job.drive.gear.ratio
    measured = np.asarray(motor * (log.counts + 0.5), dtype=np.float64)  # the middle of a count
    wanted = dt * (np.cumsum(log.reference_speeds, axis=0) - log.reference_speeds)
    sure = covariance_along(uncertainty(job), dt, log.estimated_pose, log.estimated_twist, log.acceleration)
    true, believed = (
        _frames(job.base, poses[::step], angles[::step])
        for poses, angles in ((log.pose, log.wheel_angles), (log.estimated_pose, measured))
    )
    wheels, still = wheel_frames(job.base), np.zeros(len(log.wheels))
    tree = ("map", "odom", *("base_link" for _ in wheels)), ("odom", "base_link", *wheels)
    for i, k in enumerate(range(0, len(log.time), step)):
        t = float(log.time[k])
        yield EncoderCounts(t, log.counts[k])
        yield JointState(t, measured[k], log.measured_speeds[k], torque * log.measured_currents[k])
        yield JointCommand(t, wanted[k], log.reference_speeds[k], still)
        yield JointTruth(t, log.wheel_angles[k], log.wheel_speeds[k], torque * log.currents[k])
        yield DriveState(t, log.measured_currents[k], log.voltages[k])
        yield DriveTruth(t, log.currents[k])
        yield BaseState(t, log.estimated_pose[k], log.estimated_twist[k], sure[k])
        yield BaseCommand(t, log.reference_pose[k], log.reference_twist[k])
        yield BaseTruth(t, log.pose[k], log.twist[k])
        yield Inertial(t, float(log.gyro[k]), log.acceleration[k])
        yield WheelContact(t, log.forces[k], log.slip[k], log.residuals[k])
        T, on_base = true
        yield FramePoses(t, ("base_link", *wheels), np.concatenate([T[i, None], T[i] @ on_base[i]]))
        T, on_base = believed
        yield FrameTree(t, *tree, np.concatenate([MAP, T[i, None], on_base[i]]))


def _frames(base: WheelBase, poses: Array, angles: Array) -> tuple[Array, Array]:
    """Poses (N, 4, 4) of base_link where it stands, and (N, m, 4, 4) of its wheels on it."""
    T = np.tile(np.eye(4), (len(poses), 1, 1))
    T[:, 0, 0] = T[:, 1, 1] = np.cos(poses[:, 2])
    T[:, 1, 0] = np.sin(poses[:, 2])
    T[:, 0, 1] = -T[:, 1, 0]
    T[:, :2, 3] = poses[:, :2]
    return T, wheel_poses(base, np.eye(4), angles)


def _signal(time: Array, on: ArrayLike, number: int) -> list[Signal]:
    """What a signal is at the start, and each change."""
    states = np.asarray(on, dtype=bool)
    changes = [0, *(np.flatnonzero(np.diff(states)) + 1)]
    return [Signal(float(time[k]), number, bool(states[k])) for k in changes]
