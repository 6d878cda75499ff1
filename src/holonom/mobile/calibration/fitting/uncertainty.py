"""How sure calibrated numbers are, and which the motion leaves open.

Errors of odometry along a path hang together: each slip shifts and turns all that follows. Counting every sample as
news would promise far too much. Here the noise is a random walk of the base, white per way of the wheels, in both
directions and in heading, beside white noise of the truth's place and heading (`noise`). With `H = J^T W J`, an
estimate moves by `H^-1 S_i` when the base slips in sample i, where S_i sums `J^T W` times the shift over all later
samples; J is what is left of the derivatives without the run's own start and clock.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError
from holonom.mobile.calibration.fitting.noise import Noise, later, misfit, noise_of
from holonom.mobile.calibration.fitting.residuals import RunPart
from holonom.mobile.calibration.parameters import Parameters

__all__ = ["check_excitation", "noise_covariance", "tightness"]


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

    A run that is missed by more than that explains is taken for as much noisier (`misfit`).

    Parameters
    ----------
    noise : that of the base and the truth, where it is known from elsewhere; every run is then as noisy as that.
    tight : (k,) weights of the squares of what wheels count beyond any motion, which is white from block to block, and
        not alone among the wheels: each slip shows in the strain of all.

    Source: the usual sandwich `H^-1 S H^-1` (White 1980), with S of the noise above.
    """
    q = noise_of(parts) if noise is None else noise
    H, S = _normal(parts, q, misfit(parts, q) if noise is None else np.ones(len(parts)))
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
    H, S = _normal(parts, noise_of(parts), np.ones(len(parts)))
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


def _normal(parts: Sequence[RunPart], q: Noise, times: Array) -> tuple[Array, Array]:
    """`J^T W J` (p, p) of the paths, and the covariance of `J^T W e`, of runs so many times (runs,) as noisy as q."""
    p = parts[0].slope.shape[2]
    H, S = np.zeros((p, p)), np.zeros((p, p))
    white = np.array([q.place, q.place, q.heading])
    for part, worse in zip(parts, times, strict=True):
        J = part.free_slope.reshape(-1, p)
        weighted = J * part.weight.reshape(-1, 1)
        H += J.T @ weighted + part.prior_slope.T @ part.prior_slope
        scores = _scores(part)
        walk = _outer(scores, scores, part.travel)
        S += worse * (q.shift * walk[0] + q.turn * walk[1])
        S += worse * weighted.T @ (weighted * np.tile(white, len(part.weight))[:, None])
        start = weighted.T @ part.own.effects[..., :3].reshape(-1, 3)  # of the first pose, taken for true
        S += worse * (start * white) @ start.T
    return H, S


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
    shift = later(J[:, :2].transpose(0, 2, 1) * w[:, None, :2])
    swing = later(w[:, :1] * (x[:, None] * J[:, 1] - y[:, None] * J[:, 0]))
    turn = swing - (x[:, None] * shift[..., 1] - y[:, None] * shift[..., 0])
    return _Scores(shift, turn + later(w[:, 2:] * J[:, 2]))


def _outer(a: _Scores, b: _Scores, travel: Array) -> Array:
    """(2, p, p): for unit shifts, for unit turns."""
    return np.stack(
        [
            np.tensordot(a.shift * travel[:, None, None], b.shift, axes=([0, 2], [0, 2])),
            (a.turn * travel[:, None]).T @ b.turn,
        ]
    )
