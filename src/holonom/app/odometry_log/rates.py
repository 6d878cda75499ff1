"""Time in seconds whatever its stamps count, and wheels and truth of two rates on the times of the wheels."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from holonom.app.odometry_log.table import Table
from holonom.errors import LogError

__all__ = ["in_seconds", "on_one_rate"]

UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
STAMPS = (("ns", 1e17), ("us", 1e14), ("ms", 1e11))
"""Sizes from which on a stamp counts so small units since 1970: a second later would be after the year 5000."""
LONG_AGO = 1e6  # s: times beyond it are stamps, and the run begins at 0


def in_seconds(table: Table, unit: str | None) -> Table:
    """The table with its column `time` in s; of stamps since long ago it begins at 0."""
    time = table.column("time")
    named = unit or next((name for name, least in STAMPS if abs(time[0]) >= least), "s")
    if abs(time[0]) * UNITS[named] > LONG_AGO:
        time = time - time[0]
    return _with(table, "time", time * UNITS[named])


def on_one_rate(table: Table, wheels: Sequence[str], truth: Sequence[str]) -> Table:
    """Rows in which the wheels were sampled; the truth, where it was at other times, interpolated to them.

    Raises
    ------
    LogError
        Fewer than two rows with wheels, or with a truth beside them.
    """
    if not np.isnan(table.values).any():
        return table
    has = {name: ~np.isnan(table.column(name)) for name in table.names}
    rolls = np.all([has[name] for name in wheels], axis=0)
    found, keep = table, rolls.copy()
    if truth[0] in table.names:
        seen = np.all([has[name] for name in truth], axis=0)
        time = table.column("time")
        if seen.sum() < 2:
            raise LogError(f"{table.path}: {seen.sum()} rows with {', '.join(truth)}; two or more are expected")
        keep &= (time >= time[seen][0]) & (time <= time[seen][-1])
        for name in truth:
            values = table.column(name)[seen]
            values = np.unwrap(values, period=_period(values)) if name == "theta" else values
            found = _with(found, name, np.interp(time, time[seen], values))
    if keep.sum() < 2:
        raise LogError(f"{table.path}: {keep.sum()} rows with {', '.join(wheels)}; two or more are expected")
    return dataclasses.replace(
        found, values=found.values[keep], lines=[line for line, kept in zip(found.lines, keep, strict=True) if kept]
    )


def _period(heading: np.ndarray) -> float:
    """A turn in the unit of a heading: 360 where it is beyond what rad that wrap could be."""
    return 360.0 if np.abs(np.diff(heading)).max(initial=0.0) > 2.0 * np.pi + 1e-6 else 2.0 * np.pi


def _with(table: Table, name: str, values: np.ndarray) -> Table:
    changed = table.values.copy()
    changed[:, table.names.index(name)] = values
    return dataclasses.replace(table, values=changed)
