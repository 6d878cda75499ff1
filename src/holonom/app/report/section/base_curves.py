"""Section: lines over time of each base: path error, motion, steering, pitch, wheels, slip, forces, motors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holonom.app.report.drawing.curves import Curve
from holonom.app.report.findings.base_findings import motion_of
from holonom.app.report.findings.base_outline import base_of
from holonom.app.report.findings.base_words import dead_since, verdicts_of
from holonom.app.report.parts import CurveGroup
from holonom.app.report.section_table import Section
from holonom.app.report.source import BARE, RobotSource, Source
from holonom.arrays import Array
from holonom.mobile.drive.base_drive import standing_wheels
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

STILL = 0.02
"""m/s and rad/s below which a base stands."""
NOTHING = 1e-6
"""Of what is unexplained or found, below which there is nothing to draw."""
SHARPEST = 10.0
"""1/m, of a curve that is drawn: turning on the spot has no bound."""


def _parts(source: Source) -> Sequence[CurveGroup]:
    groups = [CurveGroup(_curves(robot), robot.key("curves"), robot.called("Curves")) for robot in _bases(source)]
    return [group for group in groups if group.curves]


def _bases(source: Source) -> list[RobotSource]:
    return [robot for robot in source.robots if robot.facts.kind == "base" and robot.recording.tracks]


def _curves(robot: RobotSource) -> list[Curve]:
    key = f"{robot.name}:" if robot.name else ""
    unknown = [f"{key}force", f"{key}current"] if robot.facts.ideal else []
    curves = [curve for curve in _of_base(robot, key) if curve.key not in unknown]
    silent = (f"{key}residual", f"{key}status")
    return [
        curve
        for curve in curves
        if len(curve.time) and curve.values.size and (curve.key not in silent or np.abs(curve.values).max() > NOTHING)
    ]


def _of_base(robot: RobotSource, key: str) -> list[Curve]:
    recording, names = robot.recording, robot.recording.joint_names
    contacts, drives = recording.contacts, recording.drives
    wheels = recording.true_joints if len(recording.true_joints.time) else recording.joints
    return [
        *_path_errors(robot, key),
        *_motion(robot, key),
        *_steering(robot, key),
        *_pitch(robot, key),
        Curve(f"{key}residual", "Rim speed that no twist explains", "m/s", contacts.time, contacts.residual, names),
        Curve(f"{key}slip", "Slip, true", "m/s", contacts.time, contacts.slip, names),
        *_status(robot, key),
        Curve(f"{key}force", "Driving force", "N", contacts.time, contacts.force, names),
        Curve(f"{key}speed", "Wheel speed", "rad/s", wheels.time, wheels.velocity, names),
        *_loads(robot, key),
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


def _motion(robot: RobotSource, key: str) -> list[Curve]:
    """Speed, turning rate, and how near the centre of rotation is: as asked, as believed and as they were."""
    recording = robot.recording
    tracks = {"commanded": recording.base_reference, "measured": recording.base, "true": recording.true_base}
    tracks = {name: track for name, track in tracks.items() if len(track.time)}
    if not tracks:
        return []
    count = min(len(track.time) for track in tracks.values())
    time = next(iter(tracks.values())).time[:count]
    twists = [track.twist[:count] for track in tracks.values()]
    speed, turning = (np.stack([values(twist) for twist in twists], axis=1) for values in (_speed, _turning))
    curvature = np.stack([_curvature(twist) for twist in twists], axis=1)
    names = tuple(tracks)
    return [
        Curve(f"{key}velocity", "Speed", "m/s", time, speed, names),
        Curve(f"{key}turning", "Turning rate", "°/s", time, np.degrees(turning), names),
        Curve(
            f"{key}centre", "Curvature: 1 over the distance of the centre of rotation", "1/m", time, curvature, names
        ),
    ]


def _speed(twist: Array) -> Array:
    """(N,) m/s; of a base that does not move sideways below zero backwards."""
    forwards, sideways = np.abs(twist[:, :2]).max(axis=0)
    speed = np.hypot(twist[:, 0], twist[:, 1])
    return np.asarray(speed if sideways > 0.2 * forwards else np.copysign(speed, twist[:, 0]))


def _turning(twist: Array) -> Array:
    return twist[:, 2]


def _curvature(twist: Array) -> Array:
    """(N,) 1/m, to the left above zero; 0 at rest, at most `SHARPEST`."""
    speed, w = np.hypot(twist[:, 0], twist[:, 1]), twist[:, 2]
    bent = w / np.maximum(speed, np.maximum(np.abs(w) / SHARPEST, STILL))
    return np.asarray(np.where(np.maximum(speed, np.abs(w)) < STILL, 0.0, bent))


def _steering(robot: RobotSource, key: str) -> list[Curve]:
    """Angles of steered wheels beside those that were asked for."""
    tracks, base = robot.recording.tracks, base_of(robot.facts)
    measured, asked = (tracks.get(f"/{kind}/steering") for kind in ("measured", "commanded"))
    if measured is None or asked is None or base is None:
        return []
    names = [wheel.name for wheel in base.wheels if wheel.steers]
    count = min(len(measured.time), len(asked.time))
    values = np.concatenate([measured.fields["angle"][:count], asked.fields["asked"][:count]], axis=1)
    if values.shape[1] != 2 * len(names):
        return []
    return [
        Curve(
            f"{key}steering", "Steering angle", "°", measured.time[:count], np.degrees(values),
            (*names, *(f"{name}, asked" for name in names)),
        )
    ]  # fmt: skip


def _pitch(robot: RobotSource, key: str) -> list[Curve]:
    """How a body that balances leans."""
    true, seen = (robot.recording.tracks.get(f"/{kind}/pitch") for kind in ("truth", "estimated"))
    if true is None or seen is None:
        return []
    count = min(len(true.time), len(seen.time))
    values = np.concatenate([true.fields["angle"][:count], seen.fields["seen"][:count]], axis=1)
    return [Curve(f"{key}pitch", "Pitch, forwards", "°", true.time[:count], np.degrees(values), ("true", "estimated"))]


def _loads(robot: RobotSource, key: str) -> list[Curve]:
    """What wheels bear."""
    track, base = robot.recording.tracks.get("/truth/wheel_load"), base_of(robot.facts)
    if track is None or base is None:
        return []
    names = tuple(wheel.name for wheel in standing_wheels(base))
    values = track.fields["load"]
    return [Curve(f"{key}load", "Wheel load", "N", track.time, values, names)] if values.shape[1] == len(names) else []


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
