"""How a run ended, as the badge at the head of the page says it, and what came of a robot in a few numbers."""

from __future__ import annotations

import numpy as np

from holonom.app.report.findings.base_findings import Phase, findings_of, motion_of, path_error
from holonom.app.report.findings.peaks import peaks_of
from holonom.app.report.sections import Outcome
from holonom.app.report.source import RobotSource, Source
from holonom.model.joint_kinds import kind_of

__all__ = ["badge_of", "headline_of"]

TONES = {"done": "ok", "paused": "held", "stopped": "held", "unknown": "unsaid"}
"""Badges of endings; of any other, such as a fault, a time limit or a recording that was cut off, it is red."""


def badge_of(source: Source) -> Outcome:
    """The badge: why the run ended; of a base that is alone and did as told, how far off it was at most."""
    ending, text = source.ending, source.ending.reason or source.ending.status
    motion = motion_of(source.robots[0].recording) if source.alone else None
    if ending.status == "done" and motion is not None and len(motion.time):
        text += f", at most {1e3 * motion.error.max():.0f} mm off"
    return Outcome(ending.status == "done", text, TONES.get(ending.status, "bad"))


def headline_of(robot: RobotSource) -> dict[str, str]:
    """Labels and values, units included."""
    return _of_arm(robot) if robot.facts.kind == "arm" else _of_base(robot)


def _of_arm(robot: RobotSource) -> dict[str, str]:
    facts = {"Controller": robot.facts.controller.replace("_", " ")} if robot.facts.controller else {}
    error = peaks_of(robot)["error"]
    turning = np.array([kind_of(kind).turns for kind in robot.facts.kinds], dtype=bool)
    if len(error) and np.isfinite(error[turning]).any():
        facts["Largest joint error"] = f"{np.degrees(np.nanmax(error[turning])):.3f} deg"
    return facts


def _of_base(robot: RobotSource) -> dict[str, str]:
    found = findings_of(robot.recording, robot.facts)
    facts = {}
    if "path_driven" in robot.numbers:
        facts["Path driven"] = f"{100.0 * robot.numbers['path_driven']:.0f} %"
    whole = path_error(motion_of(robot.recording), Phase("whole run", 0.0, np.inf))
    if whole is not None:
        facts["Path error, rms"] = f"{1e3 * whole.rms:.1f} mm"
        base = robot.facts.base
        if base is not None and base.position_tolerance is not None:
            allowed = f"{1e3 * base.position_tolerance:.0f} mm allowed"
            facts[f"Largest path error, {allowed}"] = f"{1e3 * whole.peak:.0f} mm"
        if base is not None and base.heading_tolerance is not None:
            allowed = f"{np.degrees(base.heading_tolerance):g} deg allowed"
            facts[f"Largest heading error, {allowed}"] = f"{np.degrees(whole.heading):.1f} deg"
    if found.slips:
        facts["Slips with the right name"] = f"{sum(slip.right for slip in found.slips)} of {len(found.slips)}"
    delays = [slip.naming_delay for slip in found.slips if slip.naming_delay is not None]
    if delays:
        facts["Slipping wheel named after"] = f"at most {1e3 * max(delays):.0f} ms"
    for motor in found.dead:
        if motor.detected is not None:
            facts["Dead motor found after" if motor.kind == "dead" else "Fault found after"] = (
                f"{1e3 * (motor.detected - motor.time):.0f} ms"
            )
    return facts
