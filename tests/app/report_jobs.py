"""Jobs and recordings for the tests of reports: an arm on a track that moves, a base that drives and slips."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from holonom.app.job import ArmJob, BaseJob, FieldPlace, Job, Task
from holonom.app.recording import Recorder
from holonom.app.report import Box, Disc, Label, Scene, Tube, View
from holonom.app.report.attached import OUTCOME, ending_words
from holonom.app.report.attachments import attachments_of
from holonom.app.report.findings.facts import Ending
from holonom.devices import DcMotor, Encoder, Gear
from holonom.lang import compile_program
from holonom.machine import BaseSettings, ControlSettings, LineSettings
from holonom.mechanics import load_arm
from holonom.mobile import BaseDrive, BaseSensors, WheelBase, omni
from holonom.signals import (
    BaseCommand,
    BaseState,
    BaseTruth,
    DriveState,
    Event,
    FramePoses,
    JointCommand,
    JointState,
    Record,
    Signal,
    WheelContact,
)
from holonom.sim import BaseFault, Floor, Ground, Material, RectangularPatch, RoundPatch
from holonom.sim import Disc as Part

ARM = load_arm("puma560")
HOME = np.array([0.1, 0.8, -2.6, 0.0, 0.3, 0.0])
LINKS = tuple(f"link{k}" for k in range(1, 7))
PROGRAM = ".PROGRAM main()\n  SIGNAL 1\n  DELAY 1\n  SIGNAL -1\n.END\n"
END = 2.0


def soccer() -> WheelBase:
    """Four omni wheels: front left, rear left, rear right, front right."""
    made = omni(np.radians([57.0, 135.0, 225.0, 303.0]), radius=0.08, wheel_radius=0.027, mass=6.0, com_height=0.04)
    names = ("front left", "rear left", "rear right", "front right")
    wheels = [dataclasses.replace(wheel, name=name) for wheel, name in zip(made.wheels, names, strict=True)]
    return WheelBase(wheels, name="omni", radius=made.radius, mass=6.0, com_height=0.04)


DRIVE = BaseDrive(DcMotor(1.2, 0.56e-3, 25.5e-3, 25.5e-3, 9.25e-6, 14.8, 8.0), Gear(3.0, 0.9), Encoder(4096))
WHEELS = soccer().driven


def arm_job(name: str = "", controllers: Sequence[str] = ("computed_torque",)) -> ArmJob:
    """A Puma that draws."""
    return ArmJob(
        name, ARM, None, "motors", tuple(map(ControlSettings, controllers)), HOME,
        compile_program(PROGRAM, "draw.arps"), None, (), None, Ground(), LineSettings(), ARM,
    )  # fmt: skip


def base_job(name: str = "", faults: Sequence[BaseFault] = ()) -> BaseJob:
    """A soccer robot."""
    return BaseJob(
        name, soccer(), DRIVE, "motors", BaseSettings(), BaseSensors(), np.zeros(3), Task(hold=END), tuple(faults), {}
    )


def job_of(*robots: ArmJob | BaseJob, seed: int = 3, title: str = "a <test>") -> Job:
    """A cell with all there can be in it."""
    prefix = {robot.name: f"{robot.name}/" if robot.name else "" for robot in robots}
    shapes: list = [Box("world", np.eye(4), (1.0, 1.0, 0.02), "#abc"), Label("world", np.eye(4), "tray", 0.02)]
    feet = [prefix[r.name] + ("link1" if isinstance(r, ArmJob) else "base_link") for r in robots]
    shapes += [Tube(frame, (0, 0, 0), (0, 0, 0.1), 0.03, "#def") for frame in feet]
    shapes.append(Disc("coin_01", 0.01, 0.003, "#b08d57", np.array([3.0, 4.0]), np.eye(2)))
    ice = Material(0.1, 0.05, 0.05)
    return Job(
        title, "two of them", Path("cell.toml"), seed, 60.0,
        arms=tuple(r for r in robots if isinstance(r, ArmJob)),
        bases=tuple(r for r in robots if isinstance(r, BaseJob)),
        floor=Floor(Material(), (RoundPatch((1.0, 0.0), 0.2, ice), RectangularPatch((0.0, 1.0), 0.4, 0.2, ice, 0.3))),
        parts=(Part("coin_01", 0.01, 0.003, 0.01, np.eye(4)),),
        fields=(FieldPlace("small", np.eye(4), (0.2, 0.2), 0.01),),
        scene=Scene(tuple(shapes), (View("Overview", (1, 1, 1), (0, 0, 0)),), "world", 2.0, 1.5),
        notes=("The drives are sized.",),
    )  # fmt: skip


def arm_records(lag: float = 0.0, end: float = END) -> Iterator[Record]:
    """Joints that swing, `lag` s behind their references; signal 1 is on while they draw."""
    yield Signal(0.0, 1, False)
    for k in range(round(100 * end) + 1):
        t = k / 100
        if t == 0.5:
            yield Event(t, "info", "program", "a swing", 2)
            yield Signal(t, 1, True)
        if t == 1.5:
            yield Signal(t, 1, False)
        q, qd = HOME + 0.2 * np.sin(t - lag), 0.2 * np.cos(t - lag) * np.ones(6)
        yield JointState(t, q, qd, 10.0 * qd)
        yield JointCommand(t, HOME + 0.2 * np.sin(t), 0.2 * np.cos(t) * np.ones(6), np.zeros(6))
        yield DriveState(t, qd, 5.0 * qd)
        yield FramePoses(t, LINKS, np.stack([ARM.fk(q, frame=name) for name in LINKS]))


def coin_records(end: float = END) -> Iterator[Record]:
    """A coin that lies in its field from 1 s on."""
    for k in range(round(100 * end) + 1):
        part = np.eye(4)
        part[:3, 3] = (0.1, 0.1, 0.002) if k > 100 else (0.5, 0.5, 0.002)
        yield FramePoses(k / 100, ("coin_01",), part[None])


def base_records(aside: float = 0.01, slips: bool = True, end: float = END) -> Iterator[Record]:
    """A base that drives along x at 1 m/s, `aside` m beside its path; its second wheel slips from 0.8 to 1.0 s."""
    base = soccer()
    speeds = base.wheel_speeds([1.0, 0.0, 0.0])
    for k in range(round(100 * end) + 1):
        t = k / 100
        slip = np.zeros(4)
        if slips and 0.8 <= t <= 1.0:
            slip[1] = -0.2 * (1.0 - abs(t - 0.9) / 0.2)
        true, wanted, twist = np.array([t, aside, 0.0]), np.array([t, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
        yield JointState(t, t * speeds, speeds, 0.01 * speeds)
        yield DriveState(t, 0.1 * speeds, 0.2 * speeds)
        yield BaseTruth(t, true, twist)
        yield BaseCommand(t, wanted, twist)
        yield BaseState(t, np.array([t, 0.2 * aside, 0.0]), twist, 1e-6 * np.eye(3))
        yield WheelContact(t, np.ones(4), slip, 0.1 * slip)
        T = np.tile(np.eye(4), (5, 1, 1))
        T[:, :2, 3] = t, aside
        T[1:, :3, 3] += [(w.x, w.y, w.radius) for w in base.wheels]
        yield FramePoses(t, ("base_link", "wheel_1", "wheel_2", "wheel_3", "wheel_4"), T)


SLIP_EVENTS = (
    Event(0.803, "debug", "truth", "rear left slips"),
    Event(0.811, "warning", "slip detection", "rear left slips"),
    Event(0.997, "debug", "truth", "rear left grips"),
    Event(1.02, "info", "slip detection", "no wheel slips any more"),
)


def write(
    path: Path, job: Job, robots: dict[str, Sequence[Record]], ending: Ending | None = None, controller: int = -1
) -> Path:
    """A recording of a job; of each robot the records that are given, those of the cell under ""."""
    names = {"": ()} | {r.name: tuple(j.name for j in r.arm.model.joints) for r in job.arms}
    names |= {r.name: WHEELS for r in job.bases}
    bases = [base.name for base in job.bases]
    with Recorder(path, names[""], attachments=attachments_of(job, controller)) as recorder:
        sinks = {
            name: recorder.scoped(name, names[name], tool="base_link" if name in bases else "tool")
            for name in robots if name
        } | {"": recorder}  # fmt: skip
        every = [(record.time, name, record) for name, records in robots.items() for record in records]
        for _, name, record in sorted(every, key=lambda one: one[0]):
            sinks[name].put(record)
        if ending is not None:
            recorder.metadata(OUTCOME, ending_words(ending))
    return path


def done(**changes: object) -> Ending:
    """An ending without trouble."""
    return dataclasses.replace(Ending("done", "all is done", END), **changes)
