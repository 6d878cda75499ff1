"""Whether a model explains a record: what it misses beside the noise that the record itself shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array

__all__ = ["Misfit", "doubts_of", "misfit_of"]

FAR = 5.0
"""Misfit over what the noise explains: honest records stay near 1."""
PART = 0.05
"""Part of a joint's torque: less may be the differentiation of positions, friction beyond the model, a soft drive."""
FOLLOWS = 0.3
"""Correlation of what is missed with itself one kept sample later; noise between the kept samples has none."""
RADIANS = 4.0 * np.pi
"""Positions beyond it are perhaps no radians."""
ROOM = 0.1
"""rad or m beyond a limit that are no cause for doubt."""


@dataclass(frozen=True, slots=True)
class Misfit:
    """Of each joint (n,): what is missed and what noise explains of it, N m rms, filtered; torque; correlation."""

    missed: Array
    explained: Array
    torque: Array
    correlation: Array


def misfit_of(missed: Sequence[Array], torque: Sequence[Array], explained: Array) -> Misfit:
    """Of what is missed of each joint's filtered torques, in the order of time."""
    rest = [np.sqrt(np.mean(m * m)) for m in missed]
    follows = [float(m[1:] @ m[:-1]) / max(float(m @ m), 1e-300) if len(m) > 1 else 0.0 for m in missed]
    size = [np.sqrt(np.mean(t * t)) for t in torque]
    return Misfit(np.array(rest), explained, np.array(size), np.array(follows))


def doubts_of(found: Misfit, names: Sequence[str], q: Array, lower: Array, upper: Array) -> tuple[str, ...]:
    """What speaks against the record, in sentences; none if the model explains it.

    Parameters
    ----------
    q : (N, n) measured positions; `lower` and `upper` (n,) are the arm's limits.
    """
    far = (found.missed > FAR * found.explained) & (found.missed > PART * found.torque) & (found.correlation > FOLLOWS)
    if not far.any():
        return ()
    worst = [
        f"{names[int(j)]} {found.missed[j]:.3g} of {found.torque[j]:.3g} (noise: {found.explained[j]:.2g})"
        for j in np.flatnonzero(far)
    ]
    sentences = [
        "no arm of this kind explains the record: torques are missed far beyond their noise, "
        f"{', '.join(worst)} N m or N rms: a sign or unit of positions or torques may be wrong, joints swapped, "
        "gravity or another arm meant"
    ]
    reach = np.abs(q).max(axis=0)
    outside = (q.min(axis=0) < lower - ROOM) | (q.max(axis=0) > upper + ROOM) | (reach > RADIANS)
    if outside.any():
        told = ", ".join(f"{names[int(j)]} to {reach[j]:.4g}" for j in np.flatnonzero(outside))
        guess = "degrees instead of radians?" if reach.max() > RADIANS else "joints swapped, or counted from elsewhere?"
        sentences.append(f"positions leave the arm's limits ({told}): {guess}")
    return tuple(sentences)
