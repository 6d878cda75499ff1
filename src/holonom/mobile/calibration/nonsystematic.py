"""What no calibration takes away: how far ends of repeated runs scatter, and what bumps add."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError
from holonom.mobile.calibration.runs import Motion, Run, dead_reckoning, need_truth

__all__ = ["EndScatter", "end_scatter"]


SAME = 0.1  # share of way and turn by which runs of one course may differ, and of a full turn


@dataclass(frozen=True, slots=True)
class EndScatter:
    """Errors of odometry at the ends of runs, apart from what all runs of a course have in common.

    Attributes
    ----------
    courses : (runs,) which runs drove the same, numbered from 0.
    ends : (runs, 3) truth minus odometry at the end, in the frame of the start: x, y, m, and heading, rad.
    common : (courses, 3) mean of the ends of each course, of runs without bumps: the systematic part.
    covariance : (3, 3) of an end about its course's mean, of runs without bumps, pooled; NaN where no course was driven
        twice.
    spread : m, root mean square distance of an end from its course's mean: E_nonsys; NaN likewise.
    bump : rad, mean over the courses of the mean distance of headings of runs over bumps from the course's common one,
        summed over both ways as in the source; NaN without such runs.
    """

    courses: tuple[int, ...]
    ends: Array
    common: Array
    covariance: Array
    spread: float
    bump: float


def end_scatter(
    runs: Sequence[Run], motion: Array | Motion, *, bumped: Sequence[str] = (), rule: str = "midpoint"
) -> EndScatter:
    """Measure the non-systematic errors of odometry.

    Parameters
    ----------
    runs : with the truth; some driven several times.
    motion : that of the base, best the calibrated one.
    bumped : names of runs that went over bumps.
    rule : of integration.

    Raises
    ------
    CalibrationError
        No run, or one without truth; bumped runs without plain ones of their course.

    Source: Borenstein, Everett, Feng, Where am I? Sensors and methods for mobile robot positioning, 1996, 5.2: the
    scatter about the centres of gravity, and the extended UMBmark, which compares headings behind bumps with those
    without, `mean |eps - mean eps_sys|` of each way, added.
    """
    if not runs:
        raise CalibrationError("no run came; give some that were driven several times")
    need_truth(runs)
    ends = np.stack([_end(run, motion, rule) for run in runs])
    courses = _courses(runs)
    rough = np.array([run.name in bumped for run in runs])
    count = max(courses) + 1
    of = np.array(courses)
    common = np.full((count, 3), np.nan)
    for k in range(count):
        plain = ends[(of == k) & ~rough]
        if not len(plain):
            names = ", ".join(run.name for run, course in zip(runs, courses, strict=True) if course == k)
            raise CalibrationError(
                f"runs {names} went over bumps and none of that course did not; drive it plainly too"
            )
        common[k] = plain.mean(axis=0)
    rest = (ends - common[of])[~rough]
    free = len(rest) - count
    covariance = rest.T @ rest / free if free > 0 else np.full((3, 3), np.nan)
    return EndScatter(courses, ends, common, covariance, float(np.sqrt(covariance[0, 0] + covariance[1, 1])),
                      _bump(ends, common, of, rough))  # fmt: skip


def _bump(ends: Array, common: Array, of: Array, rough: Array) -> float:
    if not rough.any():
        return float("nan")
    courses = np.unique(of[rough])
    return float(sum(np.abs(ends[(of == k) & rough, 2] - common[k, 2]).mean() for k in courses))


def _end(run: Run, motion: Array | Motion, rule: str) -> Array:
    """Truth minus odometry at the end, in the frame of the start."""
    path = dead_reckoning(run, motion, rule)
    x, y, turn = run.truth[-1, 0] - path[-1, 0], run.truth[-1, 1] - path[-1, 1], run.heading[-1] - path[-1, 2]
    c, s = np.cos(run.heading[0]), np.sin(run.heading[0])
    return np.array([c * x + s * y, c * y - s * x, turn])


def _courses(runs: Sequence[Run]) -> tuple[int, ...]:
    """Runs that came as far, turned as much and ended at the same place from their start count as one course."""
    seen: list[Array] = []
    found = []
    for run in runs:
        steps = np.diff(run.truth[:, :2], axis=0)
        way, turn = float(np.hypot(*steps.T).sum()), float(run.heading[-1] - run.heading[0])
        c, s = np.cos(run.heading[0]), np.sin(run.heading[0])
        x, y = run.truth[-1, :2] - run.truth[0, :2]
        mark = np.array([c * x + s * y, c * y - s * x, turn])
        size = SAME * np.array([max(way, 1e-3), max(way, 1e-3), 2.0 * np.pi])
        at = next((k for k, known in enumerate(seen) if np.all(np.abs(known - mark) < size)), len(seen))
        if at == len(seen):
            seen.append(mark)
        found.append(at)
    return tuple(found)
