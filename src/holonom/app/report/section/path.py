"""Section: where a base drove, and how far that is from where it should have been."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from holonom.app.report.drawing.figures import Figures, Table
from holonom.app.report.drawing.robot_map import MapRobot
from holonom.app.report.drawing.topview import MapLine, MapMark, MapPatch, TopView
from holonom.app.report.findings.base_findings import BaseFindings, Motion, Phase, findings_of, motion_of, path_error
from holonom.app.report.findings.base_outline import base_of, stations
from holonom.app.report.findings.base_words import broken
from holonom.app.report.section_table import Section
from holonom.app.report.source import BARE, RobotSource, Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

REFERENCE, TRUE, BELIEVED, OTHER = "var(--ink)", "#0f766e", "#8f7ae0", "#f0a37f"
PATCH, OBSTACLE, STEP, MARK = "#bfe3f5", "#e07a5f", "#8b7355", "#b3261e"
COLOURS = ("#0b7285", "#d9480f", "#5f3dc4", "#2b8a3e", "#c2255c", "#9c6f00", "#1864ab", "#495057")
MARKS, ROWS = 40, 200
"""Marks on a map and rows of the table; more cannot be read."""
NOTE = (
    "Distance of the true pose from where the reference is at the same instant. The controller knows its pose by dead "
    "reckoning only; what it believes its error to be is the believed peak, the rest is drift."
)


def _parts(source: Source) -> Sequence[Figures]:
    moving = _moving(source)
    together = [_together(source, moving)] if len(moving) > 1 else []
    return [*together, *(_section(source, robot, motion) for robot, motion in moving)]


def _together(source: Source, moving: Sequence[tuple[RobotSource, Motion]]) -> Figures:
    """Where all of them drove, and stood at the end."""
    lines = [MapLine(robot.name, m.true[:, :2], COLOURS[k % len(COLOURS)]) for k, (robot, m) in enumerate(moving)]
    ends = [replace(stood, name=robot.name) for robot, m in moving for stood in _stations(robot, m)[-1:]]
    return Figures("paths", "Paths of all bases", [TopView("seen from above", lines, _patches(source), robots=ends)])


def _patches(source: Source) -> list[MapPatch]:
    patches = [MapPatch(patch.name, np.array(patch.corners), PATCH) for patch in source.cell.patches]
    patches += [MapPatch(step.name, np.array(step.corners), STEP) for step in source.cell.steps]
    return patches + [MapPatch(one.name, np.array(one.corners), OBSTACLE) for one in source.cell.obstacles]


def _stations(robot: RobotSource, motion: Motion) -> list[MapRobot]:
    base = base_of(robot.facts)
    return [] if base is None else stations(base, robot.recording, motion.time, motion.true)


def _moving(source: Source) -> list[tuple[RobotSource, Motion]]:
    bases = [robot for robot in source.robots if robot.facts.kind == "base"]
    return [(robot, motion) for robot in bases if (motion := motion_of(robot.recording)) is not None]


def _section(source: Source, robot: RobotSource, motion: Motion) -> Figures:
    found = findings_of(robot.recording, robot.facts)
    other = robot.beside.get(BARE)
    bare = motion_of(other.recording) if other is not None else None
    map_ = TopView(
        "seen from above", _lines(motion, bare), _patches(source), _marks(found, motion), _stations(robot, motion)
    )
    title = robot.called("Path")
    return Figures(robot.key("path"), title, [map_, _table(found, motion, bare)], NOTE)


def _lines(motion: Motion, bare: Motion | None) -> list[MapLine]:
    lines = [] if bare is None else [MapLine("without handling of faults", bare.true[:, :2], OTHER)]
    return [
        *lines,
        MapLine("driven", motion.true[:, :2], TRUE),
        MapLine("where the controller believed to be", motion.believed[:, :2], BELIEVED),
        MapLine("reference", motion.reference[:, :2], REFERENCE, dashed=True),
    ]


def _marks(found: BaseFindings, motion: Motion) -> list[MapMark]:
    what = [(f"{slip.wheel} slips", slip.start) for slip in found.slips]
    what += [(broken(motor.wheel, motor.kind), motor.time) for motor in found.dead if motor.reached]
    return [MapMark(text, _place(motion, time), MARK) for text, time in what[:MARKS]]


def _place(motion: Motion, time: float) -> tuple[float, float]:
    k = min(int(np.searchsorted(motion.time, time)), len(motion.time) - 1)
    return float(motion.true[k, 0]), float(motion.true[k, 1])


def _table(found: BaseFindings, motion: Motion, bare: Motion | None) -> Table:
    head = ("phase", "from", "to", "rms", "peak", "peak, believed", "heading, peak")
    rows = [_row(phase, motion, bare) for phase in found.phases[:ROWS]]
    return Table((*head, "peak without handling") if bare is not None else head, rows)


def _row(phase: Phase, motion: Motion, bare: Motion | None) -> tuple[str, ...]:
    times = (phase.name, f"{phase.start:.2f} s", f"{phase.end:.2f} s")
    error, other = path_error(motion, phase), path_error(bare, phase)
    beside = () if bare is None else ("ended before" if other is None else f"{1e3 * other.peak:.1f} mm",)
    if error is None:
        return (*times, "", "", "", "", *beside)
    distances = (f"{1e3 * value:.1f} mm" for value in (error.rms, error.peak, error.believed))
    return (*times, *distances, f"{np.degrees(error.heading):.1f}°", *beside)


def _applies(source: Source) -> bool:
    return bool(_moving(source))


SECTION = Method("where a base drove, and should have", lambda _: Section(_applies, _parts), OWN)
