"""How well runs of one program kept to their path: phases are the times during which a signal was on.

A phase is called what the program typed in the tick in which its signal went on.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.app.recording import Recording
from holonom.app.report.findings.comparison import ComparedRun, Comparison, Phase, phase_errors
from holonom.app.report.findings.facts import ArmFacts
from holonom.app.report.source import RobotSource
from holonom.mechanics import Arm
from holonom.model import ArmModel, Joint, Mimic

__all__ = ["arm_of", "compared", "tracking_table"]


def compared(robot: RobotSource) -> Comparison | None:
    """Tool paths of an arm under the controllers of runs beside it and its own, the last; None where there are none.

    The desired path is that of the joint references, the actual one that of the true joints, where they
    are known, else of the measured ones.
    """
    runs = [*robot.beside.values(), robot]
    if len(runs) < 2 or robot.facts.arm is None or not robot.facts.arm.fixed:
        return None
    arm = arm_of(robot.facts.arm)
    if any(not _tracked(run.recording, arm) for run in runs):
        return None
    found = [_run(run.facts.controller, run.recording, arm) for run in runs]
    if len({tuple(phase.name for phase in run.phases) for run in found}) > 1:  # one of them ended early
        return None
    return Comparison(tuple(found), robot.key("comparison"), robot.called("Tracking error compared"))


def arm_of(facts: ArmFacts) -> Arm:
    """The arm, as far as kinematics go."""
    joints = tuple(
        Joint(
            joint.name, joint.kind, joint.before, joint.after, parent=joint.parent,
            mimic=None if joint.mimic is None else Mimic(*joint.mimic),
        )
        for joint in facts.joints
    )  # fmt: skip
    return Arm(ArmModel("recorded", joints, tip=facts.tip)).with_base(facts.base).with_tool(facts.tool)


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
                "ratio": first / last if last > 0.0 else None,
            }
        )
    return table


def _tracked(recording: Recording, arm: Arm) -> bool:
    shape = recording.joints.position.shape
    return recording.reference.position.shape[1:] == shape[1:] == (arm.n,) and shape[0] > 1


def _run(name: str, recording: Recording, arm: Arm) -> ComparedRun:
    joints = recording.true_joints if len(recording.true_joints.time) else recording.joints
    time, reference = joints.time, recording.reference
    wanted = _at(time, reference.time, reference.position)
    desired, actual = (arm.fk(q)[:, :3, 3] for q in (wanted, joints.position))
    return ComparedRun(name.replace("_", " "), time, desired, actual, _phases(recording))


def _at(time: NDArray[np.float64], known: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """References at the times of measurements: most often the same."""
    if np.array_equal(time, known):
        return np.ascontiguousarray(values)
    return np.stack([np.interp(time, known, column) for column in values.T], axis=1)


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
