"""A run of a base with its ground truth, and how far odometry went astray on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError, NotFinite, ShapeError
from holonom.mobile.odometry import integrate

__all__ = ["Motion", "PathErrors", "Run", "dead_reckoning", "lever_of", "need_truth", "path_errors"]


_ROWS = ("time", "turns", "truth", "steering", "rate", "flow", "drift", "creep")


@dataclass(frozen=True, slots=True)
class Run:
    """One run; lists become arrays.

    Attributes
    ----------
    name : for messages.
    time : (N,) s.
    turns : (N, m) angle that each wheel turned in each sample, rad; the first sample holds what came before it, zeros.
    truth : (N, 3) x, y (m), theta (rad), of the base in the world at the end of each sample; (0, 3) where unknown.
    steering : (N, k) angle of each steered wheel in each sample, rad; k may be 0.
    rate : (N,) of a gyro, rad/s, where the run has one; (0,) otherwise.
    flow : (N, 2) counts of an optical sensor in each sample along its own x and y; (0, 2) where there is none.
    drift : (N, 3) by how much the base moved in each sample beside what its wheels rolled, m and rad, in its own axes,
        where that is known; (0, 3) where it is not.
    creep : (N, m) what was taken off the turns, rad, as they are known to creep; (0, m) where nothing was.
    creep_share : standard deviation of creep and drift, as a share of them: gears, loads and floors are not as stated.
    """

    name: str
    time: Array
    turns: Array
    truth: Array
    steering: Array
    rate: Array = field(default_factory=lambda: np.empty(0))
    flow: Array = field(default_factory=lambda: np.empty((0, 2)))
    drift: Array = field(default_factory=lambda: np.empty((0, 3)))
    creep: Array = field(default_factory=lambda: np.empty((0, 0)))
    creep_share: float = 0.3

    def __post_init__(self) -> None:
        for name in _ROWS:
            object.__setattr__(self, name, self._numbers(name))
        n = self.time.size if self.time.ndim == 1 else 0
        shapes = {"turns": self.turns.shape, "truth": self.truth.shape, "steering": self.steering.shape}
        rows_fit = all(len(s) == 2 and s[0] == n for s in (self.turns.shape, self.steering.shape))
        if n < 2 or self.truth.shape not in ((n, 3), (0, 3)) or not rows_fit:
            raise ShapeError(
                f"run {self.name}: {n} times, {', '.join(f'{k} {s}' for k, s in shapes.items())}; "
                "give two samples or more, (N, wheels), (N, 3) and (N, steered wheels)"
            )
        if self.rate.shape not in ((n,), (0,)) or self.flow.shape not in ((n, 2), (0, 2)):
            raise ShapeError(
                f"run {self.name}: rates {self.rate.shape} and flow {self.flow.shape}; give {n} rows, or none"
            )
        if self.drift.shape not in ((n, 3), (0, 3)):
            raise ShapeError(f"run {self.name}: a drift of shape {self.drift.shape}; give ({n}, 3), or none")
        if self.creep.size and self.creep.shape != self.turns.shape:
            raise ShapeError(f"run {self.name}: creep of shape {self.creep.shape}; give {self.turns.shape}, or none")
        for name in _ROWS:
            if not np.all(np.isfinite(getattr(self, name))):
                raise NotFinite(f"run {self.name}: {name} holds NaN or infinity; repair the log")

    def _numbers(self, name: str) -> Array:
        """Lists too."""
        try:
            return np.asarray(getattr(self, name), dtype=np.float64)
        except (TypeError, ValueError):
            raise ShapeError(f"run {self.name}: {name} holds no numbers, or rows of several lengths") from None

    @property
    def features(self) -> Array:
        """What a motion matrix turns into increments of the base: turns, or turns times cosine and sine of steering."""
        if self.steering.shape[1] == 0:
            return self.turns
        c, s = np.cos(self.steering), np.sin(self.steering)
        return np.concatenate([self.turns * c, self.turns * s], axis=1)

    @property
    def heading(self) -> Array:
        """(N,) heading of the truth without jumps of full turns, rad."""
        return np.unwrap(self.truth[:, 2])


@dataclass(frozen=True, slots=True)
class PathErrors:
    """Largest errors of odometry over runs; the arrays (runs,) hold each run's own.

    Attributes
    ----------
    distance, heading : largest on the way, m and rad.
    final_distance, final_heading : at the end, m and rad.
    """

    distances: Array
    headings: Array
    final_distances: Array
    final_headings: Array

    @property
    def distance(self) -> float:
        """Largest distance from the truth on the way, m."""
        return float(self.distances.max())

    @property
    def heading(self) -> float:
        """Largest heading error on the way, rad."""
        return float(self.headings.max())

    @property
    def final_distance(self) -> float:
        """Largest distance from the truth at the end of a run, m."""
        return float(self.final_distances.max())

    @property
    def final_heading(self) -> float:
        """Largest heading error at the end of a run, rad."""
        return float(self.final_headings.max())


@dataclass(frozen=True, slots=True)
class Motion:
    """How wheels move a base whose increments are no constant matrix times features.

    Attributes
    ----------
    increments : of a run, (N, 3), m and rad.
    lever : how far a wheel's way turns the base, m per rad.
    """

    increments: Callable[[Run], Array]
    lever: float


def lever_of(motion: Array | Motion) -> float:
    """How far a wheel's way turns the base, m per rad."""
    if isinstance(motion, Motion):
        return motion.lever
    return float(np.abs(motion[:2]).max() / max(np.abs(motion[2]).max(), 1e-12))


def dead_reckoning(run: Run, motion: Array | Motion, rule: str = "midpoint") -> Array:
    """Poses (N, 3) of a run by odometry from the truth's first pose, or zero.

    Parameters
    ----------
    motion : motion matrix (3, f), which turns features into increments, or a `Motion`.
    rule : of integration.
    """
    start = np.array([*run.truth[0, :2], run.heading[0]]) if len(run.truth) else np.zeros(3)
    if isinstance(motion, Motion) or len(run.drift):
        return integrate(increments_of(run, motion), start=start, rule=rule)
    return integrate(run.features, matrix=motion, start=start, rule=rule)


def increments_of(run: Run, motion: Array | Motion) -> Array:
    """Increments (N, 3) of a run by its wheels, and what it drifted beside them, m and rad."""
    found = motion.increments(run) if isinstance(motion, Motion) else run.features @ motion.T
    return found + run.drift if len(run.drift) else found


def need_truth(runs: Sequence[Run]) -> None:
    """Refuse runs without a truth to compare with.

    Raises
    ------
    CalibrationError
    """
    for run in runs:
        if not len(run.truth):
            raise CalibrationError(
                f"run {run.name} has no ground truth; record x, y, theta of the base beside its wheels"
            )


def path_errors(runs: Sequence[Run], paths: Sequence[Array]) -> PathErrors:
    """Compare paths (N, 3) of runs with their truth; headings are compared on the circle.

    Raises
    ------
    CalibrationError
        No run.
    """
    if not runs:
        raise CalibrationError("no run came; give one or more")
    need_truth(runs)
    distance, heading = [], []
    for run, path in zip(runs, paths, strict=True):
        distance.append(np.hypot(*(run.truth[:, :2] - path[:, :2]).T))
        turn = run.truth[:, 2] - path[:, 2]
        heading.append(np.abs(np.arctan2(np.sin(turn), np.cos(turn))))
    return PathErrors(
        np.array([d.max() for d in distance]), np.array([h.max() for h in heading]),
        np.array([d[-1] for d in distance]), np.array([h[-1] for h in heading]),
    )  # fmt: skip
