"""How well runs of one program kept to their path: phases are the times during which a signal was on.

A phase is called what the program typed in the tick in which its signal went on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from holonom.app.recording import Recording
from holonom.app.report import ComparedRun, Comparison, Phase
from holonom.app.report.comparison import phase_errors
from holonom.mechanics import Arm

__all__ = ["compare_tracking", "tracking_table"]


def compare_tracking(runs: Sequence[tuple[str, Recording]], arm: Arm) -> Comparison:
    """Tool paths of the runs, desired (from the joint references) and actual, and their phases."""
    return Comparison(tuple(_compared(name, recording, arm) for name, recording in runs))


def _compared(name: str, recording: Recording, arm: Arm) -> ComparedRun:
    desired = arm.fk(recording.reference.position)[:, :3, 3]
    actual = arm.fk(recording.joints.position)[:, :3, 3]
    return ComparedRun(name.replace("_", " "), recording.joints.time, desired, actual, _phases(recording))


def _phases(recording: Recording) -> tuple[Phase, ...]:
    """One phase per time a signal was on, in the order of their beginnings; the whole run if there was none."""
    typed = {event.time: event.text for event in recording.events if (event.source, event.level) == ("program", "info")}
    began: dict[int, float] = {}
    found = []
    for signal in recording.signals:
        if signal.on:
            began[signal.number] = signal.time
        elif signal.number in began:
            start = began.pop(signal.number)
            found.append(Phase(typed.get(start, f"signal {signal.number}"), start, signal.time))
    found.sort(key=lambda phase: phase.start)
    return tuple(found) or (Phase("whole run", 0.0, recording.end()),)


def tracking_table(comparison: Comparison) -> list[dict[str, Any]]:
    """Per phase: each run's rms and peak error (m), and the first run's rms over the last one's."""
    table = []
    for k, phase in enumerate(comparison.runs[0].phases):
        errors = {run.name: phase_errors(run, run.phases[k]) for run in comparison.runs}
        first, last = errors[comparison.runs[0].name][0], errors[comparison.runs[-1].name][0]
        table.append(
            {
                "phase": phase.name,
                "rms_m": {name: rms for name, (rms, _) in errors.items()},
                "peak_m": {name: peak for name, (_, peak) in errors.items()},
                "ratio": first / last,
            }
        )
    return table
