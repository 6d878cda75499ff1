"""The report of a recording: made from that file alone, and from those of the same cell beside it."""

from __future__ import annotations

from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.output import REPORT, RunFolder
from holonom.app.report.attached import program_of
from holonom.app.report.findings.headline import badge_of, headline_of
from holonom.app.report.findings.summary import placed_parts, summary_of
from holonom.app.report.findings.summary_lines import summary_lines
from holonom.app.report.page import Head, page_html, unmade_html
from holonom.app.report.parts import stated
from holonom.app.report.section_table import parts_of
from holonom.app.report.source import Source, source_of

__all__ = ["report_html", "report_recording"]


def report_recording(recording: Path, output: Path) -> Answer:
    """Write `report.html` of a recording into a folder; nothing else there is touched.

    Parameters
    ----------
    recording : the MCAP file: of a run, old or new, also what a killed one left, or by another tool.
    output : folder to write to, made if need be.

    Raises
    ------
    InputError
        The recording is not there, no MCAP file, or so damaged that nothing can be read. Nothing is written then.
    OutputError
        The folder cannot be written to, or another run writes to it.
    OutputFault
        The disk is full.
    """
    source = source_of(recording)
    page = report_html(source)
    with RunFolder(output, keep=True) as folder:
        path = folder.write(REPORT, page)
    summary = summary_of(source)
    lines = [*summary_lines(source, summary), f"report: {path}"]
    return Answer("\n".join(lines), summary | {"report": str(path)})


def report_html(source: Source) -> str:
    """Return the report as one HTML page that needs no network; where none can be made, how the run ended, and why."""
    try:
        return _page(source)
    except Exception as error:  # whatever it is, how the run ended is worth having
        return unmade_html(source.cell.title, badge_of(source), stated(error))


def _page(source: Source) -> str:
    programs = {robot.name: program_of(source.whole, robot.facts.program) for robot in source.robots}
    cell = source.cell
    head = Head(cell.title, badge_of(source), cell.description, _facts(source))
    return page_html(head, source.whole, source.scene, parts_of(source), programs=programs, events=source.events)


def _facts(source: Source) -> dict[str, str]:
    facts = {"Simulated time": f"{source.ending.simulated_time:.1f} s"}
    if source.cell.fields and source.cell.parts:
        placed = sum(placed_parts(source).values())
        facts["Parts in their fields"] = f"{placed} of {len(source.cell.parts)}"
        if placed:
            facts["Time per part"] = f"{source.ending.simulated_time / placed:.2f} s"
    return facts | _headline(source) if source.alone else facts


def _headline(source: Source) -> dict[str, str]:
    """What came of the only robot; where that cannot be told, why not, since the page below may hold the rest."""
    try:
        return headline_of(source.robots[0])
    except Exception as error:
        return {"Not to be told": stated(error)}
