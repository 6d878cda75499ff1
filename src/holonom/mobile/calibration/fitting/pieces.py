"""Runs cut into pieces: how long a piece of a run should be for the surest numbers.

Where a base slips, errors of a path hang together: along a whole run its slips add up, and few of its samples tell
anything new. Each piece starts anew, at a pose of its own that is fitted with the parameters. Short pieces forget old
slip, but know less against the noise of the truth; between both lies the length that leaves the smallest deviations.
Whole runs that tell the numbers well enough stay whole: they are best against errors of the truth that are no noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from holonom.arrays import Array
from holonom.mobile.calibration.clocks import clock_of, on_the_clock_of_the_wheels
from holonom.mobile.calibration.fitting.noise import Noise, noise_of, sureness
from holonom.mobile.calibration.fitting.residuals import Problem, RunPart, path_lever, solve
from holonom.mobile.calibration.fitting.uncertainty import UNSEEN, noise_covariance, tightness
from holonom.mobile.calibration.runs import Run

__all__ = ["cut", "surest"]


SHORTEST = 32  # samples of a piece
HALVINGS = 6  # of the longest run
ENOUGH = 0.01  # deviation, of the parameters' scale, on the average: whole runs that tell as much are not cut
CLEAR = 0.7  # of the deviations on the average, that shorter pieces must leave to be taken


def cut(run: Run, samples: int) -> list[Run]:
    """Pieces of a run of about so many samples; each begins with the last sample of the one before."""
    count = max(1, round(len(run.time) / samples))
    edges = np.linspace(0, len(run.time) - 1, count + 1).astype(int)
    pieces = []
    for first, last in pairwise(edges.tolist()):
        part = slice(first, last + 1)
        turns = run.turns[part].copy()
        if first:
            turns[0] = 0.0  # what came before a piece is none of its own
        rest = Run(
            run.name, run.time[part], turns, run.truth[part], run.steering[part], drift=run.drift[part],
            creep=run.creep[part], creep_share=run.creep_share,
        )  # fmt: skip
        pieces.append(rest)
    return pieces


def surest(problem: Problem, x: Array, *, lever: float | None) -> Problem:
    """The same problem on pieces of its runs, as long as makes the parameters surest, by the noise that the runs show.

    Parameters
    ----------
    problem : of whole runs.
    x : (p,) their solution.
    lever : m/rad of headings; unless given, how far a piece leads from its start.
    """
    motion = problem.drive.motion(problem.values(x))
    runs = tuple(on_the_clock_of_the_wheels(run, clock_of(run, motion)) for run in problem.runs)
    problem = replace(problem, runs=runs)
    x = solve(problem, x)
    noise = noise_of(problem.parts(x))
    longest = max(len(run.time) for run in problem.runs)
    best = prepared(problem, x)
    least = _openness(best, best.parts(x), noise)
    for halving in range(1, HALVINGS + 1) if least > np.log(ENOUGH) else ():
        samples = longest // 2**halving
        if samples < SHORTEST:
            break
        pieces = tuple(piece for run in problem.runs for piece in cut(run, samples))
        own = path_lever(pieces) if lever is None else lever
        tried = prepared(replace(problem, runs=pieces, lever=own), x)
        left = _openness(tried, tried.parts(x), noise)
        if left < least + np.log(CLEAR):
            best, least = tried, left
    return best


def prepared(problem: Problem, x: Array) -> Problem:
    """The problem with what is known beforehand of each run's own start and clock, and of how wheels agree."""
    parts = problem.parts(x)
    known = replace(problem, sureness=sureness(parts, _periods(problem.runs)))
    return replace(known, tightness=tightness(known.parts(x) if parts[0].strain.shape[1] else parts))


def _periods(runs: Sequence[Run]) -> list[float]:
    return [float(np.median(np.diff(run.time))) for run in runs]


def _openness(problem: Problem, parts: Sequence[RunPart], noise: Noise) -> float:
    """Mean logarithm of the deviations of the parameters along the axes of their covariance; infinite where open."""
    s = np.linalg.svd(problem.weighted(parts)[1], compute_uv=False)
    if s[-1] <= UNSEEN * s[0]:
        return np.inf
    values = np.linalg.eigvalsh(noise_covariance(parts, noise, problem.tightness))
    return float(0.5 * np.log(np.maximum(values, 1e-300)).mean())
