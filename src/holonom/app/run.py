"""`holonom run`: a cell file becomes a recording, a summary and a report, whatever robots it holds."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job, refuse_unsimulated
from holonom.app.console.answer import Answer
from holonom.app.console.interrupts import Interrupted, Interrupts
from holonom.app.console.output import RECORDING, REPORT, SUMMARY, RunFolder
from holonom.app.console.progress import Progress
from holonom.app.job import Job
from holonom.app.recording import Recorder
from holonom.app.recording.robot import base_words
from holonom.app.report.attached import OUTCOME, ending_words
from holonom.app.report.attachments import attachments_of
from holonom.app.report.findings.summary import summary_of
from holonom.app.report.findings.summary_lines import summary_lines
from holonom.app.report.reporting import report_html
from holonom.app.report.source import source_of
from holonom.app.rig import Ended, Ending, Rig, simulated
from holonom.app.rig.base import creep_of
from holonom.app.start.named import refuse_other
from holonom.control import CONTROLLERS
from holonom.errors import InputError, OutputFault, ProgramError

__all__ = ["run_cell"]

COMPARED, UNHANDLED = "recording_{}.mcap", "recording_without_handling.mcap"
"""Recordings of runs under other controllers, and of bases that do nothing about slip and lost motors."""


@dataclass(frozen=True, slots=True)
class Plan:
    """One run of a cell: its recording, and which of the settings it is under; the first plan is the run itself."""

    file: str
    job: Job
    controller: int = -1


@dataclass(frozen=True, slots=True)
class Done:
    """A plan that was run: how it ended, and how much faster than real time, compiling apart."""

    plan: Plan
    ended: Ended
    pace: float


def run_cell(
    path: Path,
    output: Path,
    *,
    seed: int | None = None,
    quiet: bool = True,
    say: Callable[[str], None] = lambda text: None,
    allow_outside: bool = False,
) -> Answer:
    """Run a cell and write `recording.mcap`, `summary.json` and `report.html` into a folder.

    The recording grows from the first tick on; summary and report are made from it. Runs for comparison, under other
    controllers or without any handling of faults, are recorded beside it.

    Parameters
    ----------
    path : cell file.
    output : folder to write to, made if need be.
    seed : instead of the cell's own.
    quiet : no progress bar.
    say : takes what programs type.
    allow_outside : see `load_cell`.

    Raises
    ------
    InputError
        Before anything is written.
    RunError
        After the start; recording, summary and report up to that moment are kept.
    Interrupted
        Ctrl-C or SIGTERM. In motion the same is kept; before, nothing; in the making of the report, recordings.
    """
    refuse_other(path)
    cell = load_cell(path, allow_outside=allow_outside)
    refuse_unsimulated(cell, path)
    job = build_job(cell, path)
    if job.unreachable:
        raise ProgramError("\n".join(job.unreachable))
    if seed is not None:
        job = dataclasses.replace(job, seed=seed)
    plans = plans_of(job)
    with Interrupts() as interrupts, RunFolder(output, recordings=_recordings()) as folder:
        try:
            runs = _run_all(plans, folder, interrupts, quiet=quiet, say=say)
            answer = _tell(runs, folder)
            if interrupts.requested():
                raise Interrupted
            return answer
        except KeyboardInterrupt:
            if not (folder.path / RECORDING).exists():  # an older one is gone
                raise Interrupted from None
            raise Interrupted(f"what was recorded until now is kept in {folder.path}") from None


def _run_all(
    plans: list[Plan], folder: RunFolder, interrupts: Interrupts, *, quiet: bool, say: Callable[[str], None]
) -> list[Done]:
    """Run the plans, up to the first that does not come to its end; interrupts are kept from the first motion on."""
    runs: list[Done] = []
    for plan in plans:
        runs.append(_run(plan, folder, interrupts, quiet=quiet, say=_silent if runs else say))
        if runs[-1].ended.ending not in (Ending.DONE, Ending.PAUSED):
            break
    interrupts.keep(False)
    return runs


def _recordings() -> list[str]:
    """All that a run may leave: those of an earlier one are not to be compared with this one's."""
    return [RECORDING, UNHANDLED, *(COMPARED.format(name) for name in CONTROLLERS)]


def _silent(text: str) -> None:
    """Programs type in every run; once is enough to see."""


def plans_of(job: Job) -> list[Plan]:
    """Return the run of a job, then those that it is compared with."""
    plans = [Plan(RECORDING, job)]
    if len(job.arms) == 1:
        settings = job.arms[0].settings
        plans += [Plan(COMPARED.format(own.controller), job, k) for k, own in enumerate(settings[:-1])]
    if not job.arms and any(_breaks(job)):
        plans.append(Plan(UNHANDLED, _unhandled(job)))
    return plans


def _breaks(job: Job) -> list[bool]:
    """Whether something happens to each base on its path that its controller may handle."""
    return [
        base.task.path is not None
        and bool(base.faults or job.floor.patches)
        and any(part is not None for part in (base.settings.slip, base.settings.traction, base.settings.watch))
        for base in job.bases
    ]


def _unhandled(job: Job) -> Job:
    """The same job with bases that do nothing about slip and lost motors, and are not judged by their paths."""
    bases = [
        dataclasses.replace(
            base, settings=base.settings.without_motors(), task=dataclasses.replace(base.task, tolerance=None)
        )
        for base in job.bases
    ]
    return dataclasses.replace(job, bases=tuple(bases))


def _run(plan: Plan, folder: RunFolder, interrupts: Interrupts, *, quiet: bool, say: Callable[[str], None]) -> Done:
    """Run a plan; whatever goes wrong ends the motion and leaves a recording that can be read."""
    job = plan.job
    loops = simulated(job, [arm.settings[plan.controller] for arm in job.arms])
    loops.warm_up()
    words: dict[str, dict[str, str]] = {}
    for base in job.bases:
        encoder = base.drive.encoder
        creep = creep_of(loops.bases[base.name].controller)
        words |= base_words(base.base, encoder.counts_per_rev, base.drive.gear.ratio, robot=base.name, creep=creep)
    files = attachments_of(job, plan.controller, rated=[arm.rated for arm in job.arms], patches=job.patches)
    interrupts.keep()
    with (
        Recorder(folder.path / plan.file, attachments=files, metadata=words) as recorder,
        Progress(job.name, expected_time(job), quiet=quiet) as progress,
    ):
        begin = time.perf_counter()
        rig = Rig(job, loops, recorder, say=progress.saying(say))
        ended = rig.run(stop=interrupts.requested, overdue=interrupts.overdue, progress=progress)
        recorder.metadata(OUTCOME, ending_words(rig.ending(ended)))
    return Done(plan, ended, ended.time / max(time.perf_counter() - begin, 1e-9))


def expected_time(job: Job) -> float | None:
    """Simulated time, s, at which a job of bases ends if all goes well; None where programs run."""
    if any(arm.program is not None for arm in job.arms) or any(base.task.after is not None for base in job.bases):
        return None
    return max([*(arm.hold for arm in job.arms), *(base.task.end for base in job.bases)], default=None)


def _unwritten(folder: RunFolder, name: str, content: str) -> list[str]:
    """Write a file; what went wrong, in a line: how the run ended is to be told all the same."""
    try:
        folder.write(name, content)
    except OutputFault as fault:
        return [str(fault)]
    return []


def _tell(runs: list[Done], folder: RunFolder) -> Answer:
    """Make summary and report from the recordings; say, or raise, how it went.

    Raises
    ------
    RunError
        A run failed, or the report could not be written.
    Interrupted
        The operator stopped it.
    """
    try:
        source = source_of(folder.path / RECORDING)
    except InputError as error:  # somebody removed it, or the disk failed
        raise OutputFault(f"the run ended, and its recording cannot be read again: {error}") from error
    summary = summary_of(source)
    told = json.dumps(summary, indent=2, allow_nan=False) + "\n"
    unwritten = [*_unwritten(folder, REPORT, report_html(source)), *_unwritten(folder, SUMMARY, told)]
    last, lines = runs[-1].ended, summary_lines(source, summary)
    if last.ending is Ending.FAILED and last.fault is not None:
        what = "\n".join([str(last.fault), *(f"  {line}" for line in [*unwritten, *lines[1:]])])
        raise type(last.fault)(f"{what}\n  what was recorded until then is in {folder.path}") from last.fault
    if last.ending is Ending.STOPPED:
        raise Interrupted
    if unwritten:
        raise OutputFault("\n  ".join([*unwritten, *lines]))
    pace = round(runs[0].pace, 1)  # of the wall clock: not in the summary, which equal runs have in common
    lines = [f"{lines[0]}, {pace:g} x real time", *lines[1:], f"report: {folder.path / REPORT}"]
    return Answer("\n".join(lines), summary | {"real_time_factor": pace})
