"""A run in words for the terminal: its summary, line by line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from holonom.app.console.printable import one_line
from holonom.app.report.findings.base_words import broken
from holonom.app.report.source import Source

__all__ = ["summary_lines"]

MOST = 20
"""Lines of one sort; the summary has all."""


def summary_lines(source: Source, summary: Mapping[str, Any]) -> list[str]:
    """Say how it ended, where parts lie, and what came of each robot; `summary` as `summary_of` gives it."""
    ending = source.ending
    after = f" after {ending.simulated_time:.1f} s of simulated time" if ending.status in ("done", "paused") else ""
    lines = [f"{one_line(summary['cell'])}: {ending.reason}{after}"]
    if summary.get("parts") and summary["placed"]:
        fields = ", ".join(f"{count} {one_line(name)}" for name, count in summary["placed"].items())
        lines.append(f"{sum(summary['placed'].values())} of {summary['parts']} parts in the tray: {fields}")
    for name, robot in summary.get("robots", {"": summary}).items():
        lines += [one_line(f"{name}: {line}" if name else line) for line in _robot(robot)]
    lost = _some([f"missing from the recording: {text}" for text in source.lost])
    return [*lines, *map(one_line, lost), *(one_line(f"note: {note}") for note in summary["notes"])]


def _robot(robot: Mapping[str, Any]) -> list[str]:
    sorts = (
        [f"what came of it cannot be told ({robot['untold']})"] if "untold" in robot else [],
        [_tracking(phase) for phase in robot.get("tracking") or ()],
        [_slip(slip) for slip in robot.get("slips", ())],
        [_motor(motor) for motor in robot.get("dead_motors", ())],
        [f"{a['start']:.2f} s to {a['end']:.2f} s: {a['what']}" for a in robot.get("false_alarms", ())],
        [_error(error) for error in robot.get("path_errors", ()) if error["rms_m"] is not None],
    )
    return [line for lines in sorts for line in _some(lines)]


def _some(lines: list[str]) -> list[str]:
    return lines if len(lines) <= MOST else [*lines[:MOST], f"... and {len(lines) - MOST} more like these"]


def _tracking(phase: Mapping[str, Any]) -> str:
    errors = ", ".join(f"{name} {1e3 * value:.3f} mm" for name, value in phase["rms_m"].items())
    ratio = "" if phase["ratio"] is None else f"; ratio {phase['ratio']:.2f}"
    return f"{phase['phase']}: tracking error rms {errors}{ratio}"


def _slip(slip: Mapping[str, Any]) -> str:
    missed = "not found" if slip["detectable"] else "not detectable by these wheels"
    found = missed if slip["delay"] is None else f"found after {1e3 * slip['delay']:.0f} ms"
    if slip["naming_delay"] is not None:
        found += f", named after {1e3 * slip['naming_delay']:.0f} ms"
    elif slip["delay"] is not None:
        found += ", ambiguous"
    others = [name for name in slip["named"] if name != slip["wheel"]]
    too = f"; {' and '.join(others)} named too" if others else ""
    return f"{slip['start']:.2f} s: {slip['wheel']} slips; {found}{too}"


def _motor(motor: Mapping[str, Any]) -> str:
    late = motor["detected"]
    found = "not found" if late is None else f"found after {1e3 * (late - motor['time']):.0f} ms"
    if not motor["reached"]:
        found = "the run ended before"
    return f"{motor['time']:.2f} s: {broken(motor['wheel'], motor['kind'])}; {found}"


def _error(error: Mapping[str, Any]) -> str:
    bare = error["peak_without_handling_m"]
    beside = "" if bare is None else f" (without handling {1e3 * bare:.1f} mm)"
    rms, peak = 1e3 * error["rms_m"], 1e3 * error["peak_m"]
    return f"{error['phase']}: path error rms {rms:.1f} mm, peak {peak:.1f} mm{beside}"
