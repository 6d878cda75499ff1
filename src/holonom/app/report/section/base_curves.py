"""Section: lines over time of each base: path error, wheels, slip, forces, motors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holonom.app.report.drawing.curves import Curve
from holonom.app.report.findings.base_findings import motion_of
from holonom.app.report.findings.base_words import dead_since, verdicts_of
from holonom.app.report.parts import CurveGroup
from holonom.app.report.section_table import Section
from holonom.app.report.source import BARE, RobotSource, Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]


def _parts(source: Source) -> Sequence[CurveGroup]:
    groups = [CurveGroup(_curves(robot), robot.key("curves"), robot.called("Curves")) for robot in _bases(source)]
    return [group for group in groups if group.curves]


def _bases(source: Source) -> list[RobotSource]:
    return [robot for robot in source.robots if robot.facts.kind == "base" and robot.recording.tracks]


def _curves(robot: RobotSource) -> list[Curve]:
    key = f"{robot.name}:" if robot.name else ""
    unknown = [f"{key}force", f"{key}current"] if robot.facts.ideal else []
    curves = [curve for curve in _of_base(robot, key) if curve.key not in unknown]
    return [curve for curve in curves if len(curve.time) and curve.values.size]


def _of_base(robot: RobotSource, key: str) -> list[Curve]:
    recording, names = robot.recording, robot.recording.joint_names
    contacts, drives = recording.contacts, recording.drives
    wheels = recording.true_joints if len(recording.true_joints.time) else recording.joints
    return [
        *_path_errors(robot, key),
        Curve(f"{key}residual", "Rim speed that no twist explains", "m/s", contacts.time, contacts.residual, names),
        Curve(f"{key}slip", "Slip, true", "m/s", contacts.time, contacts.slip, names),
        *_status(robot, key),
        Curve(f"{key}force", "Driving force", "N", contacts.time, contacts.force, names),
        Curve(f"{key}speed", "Wheel speed", "rad/s", wheels.time, wheels.velocity, names),
        Curve(f"{key}current", "Motor current", "A", drives.time, drives.current, names),
    ]


def _path_errors(robot: RobotSource, key: str) -> list[Curve]:
    runs = {"path_error": ("Path error", robot)}
    if BARE in robot.beside:
        runs["bare_error"] = "Path error without handling", robot.beside[BARE]
    return [
        Curve(f"{key}{name}", title, "mm", motion.time, 1e3 * motion.error[:, None], ("distance",))
        for name, (title, run) in runs.items()
        if (motion := motion_of(run.recording)) is not None
    ]


def _status(robot: RobotSource, key: str) -> list[Curve]:
    """What the controller found: a wheel named, slip without a name, a motor given up; by its events."""
    recording = robot.recording
    time = recording.contacts.time
    verdicts, lost = verdicts_of(recording.events, recording.end()), dead_since(recording.events)
    on = np.zeros((len(time), 3))
    named = [spell for spells in verdicts.named.values() for spell in spells]
    for column, spells in enumerate((named, verdicts.ambiguous)):
        for spell in spells:
            on[(time >= spell.start) & (time < spell.end), column] = 1.0
    on[time >= min(lost.values(), default=np.inf), 2] = 1.0
    names = ("slip, named", "slip, which is ambiguous", "dead motor")
    return [Curve(f"{key}status", "What the controller found", "", time, on, names)]


SECTION = Method("lines over time of a base", lambda _: Section(lambda s: bool(_bases(s)), _parts), OWN)
