"""Our own recordings of bases as logs: encoder counts, the true pose, and what the recording says of its wheels."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from holonom.app.odometry_log.checks import check_motion, check_time, part_names
from holonom.app.odometry_log.log import OdometryLog, Subject
from holonom.app.odometry_log.recorded.creep import known_creep, unknown_share
from holonom.app.odometry_log.table import Table
from holonom.app.recording import CUT_OFF, Recording, read_recording
from holonom.app.recording.format.pieces import read_pieces
from holonom.app.recording.robot import BaseDescription, base_of
from holonom.arrays import Array
from holonom.errors import InputError, LogError
from holonom.mobile import WheelBase
from holonom.mobile.calibration import Run, wheels_of
from holonom.mobile.odometry import angle_per_tick, count_differences

__all__ = ["read_own"]


CORNERS = np.array([[1.0, -1.0], [1.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
"""Rim speeds of mecanum wheels, front left, front right, rear left, rear right, per (vx, vy)."""


def read_own(path: Path) -> OdometryLog | None:
    """Read a recording of a run, of several robots the first base; None where a file says nothing of a base.

    Raises
    ------
    LogError
        A base that cannot be calibrated, or a recording without counts.
    """
    try:
        pieces = read_pieces(path, lambda said, messages: None)
        for robot in dict.fromkeys(said.robot for said in pieces.topics) or [""]:
            base = base_of(pieces.metadata, robot)
            if base is not None:
                break
        else:
            return None
        recording = read_recording(path, robot=robot)
    except InputError as error:
        raise LogError(str(error)) from None
    subject = _subject(path, base)
    table, turns = _table(path, recording, base)
    steering = _steering(path, recording, subject.base, table.column("time"))
    creep, drift = known_creep(recording, base, turns, steering)
    (table,), notes = check_time(table, allow_gaps=False, running=True)
    truth = table.values[:, -3:]
    name = part_names(path, 1)[0]
    run = Run(
        name, table.column("time"), turns - creep if len(creep) else turns, truth, steering, drift=drift, creep=creep,
        creep_share=unknown_share(base),
    )  # fmt: skip
    doubts = check_motion(table, run, subject.parameters(), base.wheels)
    cut = (f"{path} was cut off; what is there is taken",) if recording.ended == CUT_OFF else ()
    lost = tuple(f"{path} is damaged or cut off, missing is {missing.text()}" for missing in recording.missing)
    told = (*cut, *lost, *notes, *doubts)
    return OdometryLog(path, subject.drive, subject.geometry, None, (run,), told, base=subject.base)


def _table(path: Path, recording: Recording, base: BaseDescription) -> tuple[Table, Array]:
    """Counts and true poses as a table, and by how much the wheels turned in each sample, rad."""
    counts, truth = recording.counts, recording.true_base
    count = min(len(counts.time), len(truth.time))
    if count < 2:
        raise LogError(f"{path}: {count} samples of encoder counts and true poses; record a run of two or more")
    if not np.array_equal(counts.time[:count], truth.time[:count]):
        raise LogError(f"{path}: counts and true poses are of different times; record them together")
    values = np.column_stack([counts.time[:count], counts.count[:count], truth.pose[:count]])
    table = Table(path, ("time", *base.wheels, "x", "y", "theta"), values, range(1, count + 1))
    ticks = count_differences(counts.count[:count].astype(np.float64))
    ticks[0] = 0.0
    return table, np.ascontiguousarray(ticks * angle_per_tick(base.counts_per_turn, base.gear_ratio))


def _steering(path: Path, recording: Recording, base: WheelBase | None, time: Array) -> Array:
    """Angles (N, k) of steered wheels by their encoders: those of their frames in base_link."""
    if base is None or not base.steered:
        return np.empty((len(time), 0))
    framed = [i for i, w in enumerate(base.wheels) if w.kind not in ("ball", "spherical")
              and (w.driven or w.steers)]  # fmt: skip
    framed.sort(key=lambda i: not base.wheels[i].driven)
    columns = []
    for members in base.layout.groups:
        name = f"wheel_{framed.index(members[0]) + 1}"
        track = recording.tree.get(("base_link", name))
        if track is None or len(track.time) < len(time) or not np.array_equal(track.time[: len(time)], time):
            raise LogError(
                f"{path}: steering of {name} and encoder counts are of different times; record them together"
            )
        T = track.poses()[: len(time)]
        turned = np.arctan2(-T[:, 0, 1], T[:, 1, 1]) - base.wheels[members[0]].heading
        angle = np.unwrap(turned)
        columns.append(angle - 2.0 * math.pi * np.round(angle[0] / (2.0 * math.pi)))
    return np.stack(columns, axis=1)


def _subject(path: Path, base: BaseDescription) -> Subject:
    """A drive that is calibrated by name, or any wheels that the recording describes."""
    known = _drive(base)
    if known is not None and (base.base is None or not base.base.steered):
        return Subject(*known)
    if base.base is None:
        raise LogError(f"{path}: its base has {len(base.wheels)} driven wheels as none of the drives that are known by "
                       "their rows alone; record it again, recordings say all wheels now")  # fmt: skip
    return Subject(base.base.name, {}, base.base)


def _drive(base: BaseDescription) -> tuple[str, dict[str, float]] | None:
    """Which drive a base is, and its nominal numbers; None for others."""
    rows, count = np.array(base.rows), len(base.wheels)
    drive, lever, axes = "", 0.0, np.empty(0)
    if count == 4 and np.allclose(rows[:, :2], CORNERS) and np.ptp(np.abs(rows[:, 2])) < 1e-9:
        drive, lever = "mecanum", 2.0 * abs(rows[0, 2])
    elif count == 2 and np.allclose(rows[:, :2], [1.0, 0.0]) and rows[0, 2] < 0.0 < rows[1, 2]:
        drive, lever = "differential", rows[1, 2] - rows[0, 2]
    elif 3 <= count <= 6 and np.allclose(np.hypot(*rows[:, :2].T), 1.0) and np.ptp(rows[:, 2]) < 1e-9 < rows[0, 2]:
        drive, lever, axes = f"omni{count}_any", rows[0, 2], np.arctan2(-rows[:, 0], rows[:, 1]) % (2.0 * math.pi)
    else:
        return None
    wheels, _ = wheels_of(drive)
    known = {f"diameter_{name}": 2.0 * radius for name, radius in zip(wheels, base.radii, strict=True)}
    known |= {f"axis_{name}": float(axis) for name, axis in zip(wheels, axes, strict=False)}
    names = {"mecanum": "wheelbase_plus_track", "differential": "wheelbase"}
    return drive, {names.get(drive, "wheel_distance"): float(lever), **known}
