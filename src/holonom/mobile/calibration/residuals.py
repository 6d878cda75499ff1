"""What least squares makes small: errors of the pose along the runs and at their ends, with their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from holonom.arrays import Array
from holonom.mobile.calibration.parameters import DriveParameters
from holonom.mobile.calibration.runs import Run
from holonom.mobile.odometry.integrate import rule_named
from holonom.mobile.odometry.kernels import sensitivities_into

__all__ = ["Problem", "RunPart", "path_lever", "solve"]


EVALUATIONS = 60  # of the residuals; a determined problem takes about ten


@dataclass(frozen=True, slots=True)
class RunPart:
    """One run at one set of parameters.

    Attributes
    ----------
    error : (N, 3) pose by odometry minus truth; headings without jumps.
    slope : (N, 3, p) its derivatives by the scaled parameters.
    weight : (N, 3) of the squares.
    travel : (N,) mean way of the wheels in each sample, rad.
    place : (N, 2) of the truth, m.
    """

    error: Array
    slope: Array
    weight: Array
    travel: Array
    place: Array


@dataclass(frozen=True, slots=True)
class Problem:
    """Runs, a drive's parameters and weights; the unknown is `x` (p,), `p = nominal + scale x`.

    Every run counts alike: the mean square along it, and `final_weight` squared times the square at its end; headings
    are multiplied by `lever`, m/rad.
    """

    runs: tuple[Run, ...]
    drive: DriveParameters
    rule: str
    lever: float
    final_weight: float

    def values(self, x: Array) -> Array:
        """Parameters (p,) of an unknown."""
        return self.drive.nominal + self.drive.scale * x

    def parts(self, x: Array) -> list[RunPart]:
        """Every run at `x`."""
        p = self.values(x)
        M, dM = np.ascontiguousarray(self.drive.matrix(p)), self.drive.slopes(p) * self.drive.scale
        flat = dM.reshape(-1, len(p))
        return [self._part(run, M, flat) for run in self.runs]

    def residuals(self, x: Array) -> tuple[Array, Array]:
        """Weighted errors (n,) and their derivatives (n, p)."""
        parts = self.parts(x)
        roots = [np.sqrt(part.weight) for part in parts]
        r = np.concatenate([(part.error * w).ravel() for part, w in zip(parts, roots, strict=True)])
        J = np.concatenate([(q.slope * w[..., None]).reshape(-1, len(x)) for q, w in zip(parts, roots, strict=True)])
        return r, J

    def _part(self, run: Run, M: Array, dM: Array) -> RunPart:
        share, exact = rule_named(self.rule)
        features = np.ascontiguousarray(run.features)
        n, m = features.shape
        poses, slopes = np.empty((n, 3)), np.empty((n, 3, 3 * m))
        start = np.array([*run.truth[0, :2], run.heading[0]])
        sensitivities_into(features, M, start, share, exact, poses, slopes)
        error = poses - run.truth
        error[:, 2] = poses[:, 2] - run.heading
        weight = np.full(n, 1.0 / n)
        weight[-1] += self.final_weight**2
        weight = weight[:, None] * np.array([1.0, 1.0, self.lever**2]) / len(self.runs)
        return RunPart(error, slopes @ dM, weight, np.abs(run.turns).mean(axis=1), run.truth[:, :2])


def path_lever(runs: Sequence[Run]) -> float:
    """Largest distance of the truth from the start of its run, m: how far a heading error swings the path's far end."""
    reach = [float(np.max(np.hypot(*(run.truth[:, :2] - run.truth[0, :2]).T))) for run in runs]
    return max(reach)


def solve(problem: Problem, start: Array) -> Array:
    """Least squares (p,) from a start, by Levenberg and Marquardt."""
    found = optimize.least_squares(
        lambda x: problem.residuals(x)[0], start, jac=lambda x: problem.residuals(x)[1], method="lm",
        xtol=1e-10, ftol=1e-10, max_nfev=EVALUATIONS,
    )  # fmt: skip
    x: Array = found.x
    return x
