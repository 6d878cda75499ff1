"""`holonom run` of a mobile base: its cell becomes a recording, a summary and a report."""

from __future__ import annotations

import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from holonom.app.answer import Answer
from holonom.app.base.assembly import BaseJob, build_job, simulate
from holonom.app.base.cell_model import BaseCell
from holonom.app.base.outcome import dead_motors, path_errors, slip_episodes
from holonom.app.base.record import record_log
from holonom.app.base.report import Findings, write_base_report
from holonom.app.output import prepare_output

__all__ = ["run_base"]


def run_base(cell: BaseCell, path: Path, output: Path) -> Answer:
    """Run a base's cell and write `recording.mcap`, `summary.json` and `report.html` into a folder.

    The same run without any handling of slip and dead motors is simulated beside it, for comparison.

    Raises
    ------
    InputError
        Before anything is written.
    """
    job = build_job(cell, path)
    folder = prepare_output(output)
    begin = time.perf_counter()
    log = simulate(job)
    wall = time.perf_counter() - begin
    bare = simulate(job, handling=False)
    slips = slip_episodes(log, job.floor)
    found = Findings(
        log,
        bare,
        slips,
        dead_motors(log, job.faults),
        path_errors(log, slips, job.faults),
        path_errors(bare, slips, job.faults),
    )
    record_log(folder / "recording.mcap", job, log)
    summary = _summary(job, found)
    (folder / "summary.json").write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    write_base_report(folder / "report.html", job, found, folder / "recording.mcap", _facts(found, wall))
    return Answer(_text(summary, folder), summary)


def _summary(job: BaseJob, found: Findings) -> dict[str, Any]:
    """The run in numbers, JSON values only."""
    cell = job.cell
    return {
        "cell": cell.cell.name,
        "seed": cell.cell.seed,
        "outcome": "done",
        "simulated_time_s": float(found.log.time[-1]),
        "slips": [
            asdict(slip) | {"named": list(slip.named), "delay": slip.delay, "right": slip.right} for slip in found.slips
        ],
        "dead_motors": [asdict(motor) for motor in found.dead],
        "path_errors": [
            {
                "phase": error.phase,
                "start_s": error.start,
                "end_s": error.end,
                "rms_m": error.rms,
                "peak_m": error.peak,
                "believed_peak_m": error.believed,
                "heading_peak_rad": error.heading,
                "peak_without_handling_m": other.peak,
            }
            for error, other in zip(found.errors, found.bare_errors, strict=True)
        ],
    }


def _facts(found: Findings, wall: float) -> dict[str, str]:
    time = float(found.log.time[-1])
    facts = {"Simulated time": f"{time:.1f} s", "Path error, rms": f"{1e3 * found.errors[0].rms:.1f} mm"}
    if found.slips:
        named = sum(slip.right for slip in found.slips)
        facts["Slips found, wheel named"] = f"{named} of {len(found.slips)}"
    delays = [slip.delay for slip in found.slips if slip.delay is not None]
    if delays:
        facts["Longest delay of slip detection"] = f"{1e3 * max(delays):.0f} ms"
    for motor in found.dead:
        if motor.detected is not None:
            facts["Dead motor found after"] = f"{1e3 * (motor.detected - motor.time):.0f} ms"
    facts["Simulated"] = f"{time / wall:.0f} x real time"
    return facts


def _text(summary: dict[str, Any], folder: Path) -> str:
    lines = [f"{summary['cell']}: path driven in {summary['simulated_time_s']:.1f} s of simulated time"]
    for slip in summary["slips"]:
        named = " and ".join(slip["named"]) or "ambiguous"
        told = "not found" if slip["delay"] is None else f"found after {1e3 * slip['delay']:.0f} ms, named: {named}"
        lines.append(f"{slip['start']:.2f} s: {slip['wheel']} slips; {told}")
    for motor in summary["dead_motors"]:
        late = motor["detected"]
        told = "not found" if late is None else f"found after {1e3 * (late - motor['time']):.0f} ms"
        lines.append(f"{motor['time']:.2f} s: motor of {motor['wheel']} {motor['kind']}; {told}")
    for error in summary["path_errors"]:
        bare = 1e3 * error["peak_without_handling_m"]
        lines.append(
            f"{error['phase']}: path error rms {1e3 * error['rms_m']:.1f} mm, peak {1e3 * error['peak_m']:.1f} mm "
            f"(without handling {bare:.1f} mm)"
        )
    lines.append(f"report: {folder / 'report.html'}")
    return "\n".join(lines)
