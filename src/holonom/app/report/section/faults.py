"""Section: wheels of a base that slipped, motors that failed, and what was found of it."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.drawing.figures import Figures, Table
from holonom.app.report.findings.base_findings import BaseFindings, DeadMotor, SlipEpisode, findings_of
from holonom.app.report.findings.base_words import broken
from holonom.app.report.section_table import Section
from holonom.app.report.source import RobotSource, Source
from holonom.mobile.base.drivable import skids
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

HEAD = ("what happened", "since", "found after", "named after", "named")
ROWS = 200
NOTE = "The controller knows encoders, motor currents, gyro and accelerometers only; it is told of no fault. "
SLIPS = "A wheel slips here from the slip on at which friction peaks."
SKIDS = "Its wheels slip to turn, which is no fault."


def _bases(source: Source) -> list[RobotSource]:
    """Those of which it was recorded whether their wheels slipped."""
    return [robot for robot in source.robots if robot.facts.kind == "base" and len(robot.recording.contacts.time)]


def _parts(source: Source) -> Sequence[Figures]:
    return [_section(robot, findings_of(robot.recording, robot.facts)) for robot in _bases(source)]


def _section(robot: RobotSource, found: BaseFindings) -> Figures:
    rows = [*map(_slip, found.slips), *map(_motor, found.dead)]
    rows += [(alarm.what, f"{alarm.start:.3f} s", "", "", f"until {alarm.end:.3f} s") for alarm in found.alarms]
    more = f" The first {ROWS} of {len(rows)} are shown." if len(rows) > ROWS else ""
    base = robot.facts.base
    note = NOTE + (SKIDS if base is not None and skids(base.wheels) else SLIPS)
    nothing = "" if rows else " Nothing happened, and nothing was said."
    title = robot.called("Faults, and what was found of them")
    return Figures(robot.key("faults"), title, [Table(HEAD, rows[:ROWS])] if rows else [], note + nothing + more)


def _slip(slip: SlipEpisode) -> tuple[str, ...]:
    return (
        f"{slip.wheel} slips, up to {slip.peak:.2f} m/s",
        f"{slip.start:.3f} s",
        _after(slip.delay) if slip.detectable or slip.delay is not None else "not detectable",
        _after(slip.naming_delay) if slip.delay is not None else "",
        " and ".join(slip.named) or ("ambiguous" if slip.detected is not None else ""),
    )


def _motor(motor: DeadMotor) -> tuple[str, ...]:
    late = None if motor.detected is None else motor.detected - motor.time
    return (
        broken(motor.wheel, motor.kind),
        f"{motor.time:.3f} s",
        _after(late) if motor.reached else "the run ended before",
        "",
        motor.wheel if motor.detected is not None else "",
    )


def _after(delay: float | None) -> str:
    return "never" if delay is None else f"{1e3 * delay:.0f} ms"


def _applies(source: Source) -> bool:
    return bool(_bases(source))


SECTION = Method("slip and dead motors of a base, and what was found", lambda _: Section(_applies, _parts), OWN)
