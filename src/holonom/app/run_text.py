"""What a run says of itself in the end, from its summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from holonom.app.output import REPORT

__all__ = ["robot_lines", "run_text"]


def run_text(summary: Mapping[str, Any], folder: Path, pace: float) -> str:
    """Lines for a person: how it ended, what came of each robot, where the report is.

    `pace` is how many times faster than real time it was simulated and recorded.
    """
    head = f"{summary['cell']}: {_ended(summary)}, {pace:g} x real time"
    return "\n".join([head, *robot_lines(summary), f"report: {folder / REPORT}"])


def robot_lines(summary: Mapping[str, Any]) -> list[str]:
    """Lines of what came of the parts and of each robot, and what was assumed."""
    robots = summary.get("robots")
    lines = [*_parts(summary)]
    if robots is None:
        lines += _robot(summary)
    else:
        lines += [f"{name}: {line}" for name, robot in robots.items() for line in _robot(robot)]
    return lines + [f"note: {note}" for note in summary["notes"]]


def _ended(summary: Mapping[str, Any]) -> str:
    time = f"{summary['simulated_time_s']:.1f} s of simulated time"
    what = "program at PAUSE" if summary["outcome"] == "paused" else _done(summary)
    return f"{what} after {time}"


def _done(summary: Mapping[str, Any]) -> str:
    if "robots" in summary:
        return "all done"
    return "program ended" if "joints" in summary else "task done"


def _parts(summary: Mapping[str, Any]) -> Iterator[str]:
    if summary.get("parts") and summary["placed"]:
        fields = ", ".join(f"{count} {name}" for name, count in summary["placed"].items())
        yield f"{sum(summary['placed'].values())} of {summary['parts']} parts in the tray: {fields}"


def _robot(summary: Mapping[str, Any]) -> Iterator[str]:
    """Lines of an arm or a base."""
    for phase in summary.get("tracking") or ():
        errors = ", ".join(f"{name} {1e3 * value:.3f} mm" for name, value in phase["rms_m"].items())
        yield f"{phase['phase']}: tracking error rms {errors}; ratio {phase['ratio']:.2f}"
    yield from map(_slip_text, summary.get("slips", ()))
    yield from map(_motor_text, summary.get("dead_motors", ()))
    for alarm in summary.get("false_alarms", ()):
        yield f"{alarm['start']:.2f} s to {alarm['end']:.2f} s: {alarm['what']}"
    eventful = summary.get("slips") or summary.get("dead_motors")
    phases = [error for error in summary.get("path_errors", ()) if error["rms_m"] is not None]
    yield from map(_error_text, phases if eventful else phases[:1])


def _error_text(error: Mapping[str, Any]) -> str:
    bare = error["peak_without_handling_m"]
    beside = "" if bare is None else f" (without handling {1e3 * bare:.1f} mm)"
    rms, peak = 1e3 * error["rms_m"], 1e3 * error["peak_m"]
    return f"{error['phase']}: path error rms {rms:.1f} mm, peak {peak:.1f} mm{beside}"


def _slip_text(slip: Mapping[str, Any]) -> str:
    told = "not found" if slip["delay"] is None else f"found after {1e3 * slip['delay']:.0f} ms"
    if slip["naming_delay"] is not None:
        told += f", named after {1e3 * slip['naming_delay']:.0f} ms"
    elif slip["delay"] is not None:
        told += ", ambiguous"
    others = [name for name in slip["named"] if name != slip["wheel"]]
    too = f"; {' and '.join(others)} named too" if others else ""
    return f"{slip['start']:.2f} s: {slip['wheel']} slips; {told}{too}"


def _motor_text(motor: Mapping[str, Any]) -> str:
    late = motor["detected"]
    told = "not found" if late is None else f"found after {1e3 * (late - motor['time']):.0f} ms"
    if not motor["reached"]:
        told = "the run ended before"
    return f"{motor['time']:.2f} s: motor of {motor['wheel']} {motor['kind']}; {told}"
