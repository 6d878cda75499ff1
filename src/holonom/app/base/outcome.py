"""What came of a run: how it ended, slip and dead motors, found or not, and how well the base kept to its path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.closed_loop import BaseLog
from holonom.mobile import SlipStatus
from holonom.sim import BaseFault, Floor

__all__ = [
    "DeadMotor",
    "FalseAlarm",
    "PathError",
    "Phase",
    "SlipEpisode",
    "dead_motors",
    "ending",
    "false_alarms",
    "path_error",
    "phases",
    "slip_episodes",
]

GAP = 0.05
"""Pauses (s) within one episode; and how long after an episode a word still counts for it."""
MEMORY = 0.1
"""How long ago (s) a wheel may have slipped for its name to be right."""
SOME = 0.5
"""Part of the slip at which friction peaks, from which on a wheel may rightly be named."""


@dataclass(frozen=True, slots=True)
class SlipEpisode:
    """A wheel that truly slipped from `start` to `end` (s), and what was said meanwhile.

    `detected` is when first a slip was found, `identified` when first this wheel was named (None: never); `named` are
    all wheels that were named, in order.
    """

    wheel: str
    start: float
    end: float
    peak: float
    detected: float | None
    identified: float | None
    named: tuple[str, ...]

    @property
    def delay(self) -> float | None:
        """From the first slip to its detection, s."""
        return None if self.detected is None else self.detected - self.start

    @property
    def naming_delay(self) -> float | None:
        """From the first slip to this wheel's name, s."""
        return None if self.identified is None else self.identified - self.start

    @property
    def right(self) -> bool:
        """Whether this wheel, and no other, was named."""
        return self.named == (self.wheel,)


@dataclass(frozen=True, slots=True)
class DeadMotor:
    """A motor that failed at `time` (s); when the controller found out; whether the run got so far."""

    wheel: str
    kind: str
    time: float
    detected: float | None
    reached: bool


@dataclass(frozen=True, slots=True)
class FalseAlarm:
    """Something said from `start` to `end` (s) that was not so."""

    what: str
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Phase:
    """A stretch of a run, s."""

    name: str
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class PathError:
    """Distance from the reference in a phase: rms and peak, m; peak of the heading error, rad.

    `believed` is the peak that the controller believes in: the rest is drift of its dead reckoning.
    """

    rms: float
    peak: float
    believed: float
    heading: float


def ending(log: BaseLog, time_limit: float) -> str | None:
    """Why a run did not get to the end of its path within its time (s), in words; None if it did."""
    end = float(log.time[-1])
    to_go = float(np.hypot(*(log.pose[-1] - log.reference_pose[-1])[:2]))
    if log.ended == "jammed":
        return f"stopped after {end:.1f} s and {100.0 * log.driven:.0f} % of the path: a wheel is jammed"
    if log.ended != "done":
        return f"stopped after {end:.1f} s and {100.0 * log.driven:.0f} % of the path, {1e3 * to_go:.0f} mm beside it"
    if end > time_limit:
        return f"path driven in {end:.1f} s; time_limit is {time_limit:g} s"
    return None


def slip_episodes(log: BaseLog, floor: Floor) -> list[SlipEpisode]:
    """Every stretch of time in which a wheel slipped beyond its grip, in order of their starts."""
    limit = floor.material.slip_at_peak  # beyond it friction falls: the wheel no longer grips
    gap = _samples(log, GAP)
    episodes = [
        _episode(log, number, first, last)
        for number in range(len(log.wheels))
        for first, last in _stretches(np.abs(log.slip[:, number]) > limit, gap)
    ]
    return sorted(episodes, key=lambda episode: episode.start)


def _episode(log: BaseLog, number: int, first: int, last: int) -> SlipEpisode:
    window = slice(first, min(last + _samples(log, GAP), len(log.time) - 1) + 1)
    time, named = log.time[window], log.named[window]
    firsts = sorted((int(named[:, k].argmax()), k) for k in range(len(log.wheels)) if named[:, k].any())
    return SlipEpisode(
        log.wheels[number],
        float(log.time[first]),
        float(log.time[last]),
        float(np.abs(log.slip[window, number]).max()),
        _first(time, np.asarray(log.status[window] != SlipStatus.NO_SLIP)),
        _first(time, named[:, number]),
        tuple(log.wheels[k] for _, k in firsts),
    )


def dead_motors(log: BaseLog, faults: Sequence[BaseFault]) -> list[DeadMotor]:
    """Every fault of a motor, and when the controller began to drive without it."""
    found = []
    for fault in faults:
        number = fault.wheel if isinstance(fault.wheel, int) else log.wheels.index(fault.wheel)
        detected = _first(log.time, log.dead[:, number] & (log.time >= fault.time))
        reached = fault.time <= float(log.time[-1])
        found.append(DeadMotor(log.wheels[number], fault.kind, fault.time, detected, reached))
    return found


def false_alarms(log: BaseLog, floor: Floor, faults: Sequence[BaseFault]) -> list[FalseAlarm]:
    """All that was said without cause: slip where no wheel slips, names of wheels that grip, deaths of live motors."""
    memory, gap = _samples(log, MEMORY), _samples(log, GAP)
    slipping = np.abs(log.slip) > SOME * floor.material.slip_at_peak
    lately = np.stack([_held(column, memory) for column in slipping.T], axis=1)
    said = np.asarray(log.status != SlipStatus.NO_SLIP) & ~log.named.any(axis=1) & ~lately.any(axis=1)
    wrong = [("slip found, no wheel slips", said)]
    for number, name in enumerate(log.wheels):
        wrong.append((f"{name} named, it grips", log.named[:, number] & ~lately[:, number]))
        broken = min((f.time for f in faults if f.wheel in (number, name)), default=np.inf)
        wrong.append((f"motor of {name} given up, it works", log.dead[:, number] & (log.time < broken)))
    alarms = [
        FalseAlarm(what, float(log.time[a]), float(log.time[b])) for what, on in wrong for a, b in _stretches(on, gap)
    ]
    return sorted(alarms, key=lambda alarm: alarm.start)


def phases(log: BaseLog, slips: Sequence[SlipEpisode], faults: Sequence[BaseFault]) -> list[Phase]:
    """The whole run, before anything happened, while wheels slipped and half a second on, and after each fault."""
    end = float(log.time[-1])
    reached = [fault for fault in faults if fault.time < end]
    changes = sorted({fault.time for fault in reached})
    first = min([*changes, *(slip.start for slip in slips), end])
    found = [Phase("whole run", 0.0, end), Phase("before the first fault", 0.0, first)]
    found += [Phase(f"{slip.wheel} slips", slip.start, min(slip.end + 0.5, end)) for slip in slips]
    for fault in reached:
        until = min([t for t in changes if t > fault.time], default=end)
        found.append(Phase(f"{fault.wheel}: motor {fault.kind}", fault.time, until))
    return found


def path_error(log: BaseLog, phase: Phase) -> PathError | None:
    """The path error in a phase, which may be one of another log; None where this one has no sample in it."""
    within = (log.time >= phase.start) & (log.time <= phase.end)
    if not within.any():
        return None
    error = log.path_error[within]
    believed = np.hypot(*(log.estimated_pose - log.reference_pose)[within, :2].T)
    heading = float(np.abs(log.heading_error[within]).max())
    return PathError(float(np.sqrt(np.mean(error**2))), float(error.max()), float(believed.max()), heading)


def _first(time: NDArray[np.float64], on: NDArray[np.bool_]) -> float | None:
    return float(time[on.argmax()]) if on.any() else None


def _held(on: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """True for `count` samples after each True too."""
    last = np.maximum.accumulate(np.where(on, np.arange(len(on)), -count - 1))
    held: NDArray[np.bool_] = np.arange(len(on)) - last <= count
    return held


def _stretches(on: NDArray[np.bool_], gap: int) -> list[tuple[int, int]]:
    """First and last index of each run of True; runs less than `gap` apart are one."""
    at = np.flatnonzero(on)
    if not len(at):
        return []
    breaks = np.flatnonzero(np.diff(at) > gap)
    firsts = at[np.concatenate([[0], breaks + 1])]
    lasts = at[np.concatenate([breaks, [len(at) - 1]])]
    return [(int(a), int(b)) for a, b in zip(firsts, lasts, strict=True)]


def _samples(log: BaseLog, seconds: float) -> int:
    return round(seconds / float(log.time[1] - log.time[0]))
