"""Load cycles of an arm's joints from its own motion: a recording, or a cell that is run for it."""

from __future__ import annotations

import dataclasses
import tempfile
from pathlib import Path

import numpy as np

from holonom.app.recording import Recording, read_recording
from holonom.arrays import Array
from holonom.devices import LoadCycle
from holonom.errors import InputError, UnknownName
from holonom.mechanics import Arm
from holonom.model.load import found_model

__all__ = ["cycles_of_cell", "cycles_of_recording"]


def cycles_of_recording(path: Path, joint: str, arm_name: str | None) -> tuple[dict[str, LoadCycle], list[str]]:
    """Load cycles of some joints of a recorded arm.

    Parameters
    ----------
    path : of the recording.
    joint : name or number (from 1) of a joint, or "all".
    arm_name : preset or URDF file of the arm, whose model gives torques without the motors; without it the recorded
        torques are taken, in which the old motors' rotors and friction are.

    Returns
    -------
    Cycle of each joint by its name; notes on what was taken.

    Raises
    ------
    InputError
        No motion in it, another arm, no such joint.
    """
    recording = read_recording(path)
    if arm_name is not None:
        return _modelled(path, recording, Arm(found_model(arm_name)), joint)
    track = recording.joints
    if len(track.time) < 3 or track.effort.shape != track.position.shape or not track.position.size:
        raise InputError(f"{path}: no torques of joints in it; name the arm with --arm, for its model's")
    names = recording.joint_names
    speed = np.gradient(track.position, track.time, axis=0)
    cycles = {
        names[k]: LoadCycle.sampled(track.time, speed[:, k], track.effort[:, k]) for k in _chosen(joint, tuple(names))
    }
    return cycles, ["torques as recorded, with the old motors' rotors and friction; --arm NAME takes the model's"]


def cycles_of_cell(path: Path, joint: str, *, quiet: bool) -> tuple[dict[str, LoadCycle], list[str]]:
    """Load cycles of joints of the first arm of a cell, which is run for it; parameters as above.

    Raises
    ------
    InputError, RunError
        No arm in it; as `run_cell`.
    """
    from holonom.app.cell.build.job import build_job
    from holonom.app.cell.load import load_cell
    from holonom.app.run import run_cell

    job = build_job(load_cell(path), path)
    if not job.arms:
        raise InputError(f"{path}: no arm in it; a cell with an arm is needed, or a load cycle")
    with tempfile.TemporaryDirectory(prefix="holonom-") as folder:
        run_cell(path, Path(folder), quiet=quiet)
        recording = read_recording(Path(folder) / "recording.mcap", robot=job.arms[0].name or None)
    return _modelled(path, recording, job.arms[0].arm, joint)


def _modelled(path: Path, recording: Recording, arm: Arm, joint: str) -> tuple[dict[str, LoadCycle], list[str]]:
    """Cycles with torques by the model without its motors, along the commanded motion where it was recorded."""
    commanded = recording.reference
    track = commanded if len(commanded.time) >= 3 else recording.joints
    names = tuple(arm.limits.names)
    if len(track.time) < 3 or track.position.shape[1] != arm.n:
        raise InputError(
            f"{path} has {len(track.time)} samples of {track.position.shape[1]} joints; three at least of the {arm.n} "
            f"joints of {arm.model.name} are needed"
        )
    keep = np.append(True, np.diff(track.time) > 0.0)
    time, q = track.time[keep], track.position[keep]
    qd: Array = track.velocity[keep] if track.velocity.shape == track.position.shape else np.gradient(q, time, axis=0)
    qdd = np.gradient(qd, time, axis=0)
    bare = arm.remade(joints=tuple(dataclasses.replace(one, motor=None) for one in arm.model.joints))
    torque = bare.inverse_dynamics(q, qd, qdd)
    some = q[:: max(len(q) // 200, 1)]
    inertia = np.diagonal(bare.mass_matrix(some), axis1=1, axis2=2).max(axis=0)
    cycles = {
        names[k]: LoadCycle.sampled(time, qd[:, k], torque[:, k], inertia=float(inertia[k]))
        for k in _chosen(joint, names)
    }
    what = "commanded" if track is commanded else "measured"
    return cycles, [
        f"torques by the model of {arm.model.name} without its motors, along the {what} motion; joint friction of the "
        "model is in them; inertia: the largest on the way"
    ]


def _chosen(joint: str, names: tuple[str, ...]) -> list[int]:
    if joint == "all":
        return list(range(len(names)))
    if joint in names:
        return [names.index(joint)]
    if joint.isdecimal() and 1 <= int(joint) <= len(names):
        return [int(joint) - 1]
    raise UnknownName("joint", joint, [*names, "1 ... " + str(len(names)), "all"])
