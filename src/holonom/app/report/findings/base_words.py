"""What the events of a base's recording say: when wheels slipped and were said to, which motors failed."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from holonom.app.report.findings.facts import FaultFacts
from holonom.signals import Event

__all__ = ["SlipVerdicts", "Spell", "broken", "dead_since", "faults_of", "gripping_again", "phase_of", "verdicts_of"]

TRUTH, PLANT, DETECTOR, WATCH = "truth", "plant", "slip detection", "motor watch"
"""Sources of events."""
NOW = re.compile(r"(?P<wheel>.+) (?P<what>slips|grips)(?:, it slipped at up to (?P<peak>[\d.]+) m/s)?$")
NAMED = re.compile(r"(?P<wheels>.+?) slips?$")
FAILS = (
    (re.compile(r"the motor of (?P<wheel>.+) dies$"), "dead"),
    (re.compile(r"the motor of (?P<wheel>.+) jams$"), "blocked"),
    (re.compile(r"the steering of (?P<wheel>.+) is stuck$"), "stuck"),
    (re.compile(r"the encoder of (?P<wheel>.+) is stuck$"), "frozen"),
    (re.compile(r"(?P<wheel>.+) comes off$"), "off"),
)
LOST = (
    re.compile(r"the motor of (?P<wheel>.+?) does not do as told"),
    re.compile(r"the (?:steering|encoder) of (?P<wheel>.+?) is stuck"),
    re.compile(r"(?P<wheel>.+?) pushes nothing"),
)


BROKEN = {
    "dead": "motor of {} dead",
    "blocked": "motor of {} blocked",
    "stuck": "steering of {} stuck",
    "frozen": "encoder of {} stuck",
    "off": "{} off",
}


def phase_of(wheel: str, kind: str) -> str:
    """What the time from then on is called."""
    what = {"stuck": "steering stuck", "frozen": "encoder stuck", "off": "off"}.get(kind, f"motor {kind}")
    return f"{wheel}: {what}"


def broken(wheel: str, kind: str) -> str:
    """What has failed of a wheel, in short."""
    return BROKEN[kind].format(wheel)


class Spell(NamedTuple):
    """From `start` to `end`, s; `peak` is the largest slip (m/s) as far as words tell it."""

    start: float
    end: float
    peak: float = 0.0


@dataclass(frozen=True, slots=True)
class SlipVerdicts:
    """What the slip detector said: spells in which each wheel was named, and those in which it could not tell which."""

    named: Mapping[str, tuple[Spell, ...]]
    ambiguous: tuple[Spell, ...]

    def found_within(self, start: float, end: float) -> float | None:
        """When first it said in a time that something slips; None: it did not."""
        spells = [*self.ambiguous, *(spell for spells in self.named.values() for spell in spells)]
        return _first(spells, start, end)

    def named_within(self, start: float, end: float) -> dict[str, float]:
        """Which wheels it named in a time, and since when."""
        firsts = {wheel: _first(spells, start, end) for wheel, spells in self.named.items()}
        return {wheel: time for wheel, time in firsts.items() if time is not None}


def verdicts_of(events: Sequence[Event], end: float) -> SlipVerdicts:
    """Spells of the slip detector, from one of its events to the next, or to the end of the recording."""
    words = [event for event in events if event.source == DETECTOR]
    named: dict[str, list[Spell]] = defaultdict(list)
    unsure = []
    for event, after in zip(words, [*(event.time for event in words[1:]), end], strict=False):
        spell = Spell(event.time, after)
        found = NAMED.match(event.text)
        if found:
            for wheel in found["wheels"].split(" and "):
                named[wheel].append(spell)
        elif "ambiguous" in event.text:
            unsure.append(spell)
    return SlipVerdicts({wheel: tuple(spells) for wheel, spells in named.items()}, tuple(unsure))


def gripping_again(events: Sequence[Event], end: float) -> dict[str, list[Spell]]:
    """Spells in which each wheel truly slipped beyond its grip; without any wheel where no event tells it."""
    begun: dict[str, float] = {}
    spells: dict[str, list[Spell]] = defaultdict(list)
    for event in events:
        found = NOW.match(event.text) if event.source == TRUTH else None
        if found and found["what"] == "slips":
            begun.setdefault(found["wheel"], event.time)
        elif found and found["wheel"] in begun:
            peak = float(found["peak"] or 0.0)
            spells[found["wheel"]].append(Spell(begun.pop(found["wheel"]), event.time, peak))
    for wheel, start in begun.items():
        spells[wheel].append(Spell(start, end))
    return dict(spells)


def faults_of(events: Sequence[Event], told: Sequence[FaultFacts]) -> tuple[FaultFacts, ...]:
    """Faults of motors in order of time: those of the cell, and those that the plant tells of."""
    found = list(told)
    known = {fault.wheel for fault in told}
    for event in events:
        if event.source != PLANT:
            continue
        for pattern, kind in FAILS:
            fails = pattern.match(event.text)
            if fails and fails["wheel"] not in known:
                found.append(FaultFacts(event.time, fails["wheel"], kind))
    return tuple(sorted(found, key=lambda fault: fault.time))


def dead_since(events: Sequence[Event]) -> dict[str, float]:
    """When the controller gave up each motor that it did, s."""
    found: dict[str, float] = {}
    for event in events:
        if event.source != WATCH:
            continue
        lost = next(filter(None, (pattern.match(event.text) for pattern in LOST)), None)
        if lost:
            found.setdefault(lost["wheel"], event.time)
    return found


def _first(spells: Sequence[Spell], start: float, end: float) -> float | None:
    times = [max(spell.start, start) for spell in spells if spell.end > start and spell.start <= end]
    return min(times, default=None)
