"""The noise that runs show: a random walk of the base, white noise of the truth, and which runs they do not explain.

The base slips at random, white per way of its wheels, in both directions and in heading; the truth's place and heading
are noisy from sample to sample. The four intensities come from how what calibration leaves grows over spans of runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from holonom.arrays import Array
from holonom.mobile.calibration.fitting.residuals import SURE, RunPart

__all__ = ["Noise", "later", "misfit", "noise_of", "sureness"]


SURER = 100.0  # square of how much surer a start is by a way than by its first sample
SPANS = 4  # of the longest kind that a run has at least
CHANCE = 4.0  # times the square error that noise explains, which one run in a hundred exceeds by chance


class Noise(NamedTuple):
    """Intensities of the base's random walk per way of its wheels (m^2/rad, rad^2/rad), variances of the truth."""

    shift: float
    turn: float
    place: float
    heading: float


def noise_of(parts: Sequence[RunPart]) -> Noise:
    """The noise that the errors of odometry show, by how they grow from sample to sample and over longer spans.

    Over a span the base's own motion by the wheels less that by the truth has a variance that grows with the way where
    the base slips, and one that stays where the truth is noisy (Allan 1966). Its expectation is linear in the four
    intensities; spans of 1, 2, 4, ... samples are fitted, by nonnegative least squares.
    """
    rows, seen, counts = [], [], []
    for part in parts:
        truth = part.path - part.free_error
        for lag in _lags(len(truth)):
            at = np.arange(0, len(truth) - lag, max(1, lag // 4))
            ours, theirs = (_moved(poses, at, lag) for poses in (part.path, truth))
            way = np.cumsum(part.travel)
            travel, step = float(np.mean(way[at + lag] - way[at])), float(np.mean((ours[:, :2] ** 2).sum(axis=1)))
            bent = travel * step / 12.0  # what turns inside a span do to its chord, seen half-way round
            count = np.sqrt(max((len(truth) - lag) / lag, 1.0))
            for row, square in (
                ([2.0 * travel, bent, 4.0, 0.5 * step], ((ours - theirs)[:, :2] ** 2).sum(axis=1).mean()),
                ([0.0, travel, 0.0, 2.0], ((ours - theirs)[:, 2] ** 2).mean()),
            ):
                rows.append(row)
                seen.append(float(square))
                counts.append(count)
    b = np.maximum(seen, 1e-30)
    scale = np.array(counts) / b  # a variance scatters by as much as it is
    A = np.array(rows) * scale[:, None]
    size = np.linalg.norm(A, axis=0)
    size[size == 0.0] = 1.0
    found = nnls(A / size, b * scale)[0] / size
    return Noise(*(float(value) for value in found))


def sureness(parts: Sequence[RunPart], periods: Sequence[float]) -> Array:
    """Weights (runs, 4) of the squares of each run's start (x, y, heading) and clock (s).

    The truth's first sample knows the start to its own noise, all samples along the way much better; a clock is trusted
    to a period of the samples (`clock_of` finds larger offsets beforehand). Beside that stands what the base's walk
    makes of the errors: with hardly any noise the start is as good as known, without any walk it is free.

    Parameters
    ----------
    periods : (runs,) s.
    """
    q = noise_of(parts)
    white, rows = np.array([q.place, q.place, q.heading]), []
    for part, period in zip(parts, periods, strict=True):
        seen = float((part.weight * part.error**2).sum())
        walk = max(seen - float((part.weight * white).sum()), 0.0)
        rows.append(np.minimum(walk / np.maximum([*(SURER * white), period**2], 1e-30), SURE))
    return np.array(rows)


def misfit(parts: Sequence[RunPart], q: Noise) -> Array:
    """How many times (runs,) as noisy as all together each run is, by its errors; one where that may be chance.

    The weighted square error of a run beside its expectation: what noise q makes of it, less what the run's own start
    and clock take away. A clock that jumps, or wheels that scrub on the spot and roll elsewhere, are no noise of that
    kind, and a run that shows them tells less than it seems to.

    Source: Birge, Phys. Rev. 40, 1932: deviations are as large as external consistency shows, where that is the larger.
    """
    seen = np.array([(part.weight * part.free_error**2).sum() + (part.prior**2).sum() for part in parts])
    times = seen / np.maximum([_explained(part, q) for part in parts], 1e-300)
    return np.where(times > CHANCE, times, 1.0)


def _explained(part: RunPart, q: Noise) -> float:
    """Expectation of a run's weighted square error by noise."""
    w, (x, y) = part.weight, part.place.T
    white = np.array([q.place, q.place, q.heading])
    effects = part.own.effects * w[..., None]

    def left(size: Array, shared: Array) -> Array:
        """Weighted squares (N,) of effects, less what start and clock, by products (N, 4) with theirs, take away."""
        return np.asarray(size - np.einsum("ks,st,kt->k", shared, part.own.inverse, shared))

    by_shift, about = later(effects), later(x[:, None] * effects[:, 1] - y[:, None] * effects[:, 0])
    by_turn = about - x[:, None] * by_shift[:, 1] + y[:, None] * by_shift[:, 0] + by_shift[:, 2]
    all_later, far_x, far_y = later(w[:, 0]), later(w[:, 0] * x), later(w[:, 0] * y)
    swing = later(w[:, 0] * (x * x + y * y)) - 2.0 * (x * far_x + y * far_y) + (x * x + y * y) * all_later
    shifts = left(all_later, by_shift[:, 0]) + left(all_later, by_shift[:, 1])
    turns = left(swing + later(w[:, 2]), by_turn)
    rows = (effects * np.sqrt(white)[:, None]).reshape(-1, 4)
    alone = float(((rows @ part.own.inverse) * rows).sum())
    G = effects.reshape(-1, 4).T @ part.own.effects.reshape(-1, 4)
    start = white @ np.diagonal(G - G @ part.own.inverse @ G)[:3]  # the first pose, taken for true
    return float(part.travel @ (q.shift * shifts + q.turn * turns) + (w * white).sum() - alone + start)


def later(values: Array) -> Array:
    """Sums over this and all later samples."""
    return np.flip(np.cumsum(np.flip(values, 0), axis=0), 0)


def _lags(samples: int) -> list[int]:
    """Spans, in samples, of which a run has four or more."""
    return [2**k for k in range(int(np.log2(max(samples // SPANS, 1))) + 1)]


def _moved(poses: Array, at: NDArray[np.intp], lag: int) -> Array:
    """Motion (K, 3) over spans from samples (K,), in the frame half-way round."""
    step = poses[at + lag] - poses[at]
    middle = poses[at, 2] + 0.5 * step[:, 2]
    c, s = np.cos(middle), np.sin(middle)
    x, y, turn = step.T
    return np.stack([c * x + s * y, c * y - s * x, turn], axis=1)
