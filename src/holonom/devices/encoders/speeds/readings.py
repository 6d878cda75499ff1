"""What the hardware latches at a sample: the count, and when its last edges came."""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.trace.code.loops import loop

__all__ = ["CaptureParams", "EdgeReading", "capture_edges", "capture_params", "first_reading"]


class CaptureParams(NamedTuple):
    """Counts per radian; counts per captured edge (a divider before the timer) and its angle, rad."""

    counts_per_rad: float
    divider: int
    edge_angle: float


class EdgeReading(NamedTuple):
    """What is latched at a sample.

    The count; of the last captured edge: its place (a whole number of edge angles), timer ticks when it came, ticks
    since the one before it (0: unknown, or it turned back), direction (0: there was none); ticks now.
    """

    counts: int
    edge: int
    stamp: int
    period: int
    direction: int
    now: int


def capture_params(counts_per_rev: int, edges: int = 1) -> CaptureParams:
    """Params of `capture_edges`: every `edges`-th count stops the timer.

    Raises
    ------
    ModelError
        Fewer than one count per turn or edge.
    """
    require("capture_params", "counts_per_rev", counts_per_rev, least=1)
    require("capture_params", "edges", edges, least=1)
    return CaptureParams(counts_per_rev / (2.0 * math.pi), edges, 2.0 * math.pi * edges / counts_per_rev)


@loop
def first_reading(params: CaptureParams, angle: float, now: int) -> EdgeReading:
    """Reading at power-on, at an angle of the shaft (rad): no edge yet."""
    count = math.floor(angle * params.counts_per_rad)
    return EdgeReading(count, count // params.divider, now, 0, 0, now)


@loop
def capture_edges(params: CaptureParams, last: EdgeReading, before: float, after: float, now: int) -> EdgeReading:
    """Reading after the shaft went from an angle to another (rad) between the last reading's time and `now` (ticks).

    Within the step the shaft turns evenly, so that every edge has its time, down to a tick.
    """
    count, divider = math.floor(after * params.counts_per_rad), params.divider
    first, final = last.counts // divider, count // divider
    if first == final:
        return EdgeReading(count, last.edge, last.stamp, last.period, last.direction, now)
    direction = 1 if final > first else -1
    edge = final if direction == 1 else final + 1
    per_angle = (now - last.now) / (after - before)
    stamp = last.now + math.floor(per_angle * (edge * params.edge_angle - before))
    period = 0
    if abs(final - first) > 1:
        earlier = (edge - direction) * params.edge_angle
        period = stamp - (last.now + math.floor(per_angle * (earlier - before)))
    elif direction == last.direction:
        period = stamp - last.stamp
    return EdgeReading(count, edge, stamp, period, direction, now)
