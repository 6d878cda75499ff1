"""What came of a base's run, by its recording: slip and dead motors, found or not, and how well it kept to its path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from holonom.app.recording import BaseTrack, Recording
from holonom.app.report.findings.base_outline import base_of
from holonom.app.report.findings.base_words import (
    SlipVerdicts,
    Spell,
    dead_since,
    faults_of,
    gripping_again,
    phase_of,
    verdicts_of,
)
from holonom.app.report.findings.facts import FaultFacts, RobotFacts
from holonom.arrays import Array
from holonom.mobile.base.drivable import skids
from holonom.mobile.drive.slip import detectable

__all__ = [
    "BaseFindings",
    "DeadMotor",
    "FalseAlarm",
    "PathError",
    "Phase",
    "SlipEpisode",
    "findings_of",
    "motion_of",
    "path_error",
]

Mask = NDArray[np.bool_]
GAP = 0.05
"""Pauses (s) within one episode; and how long after an episode a word still counts for it."""
MEMORY = 0.1
"""How long ago (s) a wheel may have slipped for its name to be right."""
PAUSE = 0.2
"""Silences of the detector (s) that its events pass over."""
SOME = 0.5
"""Part of the slip at which friction peaks, from which on a wheel may rightly be named."""
AFTER = 0.5
"""How long (s) a slip's phase goes on behind it."""
SLIP_AT_PEAK = 0.05
"""Slip (m/s) at which friction peaks, where a recording does not tell it."""


@dataclass(frozen=True, slots=True)
class SlipEpisode:
    """A wheel that truly slipped from `start` to `end` (s), and what was said meanwhile.

    `detected` is when first a slip was found, `identified` when first this wheel was named (None: never); `named` are
    all wheels that were named, in order. `detectable` says whether this base's wheels can show slip at all.
    """

    wheel: str
    start: float
    end: float
    peak: float
    detected: float | None
    identified: float | None
    named: tuple[str, ...]
    detectable: bool = True

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


@dataclass(frozen=True, slots=True)
class Motion:
    """Where a base was, should have been and believed to be, (N, 3) each, at the same times (N,)."""

    time: Array
    true: Array
    reference: Array
    believed: Array

    @property
    def error(self) -> Array:
        """Distance (N,) of the true place from the reference, m."""
        error: Array = np.hypot(*(self.true - self.reference)[:, :2].T)
        return error


@dataclass(frozen=True, slots=True)
class BaseFindings:
    """All of it."""

    slips: tuple[SlipEpisode, ...]
    dead: tuple[DeadMotor, ...]
    alarms: tuple[FalseAlarm, ...]
    phases: tuple[Phase, ...]


def findings_of(recording: Recording, facts: RobotFacts) -> BaseFindings:
    """Look through a base's recording: its events, and where they do not tell it the wheels' true slip."""
    limit = facts.base.slip_at_peak if facts.base is not None else SLIP_AT_PEAK
    base = base_of(facts)
    verdicts = verdicts_of(recording.events, recording.end())
    slips_to_turn = base is not None and skids(base.wheels)  # which is no fault
    slips = [] if slips_to_turn else _episodes(recording, verdicts, limit, detectable=_detectable(facts))
    told = facts.base.faults if facts.base is not None else ()
    faults = faults_of(recording.events, told)
    lost = dead_since(recording.events)
    dead = tuple(DeadMotor(f.wheel, f.kind, f.time, _from(lost, f), f.time <= recording.end()) for f in faults)
    alarms = _alarms(recording, verdicts, limit)
    alarms += [
        FalseAlarm(f"motor of {wheel} given up, it works", time, recording.end())
        for wheel, time in lost.items()
        if not any(fault.wheel == wheel and fault.time <= time for fault in faults)
    ]
    return BaseFindings(
        tuple(slips), dead, tuple(sorted(alarms, key=lambda alarm: alarm.start)), _phases(recording, slips, faults)
    )


def motion_of(recording: Recording) -> Motion | None:
    """The base's motion; None where no truth, or no reference, was recorded. What nobody believed is the truth."""
    true, wanted = _true(recording), recording.base_reference
    if true is None or not len(wanted.time):
        return None
    believed = recording.base if len(recording.base.time) else BaseTrack(*true, true[1], np.empty(0))
    return Motion(true[0], true[1], _at(true[0], wanted.time, wanted.pose), _at(true[0], believed.time, believed.pose))


def path_error(motion: Motion | None, phase: Phase) -> PathError | None:
    """The path error in a phase, which may be one of another run; None where this one has no sample in it."""
    if motion is None:
        return None
    within = (motion.time >= phase.start) & (motion.time <= phase.end)
    if not within.any():
        return None
    true, reference = motion.true[within], motion.reference[within]
    error = np.hypot(*(true - reference)[:, :2].T)
    believed = np.hypot(*(motion.believed[within] - reference)[:, :2].T)
    turn = (true - reference)[:, 2]
    heading = np.abs((turn + np.pi) % (2.0 * np.pi) - np.pi)
    return PathError(float(np.sqrt(np.mean(error**2))), float(error.max()), float(believed.max()), float(heading.max()))


def _true(recording: Recording) -> tuple[Array, Array] | None:
    """Times and true poses (N, 3); of old recordings by the frame of the base."""
    if len(recording.true_base.time):
        return recording.true_base.time, recording.true_base.pose
    frame = recording.frames.get("base_link")
    if frame is None:
        return None
    turned = 2.0 * np.arctan2(frame.quaternion[:, 2], frame.quaternion[:, 3])
    return frame.time, np.column_stack([frame.position[:, :2], turned])


def _at(time: Array, known: Array, poses: Array) -> Array:
    columns = [poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])]
    return np.stack([np.interp(time, known, column) for column in columns], axis=1)


def _detectable(facts: RobotFacts) -> bool:
    """Whether the wheels of a base can contradict each other; taken for so where nothing is known of them."""
    base = base_of(facts)
    return base is None or bool(base.steered) or detectable(base)


def _episodes(recording: Recording, verdicts: SlipVerdicts, limit: float, *, detectable: bool) -> list[SlipEpisode]:
    """Every stretch of time in which a wheel slipped beyond its grip, in order of their starts."""
    track = recording.contacts
    told = gripping_again(recording.events, recording.end())
    found = []
    for number, wheel in enumerate(recording.joint_names):
        slip = np.abs(track.slip[:, number]) if len(track.time) else np.empty(0)
        spells = _joined(told[wheel]) if wheel in told else [] if told else _stretches(track.time, slip > limit)
        found += [_episode(wheel, spell, track.time, slip, verdicts) for spell in spells]
    found = [replace(episode, detectable=detectable) for episode in found]
    return sorted(found, key=lambda episode: episode.start)


def _episode(wheel: str, spell: Spell, time: Array, slip: Array, verdicts: SlipVerdicts) -> SlipEpisode:
    until = spell.end + GAP
    seen = slip[(time >= spell.start) & (time <= until)]
    begins: Mapping[str, float] = verdicts.named_within(spell.start, until)
    return SlipEpisode(
        wheel=wheel,
        start=spell.start,
        end=spell.end,
        peak=max(spell.peak, float(seen.max()) if len(seen) else 0.0),
        detected=verdicts.found_within(spell.start, until),
        identified=begins.get(wheel),
        named=tuple(sorted(begins, key=lambda name: begins[name])),
    )


def _from(lost: Mapping[str, float], fault: FaultFacts) -> float | None:
    time = lost.get(fault.wheel)
    return time if time is not None and time >= fault.time else None


def _alarms(recording: Recording, verdicts: SlipVerdicts, limit: float) -> list[FalseAlarm]:
    """Words without cause: slip where no wheel slips, names of wheels that grip."""
    track = recording.contacts
    if not len(track.time):
        return []
    some = np.abs(track.slip) > SOME * limit
    any_wheel = track.time[some.any(axis=1)]
    alarms = [
        FalseAlarm("slip found, no wheel slips", spell.start, spell.end)
        for spell in verdicts.ambiguous
        if _wrong(spell, any_wheel)
    ]
    for number, wheel in enumerate(recording.joint_names):
        own = track.time[some[:, number]]
        alarms += [
            FalseAlarm(f"{wheel} named, it grips", spell.start, spell.end)
            for spell in _joined(verdicts.named.get(wheel, ()), 0.0)
            if _wrong(spell, own)
        ]
    return alarms


def _wrong(spell: Spell, slipping: Array) -> bool:
    """Whether something is said that was not so when it was first said, or goes on being said long after.

    `slipping` are the times of samples in which it was so; between two samples it may have been, too.
    """

    def lately(time: float, memory: float) -> bool:
        k = int(np.searchsorted(slipping, time + MEMORY / 10.0, side="right"))
        return k > 0 and time - float(slipping[k - 1]) <= memory

    return not lately(spell.start, MEMORY) or not lately(spell.end, MEMORY + PAUSE)


def _phases(recording: Recording, slips: Sequence[SlipEpisode], faults: Sequence[FaultFacts]) -> tuple[Phase, ...]:
    """The whole run, before anything happened, while wheels slipped and half a second on, and after each fault."""
    end = recording.end()
    reached = [fault for fault in faults if fault.time < end]
    changes = sorted({fault.time for fault in reached})
    first = min([*changes, *(slip.start for slip in slips), end])
    found = [Phase("whole run", 0.0, end)]
    if first < end:
        found.append(Phase("before the first fault", 0.0, first))
    found += [Phase(f"{slip.wheel} slips", slip.start, min(slip.end + AFTER, end)) for slip in slips]
    for fault in reached:
        until = min([t for t in changes if t > fault.time], default=end)
        found.append(Phase(phase_of(fault.wheel, fault.kind), fault.time, until))
    return tuple(found)


def _stretches(time: Array, on: Mask) -> list[Spell]:
    """Runs of True."""
    at = np.flatnonzero(on)
    if not len(at):
        return []
    breaks = np.flatnonzero(np.diff(at) > 1)
    firsts, lasts = at[np.concatenate([[0], breaks + 1])], at[np.concatenate([breaks, [len(at) - 1]])]
    return _joined([Spell(float(time[a]), float(time[b])) for a, b in zip(firsts, lasts, strict=True)])


def _joined(spells: Sequence[Spell], gap: float = GAP) -> list[Spell]:
    """Spells with no longer pause than a gap taken as one."""
    found: list[Spell] = []
    for spell in spells:
        if found and spell.start - found[-1].end <= gap:
            found[-1] = Spell(found[-1].start, spell.end, max(found[-1].peak, spell.peak))
        else:
            found.append(spell)
    return found
