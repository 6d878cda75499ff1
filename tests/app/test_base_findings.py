"""What came of a base, by the words and tracks of its recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from report_jobs import WHEELS, base_job, job_of

from holonom.app.recording import BaseTrack, Recording, Track
from holonom.app.report.attachments import cell_facts
from holonom.app.report.findings.base_findings import Phase, findings_of, motion_of, path_error
from holonom.app.report.findings.base_words import dead_since, verdicts_of
from holonom.app.report.findings.facts import FaultFacts, RobotFacts
from holonom.signals import Event

FACTS = cell_facts(job_of(base_job())).robots[0]
RATE, END = 100, 10.0
TIME = np.arange(round(RATE * END) + 1) / RATE
QUIET = "no wheel slips any more"


def slipping(*spells: tuple[str, float, float]) -> np.ndarray:
    """Slip of all wheels, 0.2 m/s in some spells."""
    slip = np.zeros((len(TIME), len(WHEELS)))
    for wheel, start, end in spells:
        slip[(start - 1e-9 <= TIME) & (end + 1e-9 >= TIME), WHEELS.index(wheel)] = 0.2
    return slip


def recording(slip: np.ndarray, events: Sequence[Event] = (), **tracks: Track) -> Recording:
    contact = {"/truth/wheel_force": "force", "/truth/wheel_slip": "slip", "/estimated/wheel_residual": "residual"}
    held = {name: Track(TIME, {field: slip}) for name, field in contact.items()}
    words = tuple(sorted(events, key=lambda event: event.time))
    return Recording(tracks=held | tracks, events=words, joint_names=WHEELS)


def detector(time: float, text: str) -> Event:
    return Event(time, "info" if text == QUIET else "warning", "slip detection", text)


def truth(wheel: str, start: float, end: float | None = None) -> list[Event]:
    ends = [] if end is None else [Event(end, "debug", "truth", f"{wheel} grips")]
    return [Event(start, "debug", "truth", f"{wheel} slips"), *ends]


def test_episodes_have_the_times_of_true_events_and_the_peak_of_the_track() -> None:
    slip = slipping(("rear left", 2.01, 2.2))
    slip[205, 1] = -0.31
    words = [detector(2.013, "rear left slips"), detector(2.25, QUIET)]
    found = findings_of(recording(slip, [*truth("rear left", 2.004, 2.203), *words]), FACTS)
    (one,) = found.slips
    assert (one.wheel, one.start, one.end, one.peak) == ("rear left", 2.004, 2.203, 0.31)
    assert one.delay == pytest.approx(0.009)
    assert one.naming_delay == pytest.approx(0.009)
    assert one.right
    assert found.alarms == ()


def test_peaks_that_words_tell_are_those_between_samples() -> None:
    events = [
        *truth("rear left", 2.0),
        Event(2.1, "debug", "truth", "rear left grips, it slipped at up to 0.423 m/s"),
        *truth("rear left", 2.12, 2.2),
    ]
    (one,) = findings_of(recording(slipping(("rear left", 2.0, 2.2)), events), FACTS).slips
    assert (one.wheel, one.start, one.end, one.peak) == ("rear left", 2.0, 2.2, 0.423)


def test_a_slip_that_is_found_late_ambiguous_or_never() -> None:
    slips = ("front left", 1.0, 1.3), ("rear right", 4.0, 4.3), ("rear left", 7.0, 7.2)
    words = [
        detector(1.02, "a wheel slips; which one is ambiguous"),
        detector(1.05, "front left and rear left slip"),
        detector(1.4, QUIET),
        detector(4.03, "a wheel slips; which one is ambiguous"),
        detector(4.35, QUIET),
    ]
    first, second, third = findings_of(recording(slipping(*slips), words), FACTS).slips
    assert (first.detected, first.identified) == (1.02, 1.05)
    assert first.named == ("front left", "rear left")
    assert not first.right
    assert (second.detected, second.identified, second.named) == (4.03, None, ())
    assert (third.detected, third.delay, third.naming_delay) == (None, None, None)


def test_short_pauses_are_one_episode_and_an_open_one_lasts_to_the_end() -> None:
    slip = slipping(("rear left", 2.0, 2.1), ("rear left", 2.14, 2.3), ("rear left", 2.5, 2.6))
    spells = [(one.start, one.end) for one in findings_of(recording(slip), FACTS).slips]
    assert spells == [(2.0, 2.3), (2.5, 2.6)]
    events = [*truth("rear left", 2.0, 2.1), *truth("rear left", 2.14, 2.3), *truth("rear right", 9.5)]
    spells = [(one.wheel, one.start, one.end) for one in findings_of(recording(slip, events), FACTS).slips]
    assert spells == [("rear left", 2.0, 2.3), ("rear right", 9.5, END)]


def test_where_the_truth_has_words_the_track_is_only_asked_for_peaks() -> None:
    slip = slipping(("rear left", 2.0, 2.1), ("rear right", 5.0, 5.1))
    found = findings_of(recording(slip, truth("rear left", 2.0, 2.1)), FACTS)
    assert [one.wheel for one in found.slips] == ["rear left"]


def test_words_without_cause_are_false_alarms() -> None:
    slip = slipping(("rear left", 2.0, 2.3))
    words = [
        detector(1.0, "a wheel slips; which one is ambiguous"),  # nothing slips
        detector(1.1, QUIET),
        detector(2.01, "rear left slips"),
        detector(2.1, "rear right slips"),  # another one does
        detector(2.3, QUIET),
        detector(2.35, "rear left slips"),  # it did just now
        detector(2.45, QUIET),
        detector(2.5, "rear left slips"),  # it did 0.2 s ago
        detector(2.6, QUIET),
    ]
    alarms = findings_of(recording(slip, words), FACTS).alarms
    assert [(alarm.what, alarm.start) for alarm in alarms] == [
        ("slip found, no wheel slips", 1.0),
        ("rear right named, it grips", 2.1),
        ("rear left named, it grips", 2.5),
    ]
    held = [detector(2.01, "rear left slips"), detector(4.0, QUIET)]  # named rightly, but much too long
    (alarm,) = findings_of(recording(slip, held), FACTS).alarms
    assert (alarm.what, alarm.end) == ("rear left named, it grips", 4.0)


def test_motors_that_fail_and_those_that_were_given_up_without_need() -> None:
    told = [FaultFacts(3.0, "rear left", "dead"), FaultFacts(12.0, "rear right", "blocked")]
    assert FACTS.base is not None
    facts = replace(FACTS, base=replace(FACTS.base, faults=tuple(told)))
    events = [
        Event(3.0, "warning", "plant", "the motor of rear left dies"),
        Event(3.03, "error", "motor watch", "the motor of rear left does not do as told; driving on without it"),
        Event(5.0, "error", "motor watch", "the motor of front left does not do as told; driving on without it"),
        Event(6.0, "warning", "plant", "the motor of front right jams"),
    ]
    found = findings_of(recording(slipping(), events), facts)
    assert [(m.wheel, m.kind, m.time, m.detected, m.reached) for m in found.dead] == [
        ("rear left", "dead", 3.0, 3.03, True),
        ("front right", "blocked", 6.0, None, True),
        ("rear right", "blocked", 12.0, None, False),
    ]
    assert [(alarm.what, alarm.start) for alarm in found.alarms] == [("motor of front left given up, it works", 5.0)]
    assert [(phase.name, phase.start, phase.end) for phase in found.phases] == [
        ("whole run", 0.0, END),
        ("before the first fault", 0.0, 3.0),
        ("rear left: motor dead", 3.0, 6.0),
        ("front right: motor blocked", 6.0, END),
    ]
    early = [Event(2.0, "error", "motor watch", "the motor of rear left does not do as told; it is jammed")]
    found = findings_of(recording(slipping(), early), facts)
    assert found.dead[0].detected is None  # before it failed
    assert [alarm.start for alarm in found.alarms] == [2.0]


def test_words_of_other_robots_are_not_this_ones() -> None:
    other = Event(1.0, "warning", "other.slip detection", "rear left slips")
    assert verdicts_of([other], END).named == {}
    assert dead_since([replace(other, text="the motor of rear left does not do as told")]) == {}


def test_path_errors_are_those_of_true_pose_and_reference() -> None:
    rng = np.random.default_rng(7)
    wanted = np.stack([np.cos(TIME), np.sin(TIME), TIME + 3.0], axis=1)  # heading beyond pi
    off, believed = rng.normal(scale=0.01, size=(2, len(TIME), 3))
    twist, none = np.zeros((len(TIME), 3)), np.zeros((len(TIME), 3, 3))
    true, seen = wanted + off, wanted + believed
    true[:, 2] = (true[:, 2] + np.pi) % (2 * np.pi) - np.pi
    tracks = {"/truth/odom": true, "/commanded/odom": wanted, "/odom": seen}
    given = {name: Track(TIME, {"pose": pose, "twist": twist, "covariance": none}) for name, pose in tracks.items()}
    motion = motion_of(recording(slipping(), **given))
    within = (TIME >= 2.0) & (TIME <= 4.0)
    error = path_error(motion, Phase("some", 2.0, 4.0))
    assert error is not None
    distance = np.hypot(off[within, 0], off[within, 1])
    assert error.rms == pytest.approx(np.sqrt(np.mean(distance**2)))
    assert error.peak == pytest.approx(distance.max())
    assert error.believed == pytest.approx(np.hypot(*believed[within, :2].T).max())
    assert error.heading == pytest.approx(np.abs(off[within, 2]).max())
    assert path_error(motion, Phase("later", 20.0, 21.0)) is None
    assert motion_of(recording(slipping())) is None
    assert isinstance(recording(slipping(), **given).base, BaseTrack)


def test_facts_are_optional() -> None:
    nobody = RobotFacts("", "base", "", "", "", WHEELS, ("revolute",) * 4)
    assert len(findings_of(recording(slipping(("rear left", 1.0, 1.1))), nobody).slips) == 1
