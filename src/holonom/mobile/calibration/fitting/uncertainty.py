"""How sure calibrated numbers are, and which the motion leaves open.

Errors of odometry along a path hang together: each slip shifts and turns all that follows. Counting every sample as
news would promise far too much. Here the noise is a random walk of the base, white per way of the wheels, in both
directions and in heading, beside white noise of the truth's place and heading; their four intensities come from how
what calibration leaves grows over spans of the runs. With `H = J^T W J`, an estimate moves by `H^-1 S_i` when the base
slips in sample i, where S_i sums `J^T W` times the shift over all later samples; J is what is left of the derivatives
without the run's own start and clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from holonom.arrays import Array
from holonom.errors import CalibrationError
from holonom.mobile.calibration.fitting.residuals import SURE, RunPart
from holonom.mobile.calibration.parameters import Parameters

__all__ = ["Noise", "check_excitation", "noise_covariance", "noise_of", "sureness", "tightness"]


SURER = 100.0  # square of how much surer a start is by a way than by its first sample
SPANS = 4  # of the longest kind that a run has at least
UNSEEN = 1e-7  # relative singular value below which a combination has no effect at all
OPEN = 0.3  # standard deviation of a combination, relative to the parameters' scale, above which it is left open
MOST = 4  # names in a message
FINEST = 2e-4  # share of its way that a wheel is trusted to, whatever its strain
LEAST = 1e-5  # share of its way that a parameter must change of a wheel for its strain to tell anything
NAMED = 0.05  # share of a parameter in such a combination above which it is named

ADVICE = {
    "diameter": "drive a longer way, straight and with turns",
    "radius": "drive a longer way, straight and with turns",
    "track": "turn, on the spot or on circles, to the left and to the right",
    "effective_track": "turn, on the spot or on circles, to the left and to the right",
    "centre": "turn, on the spot or on circles, to the left and to the right",
    "zero": "drive straight, and turn to both sides",
    "steering_gear": "steer far to both sides",
    "x_": "turn to the left and to the right, and drive sideways",
    "y_": "turn to the left and to the right, and drive straight",
    "wheelbase": "turn, on the spot or on circles, to the left and to the right",
    "wheelbase_plus_track": "turn on the spot or on circles, to the left and to the right",
    "wheel_distance": "turn on the spot or on circles, to the left and to the right",
    "lever": "turn to the left and to the right, and drive straight",
    "direction": "drive forwards and sideways, turning little",
    "steering_offset": "drive straight, and turn to both sides",
    "frame": "turn to the left and to the right, on circles of several sizes",
    "roller_angle": "drive sideways as well as forwards",
}


@dataclass(frozen=True, slots=True)
class _Scores:
    """Effect of a shift (N, p, 2) and of a turn (N, p) in each sample on `J^T W e`."""

    shift: Array
    turn: Array


def noise_covariance(parts: Sequence[RunPart], noise: Noise | None = None, tight: Array | None = None) -> Array:
    """Covariance (p, p) of the scaled parameters at the least squares solution, by the noise that the parts show.

    Parameters
    ----------
    noise : that of the base and the truth, where it is known from elsewhere.
    tight : (k,) weights of the squares of what wheels count beyond any motion, which is white from block to block, and
        not alone among the wheels: each slip shows in the strain of all.

    Source: the usual sandwich `H^-1 S H^-1` (White 1980), with S of the noise above.
    """
    H, S = _normal(parts, noise)
    if tight is not None and len(tight):
        own = _strains(parts)
        for part in parts:
            J = part.strain_slope * tight[:, None]
            H += np.einsum("bkp,bkq->pq", part.strain_slope, J)
            S += np.einsum("bkp,kl,blq->pq", J, own, J, optimize=True)
    inverse = np.linalg.pinv(H, rcond=UNSEEN**2, hermitian=True)
    return np.asarray(inverse @ S @ inverse)


def tightness(parts: Sequence[RunPart]) -> Array:
    """Weights (k,) of the squares of what wheels count beyond any motion, beside the paths: as sure as they show to be.

    A unit of weight stands for the variance that paths have in it, the mean of the eigenvalues of `H^-1 S`.
    """
    k = parts[0].strain.shape[1]
    if k == 0:
        return np.empty(0)
    H, S = _normal(parts, None)
    told = np.linalg.eigvalsh(H)
    unit = float(np.trace(np.linalg.pinv(H, rcond=UNSEEN**2, hermitian=True) @ S))
    unit /= max(int(np.count_nonzero(told > UNSEEN**2 * told[-1])), 1)
    unit = max(unit, (FINEST * float(np.mean([_way(part) for part in parts]))) ** 2)
    effect = np.max([np.abs(part.strain_slope).max(axis=(0, 2)) for part in parts], axis=0)
    told_by = effect > LEAST * max(float(part.travel.max()) for part in parts)
    return np.where(told_by, unit / np.maximum(np.diagonal(_strains(parts)), 1e-300), 0.0)


def _way(part: RunPart) -> float:
    """Way of a run, m, turns counted by the lever of its weights."""
    steps, lever = np.diff(part.path, axis=0), float(np.sqrt(part.weight[0, 2] / part.weight[0, 0]))
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum() + lever * np.abs(steps[:, 2]).sum())


def _strains(parts: Sequence[RunPart]) -> Array:
    """Covariance (k, k), rad^2, of what wheels count beyond any motion, in a block."""
    count, (k, p) = sum(len(part.strain) for part in parts), parts[0].strain_slope.shape[1:]
    seen = np.sum([part.strain.T @ part.strain for part in parts], axis=0) / (count - min(p / k, 0.5 * count))
    way = sum(float(part.travel.sum()) for part in parts) / count
    return np.asarray(seen + (FINEST * way) ** 2 * np.eye(k))


def _normal(parts: Sequence[RunPart], noise: Noise | None) -> tuple[Array, Array]:
    """`J^T W J` (p, p) of the paths, and the covariance of `J^T W e`."""
    q = noise_of(parts) if noise is None else noise
    p = parts[0].slope.shape[2]
    H, S = np.zeros((p, p)), np.zeros((p, p))
    for part in parts:
        J, w = part.free_slope, part.weight
        H += np.einsum("kcp,kc,kcq->pq", J, w, J, optimize=True)
        scores = _scores(part)
        walk = _outer(scores, scores, part.travel)
        S += q.shift * walk[0] + q.turn * walk[1]
        white = np.array([q.place, q.place, q.heading])
        S += np.einsum("kcp,kc,kcq->pq", J, w**2 * white, J, optimize=True)
        H += part.prior_slope.T @ part.prior_slope
        start = np.einsum("kcp,kc,kcs->ps", J, w, part.start_effect, optimize=True)  # of the first pose, taken for true
        S += (start * white) @ start.T
    return H, S


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


def check_excitation(
    J: Array, drive: Parameters, covariance: Array | None = None, suggest: Callable[[Array], str] = lambda v: ""
) -> Array:
    """Singular values (p,) of the weighted, scaled Jacobian, largest first; refuse a motion that leaves any open.

    Parameters
    ----------
    J : (n, p) Jacobian of the weighted errors by the scaled parameters.
    covariance : (p, p) of the scaled parameters; without it only combinations without any effect are refused.
    suggest : what else to say of the worst combination (p,).

    Raises
    ------
    CalibrationError
        It names the parameters, and the motion that would tell them.
    """
    _, s, Vt = np.linalg.svd(J, full_matrices=False)
    lost = s <= UNSEEN * s[0]
    if covariance is not None:
        values, vectors = np.linalg.eigh(covariance)
        wide = values > OPEN**2
        lost, Vt = np.concatenate([lost, wide]), np.concatenate([Vt, vectors.T])
    if not lost.any():
        return np.asarray(s)
    share = np.abs(Vt[lost]).max(axis=0)
    named = [name for name, part in zip(drive.names, share, strict=True) if part > NAMED * share.max()]
    raise CalibrationError(_open(named, drive.set) + suggest(Vt[lost][-1]))


def _open(named: Sequence[str], set_name: str) -> str:
    """What the motion leaves open, and what to do."""
    todo = "; ".join(dict.fromkeys(_advice(name) for name in named))
    if len(named) == 1:
        return f"the motion tells nothing of {named[0]}: {todo}"
    shown = ", ".join(named[:MOST]) + (f" and {len(named) - MOST} more" if len(named) > MOST else "")
    instead = ", or calibrate the physical set" if set_name != "physical" else ""
    return f"the motion does not tell {shown} apart: {todo}{instead}"


def _advice(name: str) -> str:
    known = [key for key in sorted(ADVICE, key=len, reverse=True) if name.startswith(key)]
    return ADVICE[known[0]]


def _scores(part: RunPart) -> _Scores:
    """What a shift or a turn in sample i does to `J^T W e`, summed over the samples from i on."""
    J, w, (x, y) = part.free_slope, part.weight, part.place.T
    shift = _later(J[:, :2].transpose(0, 2, 1) * w[:, None, :2])
    swing = _later(w[:, :1] * (x[:, None] * J[:, 1] - y[:, None] * J[:, 0]))
    turn = swing - (x[:, None] * shift[..., 1] - y[:, None] * shift[..., 0])
    return _Scores(shift, turn + _later(w[:, 2:] * J[:, 2]))


def _later(values: Array) -> Array:
    """Sums over this and all later samples."""
    return np.flip(np.cumsum(np.flip(values, 0), axis=0), 0)


def _outer(a: _Scores, b: _Scores, travel: Array) -> Array:
    """(2, p, p): for unit shifts, for unit turns."""
    return np.stack(
        [
            np.einsum("kpd,k,kqd->pq", a.shift, travel, b.shift, optimize=True),
            np.einsum("kp,k,kq->pq", a.turn, travel, b.turn, optimize=True),
        ]
    )
