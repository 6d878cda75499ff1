"""What came of a run: slip and dead motors, found or not, and how well the base kept to its path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.mobile import SlipStatus
from holonom.sim import BaseFault, BaseLog, Floor

__all__ = ["DeadMotor", "PathError", "SlipEpisode", "dead_motors", "path_errors", "slip_episodes"]

GAP = 0.05
"""Pauses (s) within one episode of slip."""


@dataclass(frozen=True, slots=True)
class SlipEpisode:
    """A wheel that truly slipped from `start` to `end` (s); what was said of it: when first, and of which wheels.

    `named` is empty where it was ambiguous; `detected` None where nothing was said.
    """

    wheel: str
    start: float
    end: float
    peak: float
    detected: float | None
    named: tuple[str, ...]

    @property
    def delay(self) -> float | None:
        """From the first slip to the first word, s."""
        return None if self.detected is None else self.detected - self.start

    @property
    def right(self) -> bool:
        """Whether this wheel, and no other, was named."""
        return self.named == (self.wheel,)


@dataclass(frozen=True, slots=True)
class DeadMotor:
    """A motor that failed at `time` (s), and when the controller found out; None: it did not."""

    wheel: str
    kind: str
    time: float
    detected: float | None


@dataclass(frozen=True, slots=True)
class PathError:
    """Distance from the reference between two times (s): rms and peak, m; peak of the heading error, rad.

    `believed` is the peak that the controller believes in: the rest is drift of its dead reckoning.
    """

    phase: str
    start: float
    end: float
    rms: float
    peak: float
    believed: float
    heading: float


def slip_episodes(log: BaseLog, floor: Floor) -> list[SlipEpisode]:
    """Every stretch of time in which a wheel slipped beyond its grip, in order of their starts."""
    limit = floor.material.slip_at_peak  # beyond it friction falls: the wheel no longer grips
    episodes = []
    for number, name in enumerate(log.wheels):
        for first, last in _stretches(np.abs(log.slip[:, number]) > limit, round(GAP / _dt(log))):
            episodes.append(_episode(log, number, name, first, last))
    return sorted(episodes, key=lambda episode: episode.start)


def _episode(log: BaseLog, number: int, name: str, first: int, last: int) -> SlipEpisode:
    """What the detector said while the wheel slipped, or up to 50 ms later."""
    until = min(last + round(GAP / _dt(log)), len(log.time) - 1)
    window = slice(first, until + 1)
    told = np.flatnonzero(log.status[window] != SlipStatus.NO_SLIP)
    sets = [tuple(n for n, flag in zip(log.wheels, row, strict=True) if flag) for row in log.named[window] if row.any()]
    return SlipEpisode(
        name,
        float(log.time[first]),
        float(log.time[last]),
        float(np.abs(log.slip[window, number]).max()),
        float(log.time[first + told[0]]) if len(told) else None,
        sets[0] if sets else (),
    )


def dead_motors(log: BaseLog, faults: Sequence[BaseFault]) -> list[DeadMotor]:
    """Every fault of a motor, and when the controller began to drive without it."""
    found = []
    for fault in faults:
        number = fault.wheel if isinstance(fault.wheel, int) else log.wheels.index(fault.wheel)
        seen = np.flatnonzero(log.dead[:, number] & (log.time >= fault.time))
        detected = float(log.time[seen[0]]) if len(seen) else None
        found.append(DeadMotor(log.wheels[number], fault.kind, fault.time, detected))
    return found


def path_errors(log: BaseLog, slips: Sequence[SlipEpisode], faults: Sequence[BaseFault]) -> list[PathError]:
    """The path error over the whole run, before anything happened, while wheels slipped, and after each fault."""
    end = float(log.time[-1])
    changes = sorted({fault.time for fault in faults if fault.time < end})
    first = min([*changes, *(slip.start for slip in slips), end])
    phases = [("whole run", 0.0, end), ("before the first fault", 0.0, first)]
    phases += [(f"{slip.wheel} slips", slip.start, slip.end + 0.5) for slip in slips]
    phases += [
        (f"{fault.wheel}: motor {fault.kind}", fault.time, min([t for t in changes if t > fault.time], default=end))
        for fault in faults
        if fault.time < end
    ]
    return [_path_error(log, *phase) for phase in phases]


def _path_error(log: BaseLog, phase: str, start: float, end: float) -> PathError:
    within = (log.time >= start) & (log.time <= end)
    error = log.path_error[within]
    believed = np.hypot(*(log.estimated_pose - log.reference_pose)[within, :2].T)
    heading = float(np.abs(log.heading_error[within]).max())
    rms, peak = float(np.sqrt(np.mean(error**2))), float(error.max())
    return PathError(phase, start, end, rms, peak, float(believed.max()), heading)


def _stretches(on: NDArray[np.bool_], gap: int) -> list[tuple[int, int]]:
    """First and last index of each run of True; runs less than `gap` apart are one."""
    at = np.flatnonzero(on)
    if not len(at):
        return []
    breaks = np.flatnonzero(np.diff(at) > gap)
    firsts = at[np.concatenate([[0], breaks + 1])]
    lasts = at[np.concatenate([breaks, [len(at) - 1]])]
    return [(int(a), int(b)) for a, b in zip(firsts, lasts, strict=True)]


def _dt(log: BaseLog) -> float:
    return float(log.time[1] - log.time[0])
