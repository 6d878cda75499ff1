"""The log of a base as records, buffer after buffer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holonom.app.job import BaseJob
from holonom.app.rig.wheel_frames import framed_wheels, wheel_frames, wheel_poses
from holonom.arrays import Array
from holonom.closed_loop.base_kernels import LogBuffer
from holonom.control.base.uncertainty import PoseUncertainty
from holonom.machine.base.settings import Creep
from holonom.machine.base.uncertainty import pose_uncertainty
from holonom.mobile import SlipStatus
from holonom.mobile.drive.base_drive import standing_wheels
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
    Pitch,
    Signal,
    Sink,
    Steering,
    WheelContact,
    WheelLoad,
)
from holonom.sim.base.log import columns, of_wheels, truth_of

__all__ = ["BaseRecords"]


SLIPS, LOST = 1, 2
"""Signals of a base that is alone: a wheel slips; a motor is left out."""


class BaseRecords:
    """Records of a base: one sample each 10 ms. Mutable state: the covariance of its pose, integrals, signals.

    Parameters
    ----------
    job
        The base.
    creep
        What is known of its wheels' creep.
    residual
        (m, m) rim speeds that no twist explains, per wheel speed.
    sink
        Where records go.
    """

    def __init__(self, job: BaseJob, creep: Creep, residual: Array, sink: Sink) -> None:
        self._job, self._sink, self._residual = job, sink, residual
        settings = pose_uncertainty(job.base, job.drive, job.sensors, creep, job.settings.estimate)
        self._sure = PoseUncertainty(settings, 1e-3)
        self._wanted = np.zeros(len(job.base.driven))  # integral of the commanded speeds, rad
        self._frames = wheel_frames(job.base)
        framed = framed_wheels(job.base)
        self._lanes = np.array([lane for lane, _ in framed], dtype=int)
        self._driven = np.array([wheel.driven for _, wheel in framed], dtype=bool)
        self._steered = np.array([wheel.steers for _, wheel in framed], dtype=bool)
        names = [wheel.name for _, wheel in framed]
        self._groups = [names.index(job.base.wheels[group[0]].name) for group in job.base.layout.groups]
        self._standing = 0 if job.drives == "ideal" else len(standing_wheels(job.base))
        self._step = 2.0 * np.pi / job.drive.steering.counts_per_turn
        self._bodies = ("body",) if job.base.balances else ()
        self._axle = float(job.base.wheel_radii.max())
        moving = (*self._frames, *self._bodies)
        tree = ("map", "odom", *("base_link" for _ in moving)), ("odom", "base_link", *moving)
        self._tree = tree
        self._signals: dict[int, bool] = {}
        self._motor = 2.0 * np.pi / job.drive.encoder.counts_per_rev / job.drive.gear.ratio
        self._torque = job.drive.motor.torque_constant * job.drive.gear.ratio

    def put(self, first: int, log: LogBuffer, every: int = 10) -> None:
        """Record a buffer whose first millisecond is given."""
        m, control = len(self._job.base.driven), log.controlled
        true = truth_of(np.empty(0), log.body, log.wheels, m)
        measured_speed, reference, currents, counts = (log.seen[:, row, :m] for row in range(4))
        seen, twist = (
            columns(control, "seen_x", "seen_y", "seen_theta"),
            columns(control, "seen_vx", "seen_vy", "seen_w"),
        )
        push = columns(control, "imu_x", "imu_y")
        sure = self._sure.along(seen, twist, push)
        wanted = self._wanted + 1e-3 * (np.cumsum(reference, axis=0) - reference)
        if len(reference):
            self._wanted = wanted[-1] + 1e-3 * reference[-1]
        angle = self._motor * (counts + 0.5)
        at = np.arange(-first % every, len(control), every)
        rolled, steered = self._rolled(log, at)
        T, wheels = _poses(true.pose[at]), wheel_poses(self._job.base, np.eye(4), rolled, steered)
        counted = rolled.copy()  # of free wheels nothing is measured
        counted[:, self._driven] = angle[at][:, self._lanes[self._driven]]
        seen_steering = self._step * (np.floor(steered / self._step) + 0.5) if self._job.base.steered else steered
        believed, seen_wheels = _poses(seen[at]), wheel_poses(self._job.base, np.eye(4), counted, seen_steering)
        pitch, seen_pitch = true.pitch[at], control["seen_pitch"][at]
        if self._bodies:
            wheels, seen_wheels = (
                np.concatenate([known, _leaning(lean, self._axle)[:, None]], axis=1)
                for known, lean in ((wheels, pitch), (seen_wheels, seen_pitch))
            )
        asked, commanded = (
            columns(control, "ref_x", "ref_y", "ref_theta"),
            columns(control, "ref_vx", "ref_vy", "ref_w"),
        )
        loads = of_wheels(log.wheels, "load", self._standing)[at]
        asked_of = of_wheels(log.wheels, "asked", int(self._lanes.max(initial=-1)) + 1)[at][:, self._lanes]
        residual = self._unexplained(measured_speed[at], seen_steering)
        still, put = np.zeros(m), self._sink.put
        for i, k in enumerate(at):
            t = 1e-3 * (first + k)
            self._digital(t, control[k])
            put(EncoderCounts(t, counts[k].astype(np.int64)))
            put(JointState(t, angle[k], measured_speed[k], self._torque * currents[k]))
            put(JointCommand(t, wanted[k], reference[k], still))
            put(JointTruth(t, true.wheel_angles[k], true.wheel_speeds[k], self._torque * true.currents[k]))
            put(DriveState(t, currents[k], true.voltages[k]))
            put(DriveTruth(t, true.currents[k]))
            put(BaseState(t, seen[k], twist[k], sure[k]))
            put(BaseCommand(t, asked[k], commanded[k]))
            put(BaseTruth(t, true.pose[k], true.twist[k]))
            put(Inertial(t, float(control["gyro"][k]), push[k]))
            put(WheelContact(t, true.forces[k], true.slip[k], residual[i]))
            if self._standing and loads[i].any():  # before its first step nothing is weighed
                put(WheelLoad(t, loads[i]))
            if self._steered.any():
                put(Steering(t, seen_steering[i, self._steered], asked_of[i, self._steered]))
            if self._bodies:
                put(Pitch(t, pitch[i, None], seen_pitch[i, None]))
            put(
                FramePoses(
                    t, ("base_link", *self._frames, *self._bodies), np.concatenate([T[i, None], T[i] @ wheels[i]])
                )
            )
            put(FrameTree(t, *self._tree, np.concatenate([np.eye(4)[None], believed[i, None], seen_wheels[i]])))

    def _unexplained(self, speeds: Array, steering: Array) -> Array:
        """Rim speeds (N, m), m/s, that no twist explains, of wheel speeds (N, m) as the wheels are steered (N, n)."""
        base = self._job.base
        if not base.steered:
            return speeds @ self._residual.T
        rims, angles = speeds * base.wheel_radii, steering[:, self._groups]
        driven = [name in base.driven for name in base.rolling_names]
        rows = base.rolling_matrix(angles)[:, driven] / [1.0, 1.0, base.radius]
        twist = np.linalg.pinv(rows, rcond=1e-6) @ rims[..., None]
        return np.asarray(rims - (rows @ twist)[..., 0])

    def _rolled(self, log: LogBuffer, at: NDArray[np.int_]) -> tuple[Array, Array]:
        """How far the wheels with frames have rolled (N, n) and are steered (N, n), rad, at some milliseconds."""
        count = int(self._lanes.max(initial=-1)) + 1
        rolled, turned = (of_wheels(log.wheels, name, count)[at][:, self._lanes] for name in ("angle", "turned"))
        return rolled, turned

    def _digital(self, t: float, control: NDArray[np.void]) -> None:
        """Signals of a base that is alone; of several robots only the cell has signals."""
        if self._job.name:
            return
        slips = int(control["status"]) in (SlipStatus.SLIP, SlipStatus.AMBIGUOUS)
        for number, on in ((SLIPS, slips), (LOST, bool(control["dead"]))):
            if self._signals.get(number) != on:
                self._signals[number] = on
                self._sink.put(Signal(t, number, on))


def _leaning(pitch: Array, axle: float) -> Array:
    """T (N, 4, 4) in base_link of a body that leans by pitch (N,) forwards about an axle at a height, m."""
    T = np.tile(np.eye(4), (len(pitch), 1, 1))
    T[:, 0, 0] = T[:, 2, 2] = np.cos(pitch)
    T[:, 0, 2] = np.sin(pitch)
    T[:, 2, 0] = -T[:, 0, 2]
    T[:, 0, 3], T[:, 2, 3] = -axle * T[:, 0, 2], axle * (1.0 - T[:, 2, 2])
    return T


def _poses(poses: Array) -> Array:
    """T (N, 4, 4) of base_link at (N, 3)."""
    T = np.tile(np.eye(4), (len(poses), 1, 1))
    T[:, 0, 0] = T[:, 1, 1] = np.cos(poses[:, 2])
    T[:, 1, 0] = np.sin(poses[:, 2])
    T[:, 0, 1] = -T[:, 1, 0]
    T[:, :2, 3] = poses[:, :2]
    return T
