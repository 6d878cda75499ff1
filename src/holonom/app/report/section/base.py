"""Section: what a base stands on: its wheels, its support polygon and its centre of mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holonom.app.report.drawing.figures import Figures, Table
from holonom.app.report.drawing.robot_map import MapRobot
from holonom.app.report.drawing.topview import TopView
from holonom.app.report.findings.base_outline import base_of, margin_of, outline_of
from holonom.app.report.section_table import Section
from holonom.app.report.source import RobotSource, Source
from holonom.mobile import WheelBase
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

HEAD = ("wheel", "kind", "x", "y", "rolls along", "radius", "driven")
WIDTH = 460.0


def _parts(source: Source) -> Sequence[Figures]:
    known = [(robot, base_of(robot.facts)) for robot in source.robots]
    return [_section(robot, base) for robot, base in known if base is not None]


def _section(robot: RobotSource, base: WheelBase) -> Figures:
    drawn = MapRobot(outline_of(base), np.zeros(3), named=True)
    map_ = TopView("in base_link, x forwards, at rest", (), robots=[drawn], width=WIDTH)
    return Figures(robot.key("base"), robot.called("Wheels"), [map_, Table(HEAD, _rows(base))], _note(base))


def _rows(base: WheelBase) -> list[tuple[str, ...]]:
    return [
        (
            wheel.name, wheel.kind, f"{1e3 * wheel.x:.0f} mm", f"{1e3 * wheel.y:.0f} mm",
            f"{180.0 - (180.0 - np.degrees(wheel.heading)) % 360.0:.0f}°", f"{1e3 * wheel.radius:.0f} mm",
            "yes" if wheel.driven else "no",
        )
        for wheel in base.wheels
    ]  # fmt: skip


def _note(base: WheelBase) -> str:
    margin = margin_of(base)
    if margin is None:
        return "Its wheels span no area: it has to balance."
    if base.mass is None:
        return "Nothing is known of its mass."
    where = f"{1e3 * abs(margin):.0f} mm {'within' if margin >= 0.0 else 'outside'} the support polygon"
    return f"{base.mass:g} kg; the centre of mass lies {where}."


def _applies(source: Source) -> bool:
    return any(robot.facts.base is not None for robot in source.robots)


SECTION = Method("wheels, support polygon and centre of mass of a base", lambda _: Section(_applies, _parts), OWN)
