"""Section: lines over time of each arm: joints, their errors, motors."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.drawing.curves import Curve, joint_curves
from holonom.app.report.parts import CurveGroup
from holonom.app.report.section_table import Section
from holonom.app.report.source import RobotSource, Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]


def _parts(source: Source) -> Sequence[CurveGroup]:
    groups = [CurveGroup(_curves(robot), robot.key("curves"), robot.called("Curves")) for robot in _arms(source)]
    return [group for group in groups if group.curves]


def _arms(source: Source) -> list[RobotSource]:
    return [robot for robot in source.robots if robot.facts.kind == "arm" and robot.recording.tracks]


def _curves(robot: RobotSource) -> Sequence[Curve]:
    key = f"{robot.name}:" if robot.name else ""
    return joint_curves(robot.recording, robot.facts.kinds, key, ideal=robot.facts.ideal)


SECTION = Method("lines over time of an arm", lambda _: Section(lambda s: bool(_arms(s)), _parts), OWN)
