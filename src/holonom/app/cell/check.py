"""`holonom check` of a cell: every motion and path planned, nothing moved, nothing written."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from holonom.app.cell.build.base_use import path_use, path_warnings
from holonom.app.cell.build.job import build_job
from holonom.app.cell.in_the_way import first_met
from holonom.app.cell.load import load_cell
from holonom.app.cell.rehearse import rehearse
from holonom.app.console.answer import Answer
from holonom.app.console.progress import Progress
from holonom.app.job import ArmJob, BaseJob, Job
from holonom.errors import InputError, ProgramError

__all__ = ["check_cell"]


@dataclass
class _Said:
    """What was found of a robot: a sentence, JSON values, warnings, notes, and what is wrong."""

    text: str
    data: dict[str, Any]
    warnings: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)


def check_cell(path: Path, *, quiet: bool = True, allow_outside: bool = False) -> Answer:
    """Check a cell by building all of it, planning every motion and looking at what its paths ask for.

    What takes longer than a moment shows how far it is, unless it is to be `quiet`.

    Returns
    -------
    Answer
        A line for each robot, warnings, notes about what was assumed or cannot be simulated yet.

    Raises
    ------
    InputError
        All that was found, a line each with file and line: also locations out of reach, joint limits that a motion
        would leave, and programs that fail or do not end.
    """
    job = build_job(load_cell(path, allow_outside=allow_outside), path)
    robots = [*(_arm(job, arm, quiet) for arm in job.arms), *(_base(job, base) for base in job.bases)]
    wrong = [*job.unreachable, *(line for robot in robots for line in robot.wrong)]
    if wrong:
        raise ProgramError("\n".join(wrong))
    warnings = [
        f"{robot.data['name']}: {warning}" if len(robots) > 1 else warning
        for robot in robots
        for warning in robot.warnings
    ]
    notes = [*job.notes, *(note for robot in robots for note in robot.notes)]
    lines = [*_lines(path, robots), *_seen(job)]
    lines += [f"warning: {warning}" for warning in warnings] + [f"note: {note}" for note in notes]
    return Answer("\n".join(lines), {**_data(path, job, robots), "warnings": warnings, "notes": notes})


def _lines(path: Path, robots: list[_Said]) -> list[str]:
    if len(robots) == 1:
        return [f"{path}: no errors; {robots[0].text}"]
    return [f"{path}: no errors; {len(robots)} robots", *(f"{robot.data['name']}: {robot.text}" for robot in robots)]


def _seen(job: Job) -> list[str]:
    if job.photograph is None:
        return []
    return [f"{len(job.photograph.detections)} parts seen in the photograph"]


def _data(path: Path, job: Job, robots: list[_Said]) -> dict[str, Any]:
    found: dict[str, Any] = {"file": str(path), "kind": "cell"}
    if job.arms:
        found["parts"] = len(job.photograph.detections) if job.photograph is not None else 0
    if len(robots) == 1:
        return found | {key: value for key, value in robots[0].data.items() if key not in ("name", "kind")}
    times = [robot.data["estimated_time_s"] for robot in robots]
    return found | {"robots": [robot.data for robot in robots], "estimated_time_s": max(times)}


def _arm(job: Job, arm: ArmJob, quiet: bool) -> _Said:
    data: dict[str, Any] = {"name": arm.name, "kind": "arm", "drives": arm.drives}
    if arm.program is None:
        return _Said("no program; the arm stands", {**data, "motions": 0, "estimated_time_s": 0.0})
    with Progress(f"checking {arm.name or job.name}", None, quiet=quiet) as progress:
        done = rehearse(job, arm, progress=progress)
    machine = done.machine
    text = f"{machine.moved} motions planned, at most about {machine.time():.1f} s (all from rest)"
    data |= {"motions": machine.moved, "estimated_time_s": machine.time()}
    warnings = [*(warning.render() for warning in arm.program.warnings), *done.warnings(arm.program)]
    notes = [f"{arm.name or arm.arm.model.name}: {note}" for note in done.notes]
    return _Said(text, data, warnings, notes, [*done.problems(arm.program), *done.failures])


def _base(job: Job, base: BaseJob) -> _Said:
    data: dict[str, Any] = {"name": base.name, "kind": "base", "drives": base.drives}
    task = base.task
    if task.path is None:
        end = float(task.velocities[-1, 0]) if task.velocities is not None else task.hold or 0.0
        what = "velocities followed" if task.velocities is not None else "it holds its place"
        use = {**data, "estimated_time_s": task.start + end}
        return _Said(f"{what} for {end:.1f} s", use, path_warnings(base, job.floor))
    try:
        use = path_use(base)
    except InputError:  # told as a note: such a base is only looked at
        return _Said(f"a path of {task.path.time[-1]:.1f} s", {**data, "estimated_time_s": float(task.path.time[-1])})
    text = (
        f"a path of {use['path_length_m']:.1f} m in {use['estimated_time_s']:.1f} s, wheels at up to "
        f"{use['peak_wheel_speed_rad_s']:.0f} of {use['wheel_speed_limit_rad_s']:.0f} rad/s"
    )
    met = first_met(base, job.obstacles)
    if met is None:
        return _Said(text, data | use, path_warnings(base, job.floor))
    who = f"{base.name}: it" if base.name else "the base"
    wrong = [f"{who} would hit {met.name} at {met.time:.2f} s of its path"] if met.distance < 0.0 else []
    text += f", {1e3 * met.distance:.0f} mm from {met.name} at {met.time:.1f} s"
    data["clearance_m"] = met.distance
    return _Said(text, data | use, path_warnings(base, job.floor), wrong=wrong)
