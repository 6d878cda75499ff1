"""By how much the truth's clock is late, before anything is calibrated: when both tell of the same motion."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from holonom.arrays import Array
from holonom.mobile.calibration.runs import Run, dead_reckoning

__all__ = ["clock_offset", "on_the_clock_of_the_wheels"]

SPAN = 0.2  # s of the motions that are compared
MOST = 2.0  # s of an offset that is looked for
LEAST = 8  # spans that a run must have
BETTER = 0.5  # part of the disagreement that an offset must leave at most, to count
ALIKE = 0.05  # part of the motion, squared, that it may leave: what disagrees more has other faults
AGREED = 1e-3  # part of the motion, squared, up to which both agree as they are
LARGE = 1e6  # m, of a place that no base has
WORTH = 0.5  # periods of the samples: a smaller offset is none


def clock_offset(run: Run, matrix: Array) -> float:
    """By how much the truth's clock is behind that of the wheels, s; 0 where no offset explains clearly more.

    The motions over short spans, forwards, sideways and turning, by the wheels and by the truth, are compared at every
    offset: what no linear map of the one leaves of the other, so that neither geometry nor a marker's place matters.
    A motion that never changes tells nothing of it.

    Parameters
    ----------
    matrix : (3, f) motion matrix of the nominal geometry.
    """
    period = float(np.median(np.diff(run.time)))
    half, most = max(1, round(0.5 * SPAN / period)), min(MOST, 0.25 * float(run.time[-1] - run.time[0]))
    short = len(run.truth) < 2 * half * LEAST or most < period
    if short or max(np.abs(run.truth).max(initial=0.0), np.abs(run.turns).max(initial=0.0)) > LARGE:
        return 0.0
    truth = CubicSpline(run.time, np.column_stack([run.truth[:, :2], run.heading]))
    wheels = CubicSpline(run.time, dead_reckoning(run, matrix))
    inner = run.time[(run.time > run.time[0] + most + SPAN) & (run.time < run.time[-1] - most - SPAN)]
    lever = float(np.abs(matrix[:2]).max() / max(np.abs(matrix[2]).max(), 1e-12))
    ours = _motions(wheels, inner, half * period, lever)
    U, s, _ = np.linalg.svd(ours, full_matrices=False)
    basis = U[:, s > 1e-9 * max(s[0], 1e-300)]

    def miss(late: float) -> float:
        theirs = _motions(truth, inner + late, half * period, lever)
        left = theirs - basis @ (basis.T @ theirs)
        return float((left**2).sum())

    at = np.arange(-most, most + 0.5 * period, period)
    coarse = float(at[int(np.argmin([miss(late) for late in at]))])
    found = minimize_scalar(miss, bounds=(coarse - period, coarse + period), method="bounded").x
    moved = float((_motions(truth, inner + found, half * period, lever) ** 2).sum())
    clear = miss(found) < min(BETTER * miss(0.0), ALIKE * moved) and miss(0.0) > AGREED * moved
    return float(found) if clear and abs(found) > WORTH * period else 0.0


def on_the_clock_of_the_wheels(run: Run, late: float) -> Run:
    """The same run with its truth that much earlier, s, by interpolation; samples without a truth are cut off."""
    truth = np.column_stack([run.truth[:, :2], run.heading])
    moved = CubicSpline(run.time, truth)(run.time + late)
    kept = (run.time + late >= run.time[0]) & (run.time + late <= run.time[-1])
    turns = run.turns[kept].copy()
    turns[0] = 0.0  # what came before the first sample is none of its own
    return Run(run.name, run.time[kept], turns, moved[kept], run.steering[kept])


def _motions(poses: CubicSpline, time: Array, half: float, lever: float) -> Array:
    """Motion (N, 3) from half a span before each time to half a span after it, in the frame half-way round."""
    before, after = poses(time - half), poses(time + half)
    step, turn = after - before, after[:, 2] - before[:, 2]
    middle = 0.5 * (before[:, 2] + after[:, 2])
    c, s = np.cos(middle), np.sin(middle)
    return np.stack([c * step[:, 0] + s * step[:, 1], c * step[:, 1] - s * step[:, 0], lever * turn], axis=1)
