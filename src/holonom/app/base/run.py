"""`holonom run` of a mobile base: its cell becomes a recording, a summary and a report."""

from __future__ import annotations

import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from holonom.app.answer import Answer
from holonom.app.base.assembly import build_job, simulate
from holonom.app.base.cell_model import BaseCell
from holonom.app.base.outcome import dead_motors, ending, false_alarms, path_error, phases, slip_episodes
from holonom.app.base.record import record_log
from holonom.app.base.report import Findings, write_base_report
from holonom.app.output import prepare_output
from holonom.errors import DriveFault

__all__ = ["run_base"]


def run_base(cell: BaseCell, path: Path, output: Path) -> Answer:
    """Run a base's cell and write `recording.mcap`, `summary.json` and `report.html` into a folder.

    The same run without any handling of slip and dead motors is simulated beside it, for comparison.

    Raises
    ------
    InputError
        Before anything is written.
    DriveFault
        The base did not get to the end of its path in time; the records say how far.
    """
    job = build_job(cell, path)
    folder = prepare_output(output)
    log = simulate(job)
    begin = time.perf_counter()
    bare = simulate(job, handling=False)
    pace = float(bare.time[-1]) / (time.perf_counter() - begin)
    slips = slip_episodes(log, job.floor)
    stretches = phases(log, slips, job.faults)
    found = Findings(
        log=log,
        bare=bare,
        failure=ending(log, cell.cell.time_limit),
        slips=slips,
        dead=dead_motors(log, job.faults),
        alarms=false_alarms(log, job.floor, job.faults),
        errors=[(phase, path_error(log, phase), path_error(bare, phase)) for phase in stretches],
    )
    record_log(folder / "recording.mcap", job, log)
    summary = _summary(cell, found)
    (folder / "summary.json").write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    write_base_report(folder / "report.html", job, found, folder / "recording.mcap", _facts(found, pace))
    text = _text(summary, folder)
    if found.failure is not None:
        raise DriveFault(f"{text}\n  what was recorded until then is in {folder}")
    return Answer(text, summary)


def _summary(cell: BaseCell, found: Findings) -> dict[str, Any]:
    """The run in numbers, JSON values only."""
    return {
        "cell": cell.cell.name,
        "seed": cell.cell.seed,
        "outcome": "done" if found.failure is None else "failed",
        "failure": found.failure,
        "simulated_time_s": float(found.log.time[-1]),
        "path_driven": float(found.log.driven),
        "slips": [
            asdict(slip)
            | {"named": list(slip.named), "delay": slip.delay, "naming_delay": slip.naming_delay, "right": slip.right}
            for slip in found.slips
        ],
        "dead_motors": [asdict(motor) for motor in found.dead],
        "false_alarms": [asdict(alarm) for alarm in found.alarms],
        "path_errors": [
            {
                "phase": phase.name,
                "start_s": phase.start,
                "end_s": phase.end,
                "rms_m": error and error.rms,
                "peak_m": error and error.peak,
                "believed_peak_m": error and error.believed,
                "heading_peak_rad": error and error.heading,
                "peak_without_handling_m": bare and bare.peak,
            }
            for phase, error, bare in found.errors
        ],
    }


def _facts(found: Findings, pace: float) -> dict[str, str]:
    whole = found.errors[0][1]
    facts = {"Simulated time": f"{found.log.time[-1]:.1f} s", "Path driven": f"{100.0 * found.log.driven:.0f} %"}
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
    facts["Simulated"] = f"{pace:.0f} x real time"
    return facts


def _text(summary: dict[str, Any], folder: Path) -> str:
    done = f"path driven in {summary['simulated_time_s']:.1f} s of simulated time"
    lines = [f"{summary['cell']}: {summary['failure'] or done}"]
    lines += [_slip_text(slip) for slip in summary["slips"]]
    lines += [_motor_text(motor) for motor in summary["dead_motors"]]
    lines += [f"{a['start']:.2f} s to {a['end']:.2f} s: {a['what']}" for a in summary["false_alarms"]]
    for error in summary["path_errors"]:
        bare = error["peak_without_handling_m"]
        beside = "" if bare is None else f" (without handling {1e3 * bare:.1f} mm)"
        rms, peak = 1e3 * error["rms_m"], 1e3 * error["peak_m"]
        lines.append(f"{error['phase']}: path error rms {rms:.1f} mm, peak {peak:.1f} mm{beside}")
    lines.append(f"report: {folder / 'report.html'}")
    return "\n".join(lines)


def _slip_text(slip: dict[str, Any]) -> str:
    told = "not found" if slip["delay"] is None else f"found after {1e3 * slip['delay']:.0f} ms"
    if slip["naming_delay"] is not None:
        told += f", named after {1e3 * slip['naming_delay']:.0f} ms"
    elif slip["delay"] is not None:
        told += ", ambiguous"
    others = [name for name in slip["named"] if name != slip["wheel"]]
    too = f"; {' and '.join(others)} named too" if others else ""
    return f"{slip['start']:.2f} s: {slip['wheel']} slips; {told}{too}"


def _motor_text(motor: dict[str, Any]) -> str:
    late = motor["detected"]
    told = "not found" if late is None else f"found after {1e3 * (late - motor['time']):.0f} ms"
    if not motor["reached"]:
        told = "the run ended before"
    return f"{motor['time']:.2f} s: motor of {motor['wheel']} {motor['kind']}; {told}"
