"""`holonom run` of an arm: its cell becomes recordings, a summary and a report."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from holonom.app.answer import Answer
from holonom.app.arm.assembly import build_loop, build_scene, build_world, field_of, line_settings, overlay
from holonom.app.arm.camera import Seen
from holonom.app.arm.cell_model import ArmCell
from holonom.app.arm.job import load_job
from holonom.app.arm.tracking import compare_tracking, tracking_table
from holonom.app.output import prepare_output
from holonom.app.recording import Recorder, read_recording
from holonom.app.report import LimitUse, Outcome, write_report
from holonom.closed_loop import SimulatedArm
from holonom.errors import DriveFault, MotionError, ProgramError, ProgramFault, RunError
from holonom.lang import Program, Status, start, step
from holonom.machine import ArmMachine
from holonom.mechanics import Arm
from holonom.model import preset
from holonom.sim import World

__all__ = ["run_arm"]


@dataclass(frozen=True, slots=True)
class Run:
    """One run of the program under one controller, and how it ended."""

    controller: str
    recording: Path
    arm: SimulatedArm
    failure: RunError | None
    wall: float

    @property
    def world(self) -> World:
        return self.arm.world


def run_arm(cell: ArmCell, path: Path, output: Path, *, quiet: bool = True) -> Answer:
    """Run an arm's cell and write `recording.mcap`, `summary.json` and `report.html` into a folder.

    With several controllers the last one's run is `recording.mcap`; the others are `recording_<controller>.mcap`.

    Parameters
    ----------
    cell, path : what the cell file says, and where it lies.
    output : folder to write to, made if need be.
    quiet : no progress bar.

    Raises
    ------
    InputError
        Before anything is written.
    RunError
        After the start; recording, summary and report up to that moment are kept.
    """
    job = load_job(cell, path)
    if job.unreachable:
        raise ProgramError("\n".join(job.unreachable))
    program, seen = job.program, job.seen
    folder = prepare_output(output)
    runs: list[Run] = []
    for controller in cell.arm.controllers:
        last = controller == cell.arm.controllers[-1]
        name = "recording.mcap" if last else f"recording_{controller}.mcap"
        runs.append(_run(cell, program, job.arm, seen, controller, folder / name, quiet=quiet))
        if runs[-1].failure is not None:
            break
    summary = _summary(cell, runs)
    (folder / "summary.json").write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    _report(cell, program, seen, runs, summary, folder / "report.html")
    failure = runs[-1].failure
    if failure is not None:
        raise type(failure)(f"{failure}\n  what was recorded until then is in {folder}") from failure
    return Answer(_text(summary, folder), summary)


def _run(
    cell: ArmCell, program: Program, arm: Arm, seen: Seen | None, controller: str, path: Path, *, quiet: bool
) -> Run:
    """Run the program once. Whatever goes wrong ends the motion and leaves a valid recording."""
    world = build_world(cell, seen)
    names = tuple(joint.name for joint in arm.model.joints)
    begin = time.perf_counter()
    with Recorder(path, names) as recorder, _progress(cell, controller, quiet=quiet) as progress:
        simulated = SimulatedArm(
            build_loop(cell, arm, controller),
            world,
            recorder,
            look=lambda: seen.parts if seen is not None else (),
            ready=np.array(cell.arm.home),
            line=line_settings(cell),
        )
        machine = simulated.machine
        failure: RunError | None = None
        try:
            _execute(cell, program, machine, progress)
        except DriveFault as fault:
            failure = _with_line(fault, program, machine)
            machine.log("error", "drive", str(failure), machine.active_line)
            machine.brake()
        except RunError as fault:
            failure = _with_line(fault, program, machine) if isinstance(fault, MotionError) else fault
            machine.log("error", "program", str(failure), machine.active_line)
            machine.halt()
        except KeyboardInterrupt:
            machine.log("error", "operator", "interrupted")
            machine.halt()
            raise
    return Run(controller, path, simulated, failure, time.perf_counter() - begin)


def _execute(cell: ArmCell, program: Program, machine: ArmMachine, progress: Any) -> None:
    state = start(program, entry=cell.program.entry, rng=np.random.default_rng(cell.cell.seed))
    line = 0
    while True:
        status = step(program, state, machine)
        if machine.active_line not in (0, line):
            line = machine.active_line
            machine.log("debug", "program", program.source(line).split(";")[0].strip(), line)
        machine.advance()
        progress(machine.time())
        if status in (Status.HALTED, Status.PAUSED) and machine.idle() and machine.hand_idle():
            return
        if machine.time() >= cell.cell.time_limit:
            raise ProgramFault(
                f"{program.file}:{state.line}: not done after {cell.cell.time_limit:g} s of simulated time, the cell's "
                f"time_limit\n  {state.line} | {program.source(state.line)}"
            )


def _with_line(fault: RunError, program: Program, machine: ArmMachine) -> RunError:
    """The fault, with the program line whose motion it stopped."""
    line = machine.active_line
    if line == 0:
        return fault
    return type(fault)(f"{program.file}:{line}: {fault}\n  {line} | {program.source(line)}")


@contextmanager
def _progress(cell: ArmCell, controller: str, *, quiet: bool) -> Iterator[Any]:
    """Yield a function that shows the simulated time; it draws at most ten times a second."""
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield lambda _: None
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TextColumn("{task.fields[at]}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(f"{cell.cell.name} ({controller})", total=None, at="")
        shown = 0.0

        def update(simulated: float) -> None:
            nonlocal shown
            now = time.perf_counter()
            if now - shown > 0.1:
                shown = now
                bar.update(task, at=f"{simulated:6.1f} s simulated")

        yield update


def _summary(cell: ArmCell, runs: list[Run]) -> dict[str, Any]:
    """The run in numbers, JSON values only."""
    run = runs[-1]
    states, axes = run.arm.loop.plant.states, run.arm.loop.arm.model.joints
    ticks = max(run.arm.loop.ticks, 1)
    fields = [field_of(cell, disc) for disc in run.world.discs]
    placed = {field.name: fields.count(field.name) for field in cell.tray.fields} if cell.tray else {}
    rms = np.sqrt(states["square_error"] / ticks)
    return {
        "cell": cell.cell.name,
        "seed": cell.cell.seed,
        "outcome": "done" if run.failure is None else "failed",
        "failure": None if run.failure is None else str(run.failure),
        "controllers": [r.controller for r in runs],
        "simulated_time_s": run.arm.loop.time,
        "parts": len(run.world.discs),
        "placed": placed,
        "in_no_field": fields.count(None) if cell.tray else 0,
        "cycle_time_per_part_s": run.arm.loop.time / sum(placed.values()) if sum(placed.values()) else None,
        "largest_contact_force_N": float(run.arm.loop.plant.touch),
        "joints": {
            joint.name: {
                "peak_speed_rad_s": float(state["peak_speed"]),
                "speed_limit_rad_s": rated.limits.speed,
                "peak_torque_Nm": float(state["peak_torque"]),
                "torque_limit_Nm": joint.limits.torque,
                "peak_current_A": float(state["peak_current"]),
                "current_limit_A": joint.motor.max_current if joint.motor else None,
                "peak_voltage_V": float(state["peak_voltage"]),
                "voltage_limit_V": joint.motor.max_voltage if joint.motor else None,
                "peak_error_rad": float(state["peak_error"]),
                "rms_error_rad": float(error),
            }
            for joint, rated, state, error in zip(axes, preset(cell.arm.preset).joints, states, rms, strict=True)
        },
        "tracking": tracking_table(runs_tracked(runs)) if len(runs) > 1 else None,
    }


def runs_tracked(runs: list[Run]) -> Any:
    """The runs' tool paths, phase by phase."""
    return compare_tracking([(run.controller, read_recording(run.recording)) for run in runs], runs[-1].arm.loop.arm)


def _report(
    cell: ArmCell, program: Program, seen: Seen | None, runs: list[Run], summary: dict[str, Any], path: Path
) -> None:
    run = runs[-1]
    start_world = build_world(cell, seen)
    facts = {"Simulated time": f"{run.arm.loop.time:.1f} s", "Controller": run.controller.replace("_", " ")}
    if summary["parts"]:
        facts["Parts in their fields"] = f"{sum(summary['placed'].values())} of {summary['parts']}"
    if summary["cycle_time_per_part_s"] is not None:
        facts["Time per part"] = f"{summary['cycle_time_per_part_s']:.2f} s"
    facts["Largest joint error"] = f"{np.degrees(run.arm.loop.plant.states['peak_error'].max()):.3f} deg"
    facts["Simulated, with recording"] = f"{run.arm.loop.time / run.wall:.0f} x real time"
    ok = run.failure is None
    write_report(
        path,
        read_recording(run.recording),
        build_scene(cell, seen, start_world),
        title=cell.cell.name,
        subtitle=cell.cell.description,
        outcome=Outcome(ok, "program ended" if run.failure is None else str(run.failure).splitlines()[0]),
        facts=facts,
        limits=_limits(summary),
        photograph=overlay(cell, seen, start_world) if seen is not None else None,
        comparison=runs_tracked(runs) if len(runs) > 1 else None,
        program="\n".join(program.lines),
    )


def _limits(summary: dict[str, Any]) -> list[LimitUse]:
    """Peaks of the compiled loops (10 kHz) against the model's limits."""
    joints = list(summary["joints"].values())
    quantities = (
        ("Joint speed", "rad/s", "speed", "rad_s"),
        ("Joint torque", "N m", "torque", "Nm"),
        ("Motor current", "A", "current", "A"),
        ("Motor voltage", "V", "voltage", "V"),
    )
    return [
        LimitUse(
            name,
            unit,
            np.array([joint[f"peak_{key}_{suffix}"] for joint in joints]),
            np.array([joint[f"{key}_limit_{suffix}"] for joint in joints]),
        )
        for name, unit, key, suffix in quantities
    ]


def _text(summary: dict[str, Any], folder: Path) -> str:
    lines = [f"{summary['cell']}: program ended after {summary['simulated_time_s']:.1f} s of simulated time"]
    if summary["parts"]:
        fields = ", ".join(f"{count} {name}" for name, count in summary["placed"].items())
        lines.append(f"{sum(summary['placed'].values())} of {summary['parts']} parts in the tray: {fields}")
    for phase in summary["tracking"] or ():
        errors = ", ".join(f"{name} {1e3 * value:.3f} mm" for name, value in phase["rms_m"].items())
        lines.append(f"{phase['phase']}: tracking error rms {errors}; ratio {phase['ratio']:.2f}")
    lines.append(f"report: {folder / 'report.html'}")
    return "\n".join(lines)
