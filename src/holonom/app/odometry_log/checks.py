"""Checks of a log that need to know what a base can do: time, speeds, and whether wheels and truth tell one story."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from holonom.app.odometry_log.spells import note_spells
from holonom.app.odometry_log.story import check_columns, judge_miss
from holonom.app.odometry_log.table import Table
from holonom.errors import LogError
from holonom.mobile.calibration import Clock, Parameters, Run, clear_clock, on_the_clock_of_the_wheels, seen_from
from holonom.mobile.odometry import find_gaps

__all__ = ["check_motion", "check_time", "in_one_clock", "part_names"]


FASTEST = 20.0  # m/s, of a rim or the truth: 72 km/h
WILDEST = 30.0  # rad/s of the truth
FEWEST = 16  # samples of a part between gaps
SLOWEST = 0.003  # m/s: a run in which nothing is ever faster has another unit of time
MOVED = 0.05  # m that must have been driven to say so
ROUND = 8.0 * np.pi  # rad that a wheel may be steered which goes all round
STEP = 5.0  # s between samples, more is another unit of time


def check_time(
    table: Table, *, allow_gaps: bool, running: bool, factor: float = 2.5
) -> tuple[list[Table], tuple[str, ...]]:
    """Refuse time that stands still or goes back, and gaps; where they are allowed, cut the run there.

    Parameters
    ----------
    table : the run.
    allow_gaps : whether gaps may be.
    running : wheels count on through a gap; otherwise what they did in it is lost, and the run falls into parts.
    factor : a step above that many times the median one is a gap.

    Returns
    -------
    The parts of the run, one where it has no gap or wheels that count on; notes.

    Raises
    ------
    LogError
    """
    time = table.column("time")
    steps = np.diff(time)
    if np.any(steps <= 0.0):
        row = int(np.argmax(steps <= 0.0)) + 1
        table.fault(
            row, "time", f"{time[row]:g} s after {time[row - 1]:g} s; time must grow: sort the log or cut it there"
        )
    gaps = np.flatnonzero(find_gaps(time, factor))
    if not len(gaps):
        return [table], ()
    first, longest = int(gaps[0]), float(np.max(steps))
    text = f"{len(gaps)} gap(s) up to {longest:g} s, samples come every {np.median(steps):g} s"
    if not (allow_gaps or running):
        table.fault(
            first, "time", f"{text}: wheels went on unseen; cut the run at the gap, or allow gaps to have it cut"
        )
    place = f"{table.path}:{table.lines[first]}: {text}; allowed"
    if running:
        return [table], (place,)
    parts = [part for part in table.cut(gaps.tolist()) if len(part.values) >= FEWEST]
    if not parts:
        table.fault(first, "time", f"{text}: between them never {FEWEST} samples; record the run again")
    left = "" if len(parts) == len(gaps) + 1 else f", {len(gaps) + 1 - len(parts)} of under {FEWEST} samples left out"
    return parts, (f"{place}: cut there, since wheels by the sample do not tell what they did unseen{left}",)


def part_names(path: Path, count: int) -> list[str]:
    """Names of the parts of a run: that of its file, with a number if there are several."""
    name = path.name.split(".")[0]
    return [name] if count == 1 else [f"{name} part {k}" for k in range(1, count + 1)]


def check_motion(table: Table, run: Run, parameters: Parameters, wheels: Sequence[str]) -> tuple[str, ...]:
    """Refuse speeds that cannot be, wrong units and swapped columns; notes on what is doubtful: jumps, dropouts, slip.

    Parameters
    ----------
    table : the run as it was read, for messages.
    run : the same in SI units.
    parameters : the base's nominal ones.
    wheels : names of the columns of the run's wheels.

    Raises
    ------
    LogError
    """
    motion, radius = parameters.motion(parameters.nominal), _largest_radius(parameters)
    _check_steering(table, run)
    _check_rims(table, run, wheels, radius)
    _check_clock(table, run, radius)
    if not len(run.truth):
        return ()
    miss, frame = check_columns(table, run, motion, wheels)
    _check_truth(table, run)
    notes = (
        *judge_miss(table, miss),
        *note_spells(table, run, motion if frame is None else seen_from(motion, frame), wheels),
    )
    if frame is None:
        return notes
    turned = f"{table.path}: the truth's frame is turned by {np.degrees(frame[2]):.1f} degrees against the base"
    return (f"{turned}; the extended set finds it, the physical one takes it for geometry", *notes)


def in_one_clock(
    table: Table, run: Run, parameters: Parameters, wheels: Sequence[str], *, as_published: bool = False
) -> tuple[Run, tuple[str, ...]]:  # fmt: skip
    """The run on the clock of its wheels, and notes: what `check_motion` says where the truth's clock is put right.

    Parameters
    ----------
    as_published : a run that can be read as it stands keeps its clocks, so that its errors are those published.

    Raises
    ------
    LogError
        What `check_motion` refuses, and no offset of the clock explains.
    """
    fault: LogError | None = None
    doubts: tuple[str, ...] = ()
    try:
        doubts = check_motion(table, run, parameters, wheels)
    except LogError as problem:
        fault = problem
    clock = clear_clock(run, parameters.motion(parameters.nominal)) if len(run.truth) else Clock()
    if clock == Clock():
        if fault is not None:
            raise fault
        return run, doubts
    if as_published and fault is None:
        told = f"the truth's clock {_said(clock, run)}; left as published, the calibration puts it right"
        return run, (f"{table.path}: {told}", *doubts)
    moved = on_the_clock_of_the_wheels(run, clock)
    first = int(np.searchsorted(run.time, moved.time[0]))
    part = table.cut([first, first + len(moved.time)])[1]
    try:
        doubts = check_motion(part, moved, parameters, wheels)
    except LogError:
        if fault is None:  # it reads as it stands: another clock explains a jump no better
            return run, doubts
        raise fault from None
    return moved, (f"{table.path}: the truth's clock {_said(clock, run)}; put right", *doubts)


def _said(clock: Clock, run: Run) -> str:
    """What is wrong with the truth's clock: "is 0.3 s late", and by how much it loses."""
    late, gone = clock.late, clock.rate * float(run.time[-1] - run.time[0])
    step = float(np.median(np.diff(run.time)))
    told = f"is {abs(late):.3g} s {'late' if late > 0.0 else 'early'}"
    if abs(gone) < step:
        return told
    rate = f"{'loses' if clock.rate > 0.0 else 'gains'} {100.0 * abs(clock.rate):.2g} %"
    return rate if abs(late) < 0.5 * step else f"{rate} and {told} half-way"


def _largest_radius(parameters: Parameters) -> float:
    sizes = [
        (0.5 if name.startswith("diameter") else 1.0) * value
        for name, value in zip(parameters.names, parameters.nominal, strict=True)
        if name.startswith(("diameter", "radius"))
    ]
    return float(max(sizes))


def _check_clock(table: Table, run: Run, radius: float) -> None:
    """A run that creeps all along: its time is in ms."""
    dt = np.diff(run.time)
    rims = radius * np.abs(run.turns[1:]).max(axis=1)
    step, fastest = float(np.median(dt)), float(np.max(rims / dt))
    if step > STEP or (rims.sum() > MOVED and fastest < SLOWEST):
        table.fault(1, "time", f"samples come every {step:g} s and no wheel is ever faster than {fastest:.2g} m/s: "
                               "time in ms instead of s?")  # fmt: skip


def _check_steering(table: Table, run: Run) -> None:
    alone = "steering" in table.names
    if run.steering.size == 0 or np.abs(run.steering).max() <= (np.pi if alone else ROUND):
        return
    row = int(np.argmax(np.abs(run.steering).max(axis=1)))
    if not alone:
        angle = float(np.abs(run.steering[row]).max())
        table.fault(row, "time", f"a wheel steers {angle:.4g} rad, several turns: degrees instead of rad?")
    raw = table.column("steering")
    wheel = "front" if "front" in table.names else table.names[-2]
    if np.all(raw == np.round(raw)) and np.abs(table.column(wheel)).max() <= np.pi:
        table.fault(row, "steering", f"{raw[row]:g} came, whole numbers beside a wheel column within half a turn: "
                                     f"columns {wheel} and steering are swapped; swap them")  # fmt: skip
    table.fault(row, "steering", f"{run.steering[row, 0]:.4g} rad came; -pi to pi is allowed: degrees instead of rad?")


def _check_rims(table: Table, run: Run, wheels: Sequence[str], radius: float) -> None:
    dt = np.diff(run.time)
    speed = np.abs(run.turns[1:]) * radius / dt[:, None]
    if speed.max() <= FASTEST:
        return
    row, wheel = np.unravel_index(int(np.argmax(speed)), speed.shape)
    table.fault(
        int(row) + 1, wheels[int(wheel)],
        f"the wheel's rim runs at {speed.max():.4g} m/s; up to {FASTEST:g} are plausible: see the unit of the column "
        "(ticks of a sample, running counts, rad), encoder, gear, and that the diameter is in m, not mm",
    )  # fmt: skip


def _check_truth(table: Table, run: Run) -> None:
    dt = np.diff(run.time)
    step = np.diff(run.truth[:, :2], axis=0)
    speed = np.hypot(step[:, 0], step[:, 1]) / dt
    if speed.max() > FASTEST:
        row = int(np.argmax(speed))
        column = "x" if abs(step[row, 0]) >= abs(step[row, 1]) else "y"
        table.fault(row + 1, column, f"the truth moves at {speed.max():.4g} m/s; up to {FASTEST:g} are plausible: "
                                     "mm instead of m, or a jump of the tracker?")  # fmt: skip
    rate = np.abs(np.diff(run.heading)) / dt
    if rate.max() > WILDEST:
        row = int(np.argmax(rate))
        table.fault(row + 1, "theta", f"the truth turns at {rate.max():.4g} rad/s; up to {WILDEST:g} are plausible: "
                                      "degrees instead of rad, or a jump of the tracker?")  # fmt: skip
