"""How unsure numbers are since what wheels creep is known by half only.

What creeps creeps always alike: no repetition shows it, and no covariance of noise holds it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from holonom.arrays import Array
from holonom.mobile.calibration.fitting.residuals import Problem
from holonom.mobile.calibration.runs import Run

__all__ = ["creep_covariance"]


def creep_covariance(problem: Problem, x: Array) -> Array:
    """Covariance (p, p) of the scaled parameters by the creep of each wheel, and that across; zeros where none came.

    The solution moves by `-J^+ dr` where a creep that is larger by its standard deviation changes the residuals by dr.
    """
    r, J = problem.residuals(x)
    inverse = np.linalg.pinv(J)
    found = np.zeros((len(x), len(x)))
    for runs in _varied(problem.runs):
        shift = inverse @ (replace(problem, runs=runs).residuals(x)[0] - r)
        found += np.outer(shift, shift)
    return found


def _varied(runs: tuple[Run, ...]) -> Iterator[tuple[Run, ...]]:
    """The runs with more creep of one wheel, then of the next, then across."""
    for j in range(max((run.creep.shape[1] for run in runs if len(run.creep)), default=0)):
        yield tuple(
            replace(run, turns=run.turns - run.creep_share * run.creep * (np.arange(run.creep.shape[1]) == j))
            if len(run.creep)
            else run
            for run in runs
        )
    if any(len(run.drift) for run in runs):
        yield tuple(replace(run, drift=(1.0 + run.creep_share) * run.drift) for run in runs)
