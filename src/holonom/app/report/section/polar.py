"""Section: what a base's motors and floor can give, by direction, with all motors and without those that failed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holonom.app.report.drawing.figures import Figures
from holonom.app.report.drawing.polar import Polar, PolarLine
from holonom.app.report.findings.base_findings import findings_of
from holonom.app.report.findings.base_outline import base_of
from holonom.app.report.findings.facts import BaseFacts
from holonom.app.report.section_table import Section
from holonom.app.report.source import RobotSource, Source
from holonom.arrays import Array
from holonom.errors import InputError
from holonom.mobile import WheelBase, acceleration_envelope, drive_limits, effective_motors, speed_envelope
from holonom.mobile.drive.failed_motor import motors_hold_all
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

INTACT, DEAD = "#0b7285", "#d9480f"
_LEFT_OUT = (
    "Without {} its motors cannot hold path and heading at once: they push it without a turn along one line at most, "
    "which no figure by direction can show, so none is drawn."
)
NOTE = "By direction of travel in the robot frame, without turning: what motors and floor can give."


def _parts(source: Source) -> Sequence[Figures]:
    return [found for robot in source.robots if (found := _section(robot)) is not None]


def _section(robot: RobotSource) -> Figures | None:
    """None for what is no base, and for one that these plots are not defined for."""
    facts, base = robot.facts.base, base_of(robot.facts)
    if facts is None or base is None or facts.mass is None:
        return None
    dead = [motor.wheel for motor in findings_of(robot.recording, robot.facts).dead if motor.reached]
    try:
        if np.linalg.matrix_rank(base.velocity_coupling, tol=1e-9) < 3:  # it cannot drive in all directions
            return None
        lame = _lame(base, dead)
        figures = _figures(base, facts, () if lame else dead)
    except InputError:  # steered wheels have no constant coupling
        return None
    note = f"{NOTE} {_LEFT_OUT.format(' and '.join(dead))}" if lame else NOTE
    return Figures(robot.key("polar"), robot.called("What the drive can do"), figures, note)


def _lame(base: WheelBase, dead: Sequence[str]) -> bool:
    """Whether the motors that are left push the base in hardly any direction without turning it."""
    return not motors_hold_all(base, sum(1 << base.driven.index(wheel) for wheel in dead))


def _figures(base: WheelBase, facts: BaseFacts, dead: Sequence[str]) -> list[Polar]:
    directions = np.linspace(0.0, 2.0 * np.pi, 181)
    limits = drive_limits(base, facts.motor, facts.gear, facts.friction)
    gone = [base.driven.index(wheel) for wheel in dead]

    def values(out: Sequence[int]) -> tuple[Array, Array, Array]:
        return (
            effective_motors(base, directions, out=out),
            acceleration_envelope(base, directions, limits, out=out).value,
            speed_envelope(base, directions, limits, out=out).value,
        )

    titles = (("effective motors", ""), ("largest acceleration", "m/s²"), ("largest speed", "m/s"))
    lines = [("all motors", values(()), INTACT)]
    if gone:
        lines.append((f"without {' and '.join(dead)}", values(gone), DEAD))
    return [
        Polar(title, unit, [PolarLine(name, directions, curve[k], colour) for name, curve, colour in lines])
        for k, (title, unit) in enumerate(titles)
    ]


def _applies(source: Source) -> bool:
    return any(robot.facts.base is not None for robot in source.robots)


SECTION = Method("what a base's drives can give, by direction", lambda _: Section(_applies, _parts), OWN)
