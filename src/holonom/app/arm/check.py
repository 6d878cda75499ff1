"""`holonom check` of an arm: what is wrong with its program or its cell, found without moving anything."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from holonom.app.answer import Answer
from holonom.app.arm.assembly import line_settings
from holonom.app.arm.cell_model import ArmCell
from holonom.app.arm.job import Job, load_job
from holonom.errors import ProgramError, ProgramFault
from holonom.lang import Program, Status, load_program, start, step
from holonom.machine import DryMachine

__all__ = ["check_arm", "check_program", "rehearse"]


def check_program(path: Path) -> Answer:
    """Check a program (.arps) by compiling it.

    Raises
    ------
    ProgramError
        All that was found, a line each.
    """
    program = load_program(path)
    names = ", ".join(routine.name for routine in program.routines)
    return _answer([f"{path}: no errors; programs: {names}"], {"kind": "program"}, program)


def check_arm(cell: ArmCell, path: Path) -> Answer:
    """Check a cell by planning every motion that its program makes.

    Returns
    -------
    Answer
        Warnings, the parts seen, the motions made and an estimate of the cycle time.

    Raises
    ------
    InputError
        All that was found, a line each with file and line: also locations out of reach, joint limits that a motion
        would leave, and a program that fails or does not end.
    """
    job = load_job(cell, path)
    machine, failures = rehearse(job)
    found = [*job.unreachable, *_problems(job.program, machine), *failures]
    if found:
        raise ProgramError("\n".join(found))
    seen = len(job.seen.parts) if job.seen is not None else 0
    lines = [
        f"{path}: no errors; {machine.moved} motions planned, at most about {machine.time():.1f} s (all from rest)"
    ]
    if job.seen is not None:
        lines.append(f"{seen} parts seen in the photograph")
    data = {"kind": "cell", "parts": seen, "motions": machine.moved, "estimated_time_s": machine.time()}
    return _answer(lines, data, job.program)


def _answer(lines: list[str], data: dict[str, object], program: Program) -> Answer:
    warnings = [warning.render() for warning in program.warnings]
    text = "\n".join([*lines, *(f"warning: {warning}" for warning in warnings)])
    return Answer(text, {"file": program.file, **data, "warnings": warnings})


def rehearse(job: Job) -> tuple[DryMachine, list[str]]:
    """Run a job's program without dynamics, on the parts that the camera sees.

    Returns
    -------
    The machine at the end, with the motions that it could not plan, and what else ended the program early.
    """
    cell, program, seen = job.cell, job.program, job.seen
    home = np.array(cell.arm.home)
    machine = DryMachine(
        job.arm,
        home,
        look=lambda: seen.parts if seen is not None else (),
        ready=home,
        line=line_settings(cell),
        hand_time=max(cell.gripper.close_time, cell.gripper.open_time),
    )
    state = start(program, entry=cell.program.entry, rng=np.random.default_rng(cell.cell.seed))
    try:
        while step(program, state, machine) not in (Status.HALTED, Status.PAUSED):
            machine.tick()
            if machine.time() >= cell.cell.time_limit:
                limit = f"not done after {cell.cell.time_limit:g} s, the cell's time_limit"
                return machine, [f"{program.file}:{state.line}: {limit}"]
    except ProgramFault as fault:
        return machine, [str(fault)]
    return machine, []


def _problems(program: Program, machine: DryMachine) -> list[str]:
    """Motions that cannot be made: each line of the program once, with the first reason."""
    times = Counter(problem.line for problem in machine.problems)
    first = {problem.line: problem.text for problem in reversed(machine.problems)}
    return [
        f"{program.file}:{line}: {first[line]}{f' ({times[line]} times)' if times[line] > 1 else ''}"
        for line in sorted(first)
    ]
