"""When the truth's clock says what the wheels' clock says: offset and rate, before anything is calibrated."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

from holonom.arrays import Array
from holonom.mobile.calibration.kernels import left_into
from holonom.mobile.calibration.runs import Motion, Run, dead_reckoning, lever_of

__all__ = ["Clock", "clear_clock", "clock_of", "on_the_clock_of_the_wheels", "truth_frame"]


SPAN = 0.2  # s of the motions that are compared
COARSE = 0.25  # of a span, by which the motions of the first search are apart: closer ones tell the same
MOST = 2.0  # s of an offset that is looked for
FASTEST = 0.03  # of a rate that is looked for
BEYOND = 1.5  # times that, up to which the search from the best of a grid may lead
LEAST = 8  # spans that a run must have
BETTER = 0.5  # part of the disagreement that a clock must leave at most, to be told from noise
ALIKE = 0.05  # part of the motion, squared, that it may leave: what disagrees more has other faults
ROUNDING = 1e-6  # part of the motion, squared, that interpolation may make
AGREED = 1e-3  # part of the motion, squared, up to which both agree as they are
LARGE = 1e6  # m, of a place that no base has
WORTH = 0.5  # periods of the samples: a smaller offset is none


class Clock(NamedTuple):
    """What the truth's clock is behind that of the wheels: s in the middle of the run, s/s that this grows by."""

    late: float = 0.0
    rate: float = 0.0


def clock_of(run: Run, motion: Array | Motion) -> Clock:
    """The truth's clock by the motions over short spans; zeros where noise would look the same.

    The motions over short spans, forwards, sideways and turning, by the wheels and by the truth, are compared at every
    offset and rate: what no linear map of the one leaves of the other, so that neither geometry, a marker's place nor
    slip that adds up matters. A motion that never changes tells nothing of it.

    Parameters
    ----------
    motion : of the nominal geometry: motion matrix (3, f), or a `Motion`.
    """
    return _Compared.search(run, motion, clear=False)


def clear_clock(run: Run, motion: Array | Motion) -> Clock:
    """The same where it is clear: it is worth half a sample or more, and more than what never quite agrees."""
    return _Compared.search(run, motion, clear=True)


def truth_frame(run: Run, motion: Array | Motion) -> tuple[float, float, float]:
    """Where the truth's frame is on the base, roughly: ahead and to the left, m, and its turn, rad.

    By linear least squares of motions over short spans, those of the truth by `exp(-i yaw) (v + i w p)`.

    Parameters
    ----------
    motion : of the nominal geometry: motion matrix (3, f), or a `Motion`.
    """
    period = float(np.median(np.diff(run.time)))
    half = max(1, round(0.5 * SPAN / period)) * period
    inner = run.time[(run.time >= run.time[0] + half) & (run.time <= run.time[-1] - half)]
    if len(inner) < LEAST:
        return 0.0, 0.0, 0.0
    truth = CubicSpline(run.time, np.column_stack([run.truth[:, :2], run.heading]))
    ours = _motions(CubicSpline(run.time, dead_reckoning(run, motion)), inner, half, 1.0)
    theirs = _motions(truth, inner, half, 1.0)[:, :2] @ np.array([1.0, 1.0j])
    effects = np.stack([ours[:, :2] @ np.array([1.0, 1.0j]), 1j * ours[:, 2]], axis=1)
    turned, moved = np.linalg.lstsq(effects, theirs, rcond=1e-6)[0]
    if turned == 0.0:
        return 0.0, 0.0, 0.0
    place = moved / turned
    return float(place.real), float(place.imag), -float(np.angle(turned))


def on_the_clock_of_the_wheels(run: Run, clock: Clock) -> Run:
    """The same run with its truth put right, by interpolation; samples without a truth are cut off."""
    truth = np.column_stack([run.truth[:, :2], run.heading])
    at = run.time + clock.late + clock.rate * (run.time - _middle(run))
    kept = (at >= run.time[0]) & (at <= run.time[-1])
    turns = run.turns[kept].copy()
    turns[0] = 0.0  # what came before the first sample is none of its own
    seen = CubicSpline(run.time, truth)(at)[kept]
    rate, flow, drift, creep = (
        rows[kept] if len(rows) else rows for rows in (run.rate, run.flow, run.drift, run.creep)
    )
    return Run(
        run.name, run.time[kept], turns, seen, run.steering[kept], rate, flow, drift, creep, run.creep_share
    )  # fmt: skip


def _middle(run: Run) -> float:
    return float(0.5 * (run.time[0] + run.time[-1]))


class _Compared:
    """Motions of one run by its wheels beside those by its truth at any clock."""

    def __init__(self, run: Run, motion: Array | Motion, period: float, most: float) -> None:
        self.half = max(1, round(0.5 * SPAN / period)) * period
        self.truth = CubicSpline(run.time, np.column_stack([run.truth[:, :2], run.heading]))
        self.lever = lever_of(motion)
        inner = run.time[(run.time > run.time[0] + most + SPAN) & (run.time < run.time[-1] - most - SPAN)]
        self.time, self.since = inner, inner - _middle(run)
        ours = _motions(CubicSpline(run.time, dead_reckoning(run, motion)), inner, self.half, self.lever)
        self.basis = _basis(ours)
        self.few = slice(None, None, max(1, round(COARSE * SPAN / period)))
        self.few_basis = _basis(ours[self.few])

    @classmethod
    def search(cls, run: Run, motion: Array | Motion, *, clear: bool) -> Clock:
        period, length = float(np.median(np.diff(run.time))), float(run.time[-1] - run.time[0])
        most = min(MOST, 0.25 * length)
        short = len(run.truth) * period < 2.0 * SPAN * LEAST or most < period
        if short or max(np.abs(run.truth).max(initial=0.0), np.abs(run.turns).max(initial=0.0)) > LARGE:
            return Clock()
        return cls(run, motion, period, most).best(period, most, length, clear=clear)

    def best(self, period: float, most: float, length: float, *, clear: bool) -> Clock:
        step = max(period, COARSE * SPAN)
        start = self._coarse(step, most)
        scale = np.array([step, 2.0 * step / length])
        found = minimize(
            lambda x: self.miss(Clock(*(start + x * scale))), np.zeros(2), method="Nelder-Mead",
            options={"xatol": 1e-3, "fatol": 1e-12, "initial_simplex": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]},
        )  # fmt: skip
        clock = Clock(*(float(v) for v in start + found.x * scale))
        as_is, left = self.miss(Clock()), self.miss(clock)
        moved = float((self.seen(clock) ** 2).sum())
        near = abs(clock.late) <= BEYOND * most and abs(clock.rate) <= BEYOND * FASTEST  # one that stands fits anything
        good = near and left < min(BETTER * as_is, ALIKE * moved) and as_is > (AGREED if clear else ROUNDING) * moved
        if clear:
            good = good and max(abs(clock.late), 0.5 * length * abs(clock.rate)) > WORTH * period
        return clock if good else Clock()

    def seen(self, clock: Clock) -> Array:
        """Motions (N, 3) of the truth."""
        return _motions(self.truth, self.time + clock.late + clock.rate * self.since, self.half, self.lever)

    def miss(self, clock: Clock) -> float:
        """Square sum of what no linear map of the wheels' motions explains."""
        return _left(self.basis, self.seen(clock))

    def _coarse(self, step: float, most: float) -> Array:
        """Best clock (2,) of a grid: offsets by a step, rates by two steps over the run; by a part of the motions."""
        at = step * np.arange(-int(most / step), int(most / step) + 1)
        time, since = self.time[self.few], self.since[self.few]
        table = np.stack([_motions(self.truth, time + late, self.half, self.lever) for late in at])
        span = float(since[-1] - since[0]) if len(since) > 1 else 1.0
        count = int(min(FASTEST * 0.5 * span, most) / (2.0 * step))
        rates = (4.0 * step / span) * np.arange(-count, count + 1)
        shifts = np.round(rates[:, None] * since / step).astype(np.int64)
        every = 2 if count else 1
        left = np.empty((len(rates), len(range(0, len(at), every))))
        left_into(table, self.few_basis, shifts, every, left)
        r, k = np.unravel_index(int(np.argmin(left)), left.shape)
        return np.array([at[every * k], rates[r]])


def _basis(motions: Array) -> Array:
    """Orthonormal columns (N, 3 or fewer) that span those of motions (N, 3)."""
    U, s, _ = np.linalg.svd(motions, full_matrices=False)
    return np.asarray(U[:, s > 1e-9 * max(s[0], 1e-300)])


def _left(basis: Array, theirs: Array) -> float:
    """Square sum of what no columns of a basis explain."""
    return float((theirs**2).sum() - ((basis.T @ theirs) ** 2).sum())


def _motions(poses: CubicSpline, time: Array, half: float, lever: float) -> Array:
    """Motion (N, 3) from half a span before each time to half a span after it, in the frame half-way round."""
    before, after = poses(time - half), poses(time + half)
    step, turn = after - before, after[:, 2] - before[:, 2]
    middle = 0.5 * (before[:, 2] + after[:, 2])
    c, s = np.cos(middle), np.sin(middle)
    return np.stack([c * step[:, 0] + s * step[:, 1], c * step[:, 1] - s * step[:, 0], lever * turn], axis=1)
