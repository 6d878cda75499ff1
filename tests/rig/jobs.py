"""Jobs of one or several robots, made without a cell file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from holonom import load_arm
from holonom.app.job import ArmJob, BaseJob, Job, Mount, Task
from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.lang import compile_program
from holonom.machine import BaseSettings, ControlSettings, LineSettings, PathLimits, plan_path
from holonom.mobile import BaseDrive, BaseSensors, WheelBase, omni
from holonom.sim import Disc, Gripper, Ground, Surface
from holonom.spatial import pose

MOTOR = DcMotor(1.2, 0.56e-3, 25.5e-3, 25.5e-3, 9.25e-6, 14.8, 8.0)
DRIVE = BaseDrive(MOTOR, Gear(3.0, 0.9), Encoder(4096), Friction(2e-6, 2e-3, 2e-3), 2.516704e-5)
BASE = omni(np.radians([57, 135, 225, 303]), radius=0.0789, wheel_radius=0.02711, mass=6.35, com_height=0.04)
PUMA = load_arm("puma560")
HOME = np.radians([0.0, 45.0, -180.0, 0.0, -45.0, 0.0])


def arm_job(program: str | None, name: str = "", **changes: object) -> ArmJob:
    """A Puma at home above nothing, with ideal joints, so that its tests compile little."""
    said = {
        "name": name,
        "arm": PUMA,
        "mount": None,
        "drives": "ideal",
        "settings": (ControlSettings(),),
        "home": HOME,
        "program": None if program is None else compile_program(program),
        "entry": None,
        "look": (),
        "gripper": None,
        "ground": Ground(),
        "line": LineSettings(),
        "rated": PUMA,
    } | changes
    return ArmJob(**said)  # type: ignore[arg-type]


def base_job(task: Task, name: str = "", base: WheelBase = BASE, **changes: object) -> BaseJob:
    """A four-wheel soccer robot."""
    said = {
        "name": name,
        "base": base,
        "drive": DRIVE,
        "drives": "motors",
        "settings": BaseSettings(),
        "sensors": BaseSensors(),
        "pose": np.zeros(3) if task.path is None else task.path.pose[0],
        "task": task,
        "faults": (),
        "frames": {"base_link": np.eye(4), "top": pose((0.0, 0.0, 0.3))},
    } | changes
    return BaseJob(**said)  # type: ignore[arg-type]


def line(length: float = 1.0) -> Task:
    """Straight ahead, from rest to rest."""
    return Task(path=plan_path([[0.0, 0.0], [0.5 * length, 0.0], [length, 0.0]], PathLimits(0.8, 1.5)))


def job(*robots: ArmJob | BaseJob, **changes: object) -> Job:
    """A cell of some robots."""
    said = {
        "name": "test",
        "description": "",
        "file": Path("cell.toml"),
        "seed": 1,
        "time_limit": 60.0,
        "arms": tuple(r for r in robots if isinstance(r, ArmJob)),
        "bases": tuple(r for r in robots if isinstance(r, BaseJob)),
    } | changes
    return Job(**said)  # type: ignore[arg-type]


__all__ = ["BASE", "DRIVE", "HOME", "PUMA", "Disc", "Gripper", "Mount", "Surface", "arm_job", "base_job", "job", "line"]
