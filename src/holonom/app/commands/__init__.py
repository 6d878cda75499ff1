"""The commands: one file each, with its options, its one line of help and `run(options) -> Answer`; one line here.

A command of two words is `group subject`. A module is imported when its command is used, so it imports what is heavy
in `run`.
"""

from __future__ import annotations

from holonom.registry import Table

__all__ = ["COMMANDS"]

COMMANDS = Table(
    "commands",
    "command",
    "an `Answer`; `params` are its options",
    {
        "demo": "holonom.app.commands.demo:COMMAND",
        "new": "holonom.app.commands.new:COMMAND",
        "run": "holonom.app.commands.run:COMMAND",
        "check": "holonom.app.commands.check:COMMAND",
        "report": "holonom.app.commands.report:COMMAND",
        "calibrate dynamics": "holonom.app.commands.calibrate.dynamics:COMMAND",
        "calibrate drive": "holonom.app.commands.calibrate.drive:COMMAND",
        "calibrate odometry": "holonom.app.commands.calibrate.odometry:COMMAND",
        "calibrate process": "holonom.app.commands.calibrate.process:COMMAND",
        "tune": "holonom.app.commands.tune:COMMAND",
        "select": "holonom.app.commands.select:COMMAND",
        "methods": "holonom.app.commands.methods:COMMAND",
        "bench": "holonom.app.commands.bench:COMMAND",
        "bench drive": "holonom.app.commands.bench_drive:COMMAND",
        "doctor": "holonom.app.commands.doctor:COMMAND",
    },
)
