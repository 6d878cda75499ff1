"""Spells of a run in which wheels and truth disagree far beyond the run's own noise: jumps, dropouts, slip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.app.odometry_log.motion import moved
from holonom.app.odometry_log.table import Table
from holonom.arrays import Array
from holonom.mobile.calibration import Motion, Run, dead_reckoning, lever_of
from holonom.mobile.odometry import flag

__all__ = ["note_spells"]

Mask = NDArray[np.bool_]

SPAN, LEAST = 0.5, 16  # s of a window, and samples that a run must have before its noise is known
NOISE, SHARE = 8.0, 0.2  # a spell: so many times the median disagreement, and this share of what is driven in a window
JUMP = 5.0  # times the fastest the truth usually is (19 samples in 20)
JUMPED = 0.01  # m, a smaller step is no jump
SHORTEST = 3  # samples of a spell
STANDING = 0.8  # share of a spell's samples without ticks in which a wheel stands


@dataclass(frozen=True, slots=True)
class _View:
    """One run: motion over sliding windows by wheels and by truth, and of each sample (N, 3), turns times lever."""

    run: Run
    half: int
    wheels: Array
    truth: Array
    steps: Array
    missed: Array


def note_spells(table: Table, run: Run, motion: Array | Motion, wheels: Sequence[str]) -> tuple[str, ...]:
    """Notes on jumps of the truth, wheels that stand while the base moves, and slip: lines, times, how much.

    Parameters
    ----------
    table : the run as it was read, for messages.
    run : the same in SI units, with truth.
    motion : of the nominal geometry, what `dead_reckoning` takes.
    wheels : names of the columns of the run's wheels.
    """
    if len(run.time) < LEAST:
        return ()
    view = _view(run, motion)
    jumps, slips = _flagged(view)
    notes = []
    texts: dict[str, list[tuple[float, str]]] = {}
    for first, last in _runs_of(jumps):
        texts.setdefault("jump", []).append(_jump(table, view, first, last))
    for first, last in _runs_of(slips & ~_near(jumps, view.half)):
        if last - first < SHORTEST - 1:
            continue
        kind, told = _slip(table, view, wheels, first, last)
        texts.setdefault(kind, []).append(told)
    for kind, spells in texts.items():
        worst = max(spells)[1]
        more = f", and {len(spells) - 1} more such" if len(spells) > 1 else ""
        notes.append(f"{worst}{more}: {_ADVICE[kind]}")
    return tuple(notes)


_ADVICE = {
    "jump": "cut the run there, or repair the truth; the calibration takes it for motion",
    "dropout": "a dropout, or clocks that are apart; cut the run there, or the calibration takes it for geometry",
    "slip": "slip, or ticks that were counted too often; cut it out, or the calibration takes it for geometry",
    "lost": "lost ticks, a push, or a fault of the truth; cut it out, or the calibration takes it for geometry",
}


def _view(run: Run, motion: Array | Motion) -> _View:
    lever, path = lever_of(motion), dead_reckoning(run, motion)
    truth = np.column_stack([run.truth[:, :2], run.heading])
    half = max(1, round(0.5 * SPAN / float(np.median(np.diff(run.time)))))
    at = np.arange(len(path))
    start, end = np.maximum(at - half, 0), np.minimum(at + half, len(path) - 1)
    steps = [np.vstack([np.zeros(3), moved(p, at[:-1], at[1:], lever)]) for p in (truth, path)]
    return _View(
        run, half, moved(path, start, end, lever), moved(truth, start, end, lever), steps[0], steps[0] - steps[1]
    )


def _flagged(view: _View) -> tuple[Mask, Mask]:
    """Samples with jumps of the truth, and in spells of disagreement."""
    dt = np.diff(view.run.time, prepend=view.run.time[0] - (view.run.time[1] - view.run.time[0]))
    usual = [
        JUMP * float(np.quantile(speed, 0.95))
        for speed in (_size(view.steps[:, :2]) / dt, np.abs(view.steps[:, 2]) / dt)
    ]
    missed = np.linalg.norm(view.wheels - view.truth, axis=1)
    driven = float(np.quantile(np.linalg.norm(view.wheels, axis=1), 0.9))
    bound = max(NOISE * float(np.median(missed)), SHARE * driven)
    flags = flag(
        view.run.time, view.steps, residual=missed[:, None], max_residual=bound, max_speed=usual[0],
        max_turn_rate=usual[1], gap_factor=np.inf,
    )  # fmt: skip
    step = np.linalg.norm(view.steps, axis=1)
    return flags.implausible & (step > JUMPED) & (np.linalg.norm(view.missed, axis=1) > 0.5 * step), flags.slip


def _size(rows: Array) -> Array:
    return np.asarray(np.hypot(rows[:, 0], rows[:, 1]))


def _near(mask: Mask, reach: int) -> Mask:
    """Samples within `reach` of one in the mask."""
    return np.asarray(np.convolve(mask, np.ones(2 * reach + 1), "same") > 0.5)


def _runs_of(mask: Mask) -> list[tuple[int, int]]:
    """First and last sample of each stretch."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def _place(table: Table, run: Run, first: int, last: int) -> str:
    lines = f"{table.lines[first]}" + (f"-{table.lines[last]}" if last > first else "")
    return f"{table.path}:{lines}: at {run.time[first]:g} s" + (f" to {run.time[last]:g} s" if last > first else "")


def _jump(table: Table, view: _View, first: int, last: int) -> tuple[float, str]:
    at = first + int(np.argmax(np.linalg.norm(view.steps[first : last + 1], axis=1)))
    dt = float(view.run.time[at] - view.run.time[at - 1])
    step, turn = float(_size(view.steps[at : at + 1])[0]), abs(float(view.run.heading[at] - view.run.heading[at - 1]))
    usual = float(np.quantile(_size(view.steps), 0.95)) / dt
    text = f"the truth jumps by {step:.3g} m and {np.degrees(turn):.3g} degrees in one sample, {step / dt:.3g} m/s"
    return step, f"{_place(table, view.run, at, at)} {text} where {usual:.3g} m/s is usual"


def _slip(table: Table, view: _View, wheels: Sequence[str], first: int, last: int) -> tuple[str, tuple[float, str]]:
    """Which kind of spell, and the words for it."""
    miss = float(np.linalg.norm(view.wheels - view.truth, axis=1)[first : last + 1].max())
    usual = float(np.median(np.linalg.norm(view.wheels - view.truth, axis=1)))
    place = _place(table, view.run, first, last)
    told = f"disagree by up to {miss:.3g} m in {2 * view.half} samples where {usual:.2g} m is usual"
    idle = np.mean(view.run.turns[first : last + 1] == 0.0, axis=0) > STANDING
    standing = [name for name, still in zip(wheels, idle, strict=True) if still]
    if standing:
        return "dropout", (
            miss,
            f"{place} {', '.join(standing)} count(s) nothing while the base moves; wheels and truth {told}",
        )
    sizes = [float(np.abs(rows[first : last + 1]).sum()) for rows in (view.wheels, view.truth)]
    kind, text = (
        ("slip", "the wheels move more than the truth")
        if sizes[0] > sizes[1]
        else ("lost", "the truth moves more than the wheels")
    )
    return kind, (miss, f"{place} {text}; they {told}")
