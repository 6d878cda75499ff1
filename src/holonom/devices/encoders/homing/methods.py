"""The table of ways to find the zero of a counter."""

from __future__ import annotations

from typing import Any

from holonom.devices.encoders.homing.potentiometer import PotentiometerHoming
from holonom.devices.encoders.homing.switch import SwitchHoming
from holonom.registry import OWN, Method, Table

__all__ = ["HOMINGS"]


def _itself(sheet: Any) -> Any:
    """Return the record: its `params(dt)` are those of the compiled step."""
    return sheet


_HERE = f"{OWN}; specification 03.3"

HOMINGS = Table(
    "homings",
    "way to find the zero",
    "its record, whose `params(dt)` are those of its compiled step",
    {
        "potentiometer_index": Method(
            "a potentiometer tells the turn, the next index the rest", _itself, _HERE, PotentiometerHoming
        ),
        "switch_index": Method("onto a switch, off it, on to the next index", _itself, _HERE, SwitchHoming),
    },
)
