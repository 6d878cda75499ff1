"""The report of a recording: made from that file alone, and from those of the same cell beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from holonom.app.answer import Answer
from holonom.app.output import REPORT, RunFolder
from holonom.app.report.attached import program_of
from holonom.app.report.base_findings import Phase, findings_of, motion_of, path_error
from holonom.app.report.page import Head, page_html
from holonom.app.report.peaks import peaks_of
from holonom.app.report.section_table import parts_of
from holonom.app.report.sections import Outcome
from holonom.app.report.source import RobotSource, Source, source_of
from holonom.app.report.summary import GOOD, placed_parts, summary_of

__all__ = ["report_html", "report_recording"]


def report_recording(recording: Path, output: Path) -> Answer:
    """Write `report.html` of a recording into a folder; nothing else there is touched.

    Parameters
    ----------
    recording : the MCAP file: of a run, old or new, also what a killed one left, or by another tool.
    output : folder to write to, made if need be.

    Raises
    ------
    InputError
        The recording is missing, no MCAP file, or damaged. Nothing is written then.
    OutputError
        The folder cannot be written to, or another run writes to it.
    OutputFault
        The disk is full.
    """
    source = source_of(recording)
    page = report_html(source)
    with RunFolder(output, keep=True) as folder:
        path = folder.write(REPORT, page)
    lines = [f"{source.cell.title}: {source.ending.reason}", f"report: {path}"]
    return Answer("\n".join(lines), summary_of(source) | {"report": str(path)})


def report_html(source: Source) -> str:
    """Return the report as one HTML page that needs no network.

    Raises
    ------
    InputError
        What the recording says of itself cannot be read.
    """
    programs = {robot.name: program_of(source.whole, robot.facts.program) for robot in source.robots}
    cell = source.cell
    head = Head(cell.title, _outcome(source), cell.description, _facts(source))
    return page_html(head, source.whole, source.scene, parts_of(source), programs=programs, events=source.events)


def _outcome(source: Source) -> Outcome:
    ending, text = source.ending, source.ending.reason
    robot = source.robots[0]
    motion = motion_of(robot.recording) if source.alone and robot.facts.kind == "base" else None
    if ending.status == "done" and motion is not None:
        text += f", at most {1e3 * motion.error.max():.0f} mm off"
    return Outcome(ending.status in GOOD, text)


def _facts(source: Source) -> dict[str, str]:
    facts = {"Simulated time": f"{source.ending.simulated_time:.1f} s"}
    if source.cell.fields and source.cell.parts:
        placed = sum(placed_parts(source).values())
        facts["Parts in their fields"] = f"{placed} of {len(source.cell.parts)}"
        if placed:
            facts["Time per part"] = f"{source.ending.simulated_time / placed:.2f} s"
    for robot in source.robots:
        own = _arm_facts(robot) if robot.facts.kind == "arm" else _base_facts(robot)
        facts |= {f"{robot.name}: {label}" if not source.alone else label: value for label, value in own.items()}
    return facts


def _arm_facts(robot: RobotSource) -> dict[str, str]:
    facts = {"Controller": robot.facts.controller.replace("_", " ")} if robot.facts.controller else {}
    error = peaks_of(robot)["error"]
    turning = np.array([kind != "prismatic" for kind in robot.facts.kinds], dtype=bool)
    if len(error) and np.isfinite(error[turning]).any():
        facts["Largest joint error"] = f"{np.degrees(np.nanmax(error[turning])):.3f} deg"
    return facts


def _base_facts(robot: RobotSource) -> dict[str, str]:
    found = findings_of(robot.recording, robot.facts)
    facts = {}
    if "path_driven" in robot.numbers:
        facts["Path driven"] = f"{100.0 * robot.numbers['path_driven']:.0f} %"
    whole = path_error(motion_of(robot.recording), Phase("whole run", 0.0, np.inf))
    if whole is not None:
        facts["Path error, rms"] = f"{1e3 * whole.rms:.1f} mm"
    if found.slips:
        facts["Slips with the right name"] = f"{sum(slip.right for slip in found.slips)} of {len(found.slips)}"
    delays = [slip.naming_delay for slip in found.slips if slip.naming_delay is not None]
    if delays:
        facts["Slipping wheel named after"] = f"at most {1e3 * max(delays):.0f} ms"
    for motor in found.dead:
        if motor.detected is not None:
            facts["Dead motor found after"] = f"{1e3 * (motor.detected - motor.time):.0f} ms"
    return facts
