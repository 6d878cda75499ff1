"""How sure calibrated numbers are, and which the motion leaves open.

Errors of odometry along a path hang together: each slip shifts and turns all that follows. Counting every sample as
news would promise far too much. Here the noise is a random walk of the base, white per way of the wheels, in both
directions and in heading; its two intensities come from what calibration leaves. With `H = J^T W J`, an estimate
moves by `H^-1 S_i` when the base slips in sample i, where S_i sums `J^T W` times the shift over all later samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from holonom.arrays import Array
from holonom.errors import CalibrationError
from holonom.mobile.calibration.parameters import DriveParameters
from holonom.mobile.calibration.residuals import RunPart

__all__ = ["check_excitation", "random_walk_covariance"]


UNSEEN = 1e-7  # relative singular value below which a combination has no effect at all
OPEN = 0.3  # standard deviation of a combination, relative to the parameters' scale, above which it is left open
MOST = 4  # names in a message
NAMED = 0.05  # share of a parameter in such a combination above which it is named

ADVICE = {
    "diameter": "drive a longer way, straight and with turns",
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
    """Of one component of the error: effect of a shift (N, p, 2) and of a turn (N, p) in each sample."""

    shift: Array
    turn: Array


def random_walk_covariance(parts: Sequence[RunPart]) -> Array:
    """Covariance (p, p) of the scaled parameters at the least squares solution.

    Source: the usual sandwich `H^-1 S H^-1` (White 1980), with S of the random walk above.
    """
    p = parts[0].slope.shape[2]
    H = {c: np.zeros((p, p)) for c in ("place", "heading")}
    S = {c: np.zeros((2, p, p)) for c in ("place", "heading")}  # of unit intensity of shifts, of turns
    total, prior = np.zeros((2, p, p)), np.zeros((2, 2))
    for part in parts:
        scores = _scores(part)
        both = _Scores(scores[0].shift + scores[1].shift, scores[0].turn + scores[1].turn)
        total += _outer(both, both, part.travel)
        prior += _energy(part)
        for name, score, columns in zip(H, scores, (slice(0, 2), slice(2, 3)), strict=True):
            J, w = part.slope[:, columns], part.weight[:, columns]
            H[name] += np.einsum("kcp,kc,kcq->pq", J, w, J, optimize=True)
            S[name] += _outer(score, both, part.travel)
    inverse = np.linalg.pinv(H["place"] + H["heading"], rcond=UNSEEN**2, hermitian=True)
    expected = np.empty((2, 2))
    for row, name in enumerate(H):
        for noise in range(2):
            back = inverse @ H[name] @ inverse
            expected[row, noise] = prior[row, noise] - 2.0 * np.trace(inverse @ S[name][noise])
            expected[row, noise] += np.trace(back @ total[noise])
    seen = np.array([sum(float(np.sum(q.weight[:, c] * q.error[:, c] ** 2)) for q in parts) for c in ([0, 1], [2])])
    scale = np.maximum(seen, 1e-30)
    intensity = nnls(expected / scale[:, None], seen / scale)[0]
    covariance: Array = inverse @ np.tensordot(intensity, total, 1) @ inverse
    return covariance


def check_excitation(J: Array, drive: DriveParameters, covariance: Array | None = None) -> Array:
    """Singular values (p,) of the weighted, scaled Jacobian, largest first; refuse a motion that leaves any open.

    Parameters
    ----------
    J : (n, p) Jacobian of the weighted errors by the scaled parameters.
    covariance : (p, p) of the scaled parameters; without it only combinations without any effect are refused.

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
    raise CalibrationError(_open(named, drive.set))


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


def _scores(part: RunPart) -> tuple[_Scores, _Scores]:
    """Of place and heading: what a shift or a turn in sample i does to `J^T W e`, summed over the samples from i on."""
    J, w, (x, y) = part.slope, part.weight, part.place.T
    shift = _later(J[:, :2].transpose(0, 2, 1) * w[:, None, :2])
    swing = _later(w[:, :1] * (x[:, None] * J[:, 1] - y[:, None] * J[:, 0]))
    turn = swing - (x[:, None] * shift[..., 1] - y[:, None] * shift[..., 0])
    return _Scores(shift, turn), _Scores(np.zeros_like(shift), _later(w[:, 2:] * J[:, 2]))


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


def _energy(part: RunPart) -> Array:
    """(2, 2) expected weighted squares of place and heading before the fit, by unit shifts and by unit turns."""
    way = np.cumsum(part.travel)
    drift = np.cumsum(part.travel[:, None] * part.place, axis=0)
    spread = np.cumsum(part.travel * (part.place**2).sum(1))
    swing = (part.place**2).sum(1) * way - 2.0 * (part.place * drift).sum(1) + spread
    w = part.weight
    return np.array([[2.0 * np.sum(w[:, 0] * way), np.sum(w[:, 0] * swing)], [0.0, np.sum(w[:, 2] * way)]])
