"""What least squares makes small: errors of the pose along the runs and at their ends, with their derivatives.

Each run has four unknowns of its own, which are fitted and forgotten: the pose at its start, which the truth measures
no better than any other, and the offset of the truth's clock. They enter linearly, so they are projected out (Golub &
Pereyra, variable projection, 1973, in Kaufman's form), together with rows that say how sure they are beforehand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from holonom.arrays import Array
from holonom.mobile.calibration.parameters import Parameters
from holonom.mobile.calibration.runs import Run
from holonom.mobile.odometry.integrate import rule_named
from holonom.mobile.odometry.kernels import sensitivities_into

__all__ = ["SURE", "Problem", "RunPart", "path_lever", "solve"]


BLOCK = 16  # samples
TOLD = 1e-4  # share of an effect that must be its own: less of it is rounding
SURE = 1e12  # weight of what is as good as known
EVALUATIONS = 30  # of the residuals; a determined problem takes about ten


@dataclass(frozen=True, slots=True)
class RunPart:
    """One run at one set of parameters.

    Attributes
    ----------
    error : (N, 3) pose by odometry minus truth; headings without jumps.
    slope : (N, 3, p) its derivatives by the scaled parameters.
    free_error, free_slope : the same less what another start and another clock of the truth take away.
    prior, prior_slope : (4,), (4, p) what these cost, weighted, and its derivatives.
    own : what the run's own start and clock do to the errors.
    path : (N, 3) poses by odometry.
    weight : (N, 3) of the squares.
    strain, strain_slope : (B, k) what wheels count beyond any motion, rad, added up over `BLOCK` samples each, and its
        derivatives (B, k, p): over them what encoders round is no noise, and noisy angles bend little.
    travel : (N,) mean way of the wheels in each sample, rad.
    place : (N, 2) of the truth, m.
    """

    error: Array
    slope: Array
    free_error: Array
    free_slope: Array
    prior: Array
    prior_slope: Array
    own: Own
    path: Array
    weight: Array
    strain: Array
    strain_slope: Array
    travel: Array
    place: Array

    @property
    def clock(self) -> float:
        """Offset of the truth's clock behind that of the wheels, s; NaN where the motion does not tell it."""
        return self.own.clock(self.error)


@dataclass(frozen=True, slots=True)
class Problem:
    """Runs, a drive's parameters and weights; the unknown is `x` (p,), `p = nominal + scale x`.

    Every run counts alike: the mean square along it, and `final_weight` squared times the square at its end; headings
    are multiplied by `lever`, m/rad. `sureness` (runs, 4) are weights of the squares of each run's own unknowns (x, y,
    heading of its start, s of its clock), large where they are known beforehand. `tightness` (k,) are weights of the
    squares of what wheels count beyond any motion, in every block; nothing unless given.
    """

    runs: tuple[Run, ...]
    drive: Parameters
    rule: str
    lever: float
    final_weight: float
    sureness: Array | None = None
    tightness: Array | None = None

    def values(self, x: Array) -> Array:
        """Parameters (p,) of an unknown."""
        return self.drive.nominal + self.drive.scale * x

    def parts(self, x: Array) -> list[RunPart]:
        """Every run at `x`."""
        sure = np.full((len(self.runs), 4), SURE) if self.sureness is None else self.sureness
        p = self.values(x)
        return [self._part(run, p, own) for run, own in zip(self.runs, sure, strict=True)]

    def residuals(self, x: Array) -> tuple[Array, Array]:
        """Weighted errors (n,) and their derivatives (n, p)."""
        return self.weighted(self.parts(x))

    def weighted(self, parts: Sequence[RunPart]) -> tuple[Array, Array]:
        """The same of every run at one unknown."""
        p = len(self.drive.names)
        roots = [np.sqrt(part.weight) for part in parts]
        r, J = [], []
        for part, root in zip(parts, roots, strict=True):
            r += [(part.free_error * root).ravel(), part.prior]
            J += [(part.free_slope * root[..., None]).reshape(-1, p), part.prior_slope]
            if self.tightness is not None and part.strain.shape[1]:
                tight = np.sqrt(self.tightness)
                r.append((part.strain * tight).ravel())
                J.append((part.strain_slope * tight[:, None]).reshape(-1, p))
        return np.concatenate(r), np.concatenate(J)

    def _part(self, run: Run, p: Array, sure: Array) -> RunPart:
        share, exact = rule_named(self.rule)
        at, scale = self.drive.sampled(run, p), self.drive.scale
        n = len(at.increments)
        poses, slope = np.empty((n, 3)), np.empty((n, 3, len(p)))
        heading = run.heading
        start = np.array([*run.truth[0, :2], heading[0]])
        increments = at.increments + run.drift if len(run.drift) else at.increments
        sensitivities_into(increments, at.slopes * scale, start, share, exact, poses, slope)
        error = poses - run.truth
        error[:, 2] = poses[:, 2] - heading
        weight = np.full(n, 1.0 / n)
        weight[-1] += self.final_weight**2
        weight = weight[:, None] * np.array([1.0, 1.0, self.lever**2]) / len(self.runs)
        own = _own(run, poses, np.sqrt(weight), sure)
        (free_error, prior), (free_slope, prior_slope) = own.freed(error[..., None]), own.freed(slope)
        travel = np.abs(run.turns).mean(axis=1)
        blocks = np.arange(0, n, BLOCK)
        strain, by_strain = (np.add.reduceat(rows, blocks, axis=0) for rows in (at.strain, at.strain_slopes * scale))
        return RunPart(
            error, slope, free_error[..., 0], free_slope, prior[:, 0], prior_slope, own, poses, weight, strain,
            by_strain, travel, run.truth[:, :2],
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Own:
    """Unknowns of one run: effects (N, 3, 4), roots of weights (N, 3); the inverse of their normal matrix (4, 4)."""

    effects: Array
    root: Array
    inverse: Array
    sure: Array

    def freed(self, values: Array) -> tuple[Array, Array]:
        """Values (N, 3, k) less what the run's own unknowns explain of them, weighted; and what these cost (4, k)."""
        weighted = (self.effects * self.root[..., None] ** 2).reshape(-1, 4)
        found = self.inverse @ (weighted.T @ values.reshape(-1, values.shape[2]))
        return values - self.effects @ found, -np.sqrt(self.sure)[:, None] * found

    def clock(self, error: Array) -> float:
        """Offset of the truth's clock, s, by errors (N, 3); NaN where another start would look the same."""
        weighted = (self.effects * self.root[..., None] ** 2).reshape(-1, 4)
        G, g = weighted.T @ self.effects.reshape(-1, 4), weighted.T @ error.ravel()
        by_start = np.linalg.lstsq(G[:3, :3], G[:3, 3], rcond=None)[0]
        alone = float(G[3, 3] - by_start @ G[:3, 3])
        return float(g[3] - by_start @ g[:3]) / alone if alone > TOLD**2 * float(G[3, 3]) else float("nan")


def _own(run: Run, poses: Array, root: Array, sure: Array) -> Own:
    """What another start (x, y, heading) and a later clock of the truth do to the errors of a run."""
    effects = np.zeros((len(poses), 3, 4))
    effects[:, 0, 0] = effects[:, 1, 1] = effects[:, 2, 2] = 1.0
    effects[:, 0, 2], effects[:, 1, 2] = poses[0, 1] - poses[:, 1], poses[:, 0] - poses[0, 0]
    effects[:, :, 3] = np.gradient(poses, run.time, axis=0)
    flat = (effects * root[..., None]).reshape(-1, 4)
    normal = flat.T @ flat + np.diag(sure)
    size = np.sqrt(np.maximum(np.diagonal(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(size, size))
    told = np.where(values > TOLD**2 * values[-1], values, np.inf)
    inverse = (vectors / told) @ vectors.T / np.outer(size, size)
    return Own(effects, root, inverse, sure)


def path_lever(runs: Sequence[Run]) -> float:
    """Largest distance of the truth from the start of its run, m: how far a heading error swings the path's far end."""
    reach = [float(np.max(np.hypot(*(run.truth[:, :2] - run.truth[0, :2]).T))) for run in runs]
    return max(reach)


def solve(problem: Problem, start: Array) -> Array:
    """Least squares (p,) from a start, by Levenberg and Marquardt."""
    last: dict[bytes, tuple[Array, Array]] = {}

    def at(x: Array) -> tuple[Array, Array]:
        """Residuals and derivatives come together: the second question for the same x costs nothing."""
        if x.tobytes() not in last:
            last.clear()
            last[x.tobytes()] = problem.residuals(x)
        return last[x.tobytes()]

    found = optimize.least_squares(
        lambda x: at(x)[0], start, jac=lambda x: at(x)[1], method="lm",
        xtol=1e-10, ftol=1e-10, max_nfev=EVALUATIONS,
    )  # fmt: skip
    x: Array = found.x
    return x
