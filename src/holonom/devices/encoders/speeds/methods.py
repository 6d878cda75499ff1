"""The table of ways from an encoder to a speed."""

from __future__ import annotations

import math
from typing import Any

from holonom.devices._checks import require
from holonom.devices.encoders.speeds.m import MMethod
from holonom.devices.encoders.speeds.m_t import MTMethod
from holonom.devices.encoders.speeds.observer import ObserverMethod
from holonom.devices.encoders.speeds.pll import PllMethod
from holonom.devices.encoders.speeds.t import TMethod
from holonom.registry import Method, Table

__all__ = ["SPEED_METHODS", "equal_resolution_speed"]


def _itself(sheet: Any) -> Any:
    """Return the record: resolution, delay, params, start and step."""
    return sheet


_OHMAE = "Ohmae, Matsuda, Kamiyama, Tachikawa, IEEE Trans. Industrial Electronics 29(3), 1982"
_ZARCHAN = "Zarchan, Fundamentals of Kalman Filtering, fading-memory filters"

SPEED_METHODS = Table(
    "speed_methods",
    "way to a speed",
    "its record: `params`, `start(reading)`, compiled `step`, `resolution(speed)`, `delay(speed)`",
    {
        "m": Method("counts in an interval", _itself, _OHMAE, MMethod),
        "t": Method("time between two edges", _itself, _OHMAE, TMethod),
        "m_t": Method("whole edges in an interval over the time between them", _itself, _OHMAE, MTMethod),
        "pll": Method("a phase-locked loop follows the count", _itself, _ZARCHAN, PllMethod),
        "observer": Method("an observer follows angle, speed and load", _itself, _ZARCHAN, ObserverMethod),
    },
)


def equal_resolution_speed(counts_per_rev: int, interval: float, timer: float) -> float:
    """Speed (rad/s) at which M and T method are equally fine, `q sqrt(f_s / T_s)`: T below it, M above.

    Parameters
    ----------
    counts_per_rev : counts per turn after decoding.
    interval : of the M method, s.
    timer : frequency of the T method's timer, Hz.

    Raises
    ------
    ModelError
        A number that is not positive.
    """
    for name, value in (("counts_per_rev", counts_per_rev), ("interval", interval), ("timer", timer)):
        require("equal_resolution_speed", name, value, above=0.0)
    return 2.0 * math.pi / counts_per_rev * math.sqrt(timer / interval)
