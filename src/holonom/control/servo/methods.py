"""Table of servos of an axis."""

from __future__ import annotations

from holonom.registry import Table

__all__ = ["SERVOS"]

_HERE = "holonom.control.servo.forms"

SERVOS = Table(
    "servos",
    "servo",
    "a `Servo`: its `design` gives gains of an axis, which `simulate_axis` takes, with their margins",
    {
        "three_loops": f"{_HERE}.three_loops:THREE_LOOPS",
        "two_loops": f"{_HERE}.two_loops:TWO_LOOPS",
        "one_loop": f"{_HERE}.one_loop:ONE_LOOP",
        "speed_pd": f"{_HERE}.speed_pd:SPEED_PD",
        "disturbance": f"{_HERE}.disturbance:DISTURBANCE",
        "notch": f"{_HERE}.notch:NOTCH",
        "load_side": f"{_HERE}.load_side:LOAD_SIDE",
        "backlash": f"{_HERE}.backlash:BACKLASH",
        "tachometer": f"{_HERE}.tachometer:TACHOMETER",
    },
)
