"""Largest errors held within limits: of all parameters that keep them, those with the least sum of squares.

Four errors are reported, each the largest over the runs: distance and heading on the way, and at the end. Around the
least squares solution, with `H = J^T W J`, parameters are `x + B y`, `B^T H B = 1`: the sum of squares grows by
`|y|^2`. What is looked for is the shortest y with every error of every sample below its limit.

Source: least distance programming, Lawson & Hanson, Solving Least Squares Problems, 1974, chapter 23, repeated where
errors are linearised anew (headings are linear in the motion matrix, distances nearly).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from holonom.arrays import Array
from holonom.mobile.calibration.fitting.residuals import Problem, RunPart, solve

__all__ = ["attainable", "classical", "largest_errors", "within"]


PASSES = 30  # linearisations; three to six are usual
NEAR = 0.5  # share of its limit above which an error is watched
MARGIN = 1e-7  # by which limits are kept
FINEST = 1e-6  # m per m of the lever, and rad: smaller errors are rounding
HEAVIEST = 1e3  # weight of the ends beside the way, where nothing else is told
SACRIFICE = 0.125  # share by which a classical calibration may spoil the way for the sake of the ends


@dataclass(frozen=True, slots=True)
class _Errors:
    """Errors (n,) of all samples, their derivatives (n, p), and which of the four each one is."""

    value: Array
    slope: Array
    kind: NDArray[np.intp]


def classical(problem: Problem) -> Array:
    """Physical parameters (p,) as closed forms calibrate them: by the ends of the runs.

    The ends weigh as heavily as they can while the errors on the way grow by no more than `SACRIFICE`: ends alone leave
    open what a closed path does not tell, the size of the wheels.

    Parameters
    ----------
    problem : of physical parameters.
    """
    even = replace(problem, final_weight=1.0)
    x = solve(even, np.zeros(len(problem.drive.names)))
    return solve(replace(problem, final_weight=_heavy_ends(even, x)), x)


def largest_errors(problem: Problem, x: Array) -> Array:
    """Largest errors (4,) over the runs: distance and heading on the way, and at the end; m and rad."""
    errors = _errors(problem.parts(x))
    return np.array([errors.value[errors.kind == kind].max() for kind in range(4)])


def attainable(problem: Problem, limits: Array) -> Array:
    """Limits (4,) none of which is below what rounding leaves of an error."""
    return np.maximum(limits, FINEST * np.array([problem.lever, 1.0, problem.lever, 1.0]))


def within(problem: Problem, x: Array, limits: Array) -> Array | None:
    """Parameters that keep limits and are nearest to least squares; None where there are none.

    Parameters
    ----------
    x : (p,) solution by least squares.
    limits : (4,) of distance and heading on the way, and at the end; m and rad, infinite where free.
    """
    B, y = _natural(problem, x), np.zeros(len(x))
    for _ in range(PASSES):
        errors = _errors(problem.parts(x + B @ y))
        share = errors.value / limits[errors.kind]
        if share.max() <= 1.0:
            return x + B @ y
        near = share > NEAR
        G = errors.slope[near] @ B / limits[errors.kind[near]][:, None]
        shortest = _shortest(G, 1.0 - MARGIN - share[near] + G @ y)
        if shortest is None:
            return None
        y = shortest
    return None


def _heavy_ends(problem: Problem, x: Array) -> float:
    """Weight of the ends, by bisection on the linearised problem."""
    r, J = problem.residuals(x)
    way, slope = replace(problem, final_weight=0.0).residuals(x)
    H, g = slope.T @ slope, slope.T @ way
    H_ends, g_ends = J.T @ J - H, J.T @ r - g

    def growth(weight: float) -> float:
        step = -np.linalg.lstsq(H + weight**2 * H_ends, g + weight**2 * g_ends, rcond=None)[0]
        return float(2.0 * g @ step + step @ H @ step) - SACRIFICE * (2.0 + SACRIFICE) * float(way @ way)

    low, high = 0.0, np.log(HEAVIEST)
    if growth(HEAVIEST) <= 0.0:
        return HEAVIEST
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth(float(np.exp(middle))) <= 0.0 else (low, middle)
    return float(np.exp(low))


def _natural(problem: Problem, x: Array) -> Array:
    """B (p, p): along its columns the sum of squares grows by one."""
    _, s, Vt = np.linalg.svd(problem.residuals(x)[1], full_matrices=False)
    return np.asarray(Vt.T / s)


def _shortest(G: Array, h: Array) -> Array | None:
    """Shortest y with `G y <= h`, by nonnegative least squares of the dual problem; None where none is found."""
    n = G.shape[1]
    E = np.vstack([-G.T, -h])
    last = np.append(np.zeros(n), 1.0)
    try:
        residual = E @ nnls(E, last, maxiter=30 * E.shape[1])[0] - last
    except RuntimeError:  # too many iterations
        return None
    return None if residual[n] > -1e-12 else np.asarray(-residual[:n] / residual[n])


def _errors(parts: Sequence[RunPart]) -> _Errors:
    values, slopes, kinds = [], [], []
    for part in parts:
        (x, y, turn), J = part.error.T, part.slope
        distance = np.hypot(x, y)
        away = np.maximum(distance, 1e-300)
        by_place = (x / away)[:, None] * J[:, 0] + (y / away)[:, None] * J[:, 1]
        by_turn = np.sign(turn)[:, None] * J[:, 2]
        values += [distance, np.abs(turn), distance[-1:], np.abs(turn[-1:])]
        slopes += [by_place, by_turn, by_place[-1:], by_turn[-1:]]
        kinds += [np.full(len(v), kind) for kind, v in enumerate(values[-4:])]
    return _Errors(np.concatenate(values), np.concatenate(slopes), np.concatenate(kinds))
