"""The table of tables: every kind of method, and where its table lies."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from holonom.errors import UnknownName
from holonom.registry import Table, imported

__all__ = ["TABLES", "table_of"]

TABLES: Mapping[str, str] = MappingProxyType(
    {
        "controllers": "holonom.control.methods:CONTROLLERS",
        "base_controllers": "holonom.control.methods:BASE_CONTROLLERS",
        "regulators": "holonom.control.regulators.methods:REGULATORS",
        "servos": "holonom.control.servo.methods:SERVOS",
        "processes": "holonom.control.processes.process:PROCESSES",
        "rules": "holonom.control.processes.methods:RULES",
        "path_laws": "holonom.control.path_laws.methods:PATH_LAWS",
        "balance_laws": "holonom.control.balance.methods:BALANCE_LAWS",
        "slip_detectors": "holonom.mobile.methods:SLIP_DETECTORS",
        "localisers": "holonom.mobile.methods:LOCALISERS",
        "odometry_rules": "holonom.mobile.odometry:RULES",
        "planners": "holonom.mechanics.motion.methods:PLANNERS",
        "profiles": "holonom.mechanics.motion:PROFILES",
        "paths": "holonom.machine.base.paths:PATHS",
        "headings": "holonom.machine.base.paths:HEADINGS",
        "sensors": "holonom.sim.sensors:SENSORS",
        "devices": "holonom.devices.methods:DEVICES",
        "speed_methods": "holonom.devices.encoders.speeds.methods:SPEED_METHODS",
        "homings": "holonom.devices.encoders.homing.methods:HOMINGS",
        "frames": "holonom.devices.encoders.frames.methods:FRAMES",
        "motors": "holonom.devices.motors.catalogue:MOTORS",
        "plants": "holonom.sim.plants:PLANTS",
        "presets": "holonom.model.presets:PRESETS",
        "joint_kinds": "holonom.model.joint_kinds:JOINT_KINDS",
        "arrangements": "holonom.mobile.methods:ARRANGEMENTS",
        "report_sections": "holonom.app.report.section_table:REPORT_SECTIONS",
        "commands": "holonom.app.commands:COMMANDS",
        "arps_words": "holonom.lang.words.table:ARPS_WORDS",
    }
)
"""Kind to the import path of its table."""


def table_of(kind: str) -> Table:
    """Return the table of a kind.

    Raises
    ------
    UnknownName
    """
    if kind not in TABLES:
        raise UnknownName("kind of method", kind, TABLES)
    found: Table = imported(TABLES[kind])
    return found
