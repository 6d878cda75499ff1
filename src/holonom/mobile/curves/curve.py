"""Curves of arcs of one radius and straight pieces: what they are, where they end, their poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, is_finite, shown, vectors
from holonom.errors import OutOfLimits

__all__ = ["Curves", "chosen", "in_radii", "turned_poses"]

TURNS = {"L": 1.0, "S": 0.0, "R": -1.0}
"""What a piece of a word does: it turns to the left, goes straight, turns to the right."""


@dataclass(frozen=True, slots=True)
class Curves:
    """The shortest curve for each of N pairs of poses.

    Attributes
    ----------
    start : (N, 3) poses where they begin, m and rad.
    radius : of the arcs, m.
    words : (N,) such as "LSR": what the pieces do.
    lengths : (N, k) signed lengths of the pieces over the radius, zeros behind; below zero: backwards.
    """

    start: Array
    radius: float
    words: tuple[str, ...]
    lengths: Array

    @property
    def length(self) -> Array:
        """(N,) whole length of each, m."""
        return self.radius * np.abs(self.lengths).sum(axis=1)

    @property
    def end(self) -> Array:
        """(N, 3) poses at their ends."""
        found = self.start * [1.0 / self.radius, 1.0 / self.radius, 1.0]
        turns = np.zeros(self.lengths.shape)
        for row, word in enumerate(self.words):
            turns[row, : len(word)] = [TURNS[letter] for letter in word]
        for turn, length in zip(turns.T, self.lengths.T, strict=True):
            found = turned_poses(found, turn, length)
        return found * [self.radius, self.radius, 1.0]

    def poses(self, row: int, spacing: float) -> tuple[Array, Array]:
        """Poses (M, 3) along a curve, no farther apart than `spacing`, m, and the direction (M,) of going: 1 or -1.

        A cusp stands twice, once for each direction.

        Raises
        ------
        OutOfLimits
            A spacing that is not above zero.
        """
        if not (is_finite(spacing) and spacing > 0.0):
            raise OutOfLimits(f"spacing is {shown(spacing)} m; a number above zero is needed")
        at = self.start[row] * [1.0 / self.radius, 1.0 / self.radius, 1.0]
        found: list[Array] = []
        ways: list[Array] = []
        for letter, length in zip(self.words[row], self.lengths[row], strict=False):
            if length == 0.0:
                continue
            steps = int(np.ceil(abs(length) * self.radius / spacing))
            part = length * np.arange(steps + 1) / steps
            piece = turned_poses(at, np.full(len(part), TURNS[letter]), part)
            way = float(np.sign(length))
            skipped = 1 if ways and ways[-1][-1] == way else 0
            found.append(piece[skipped:])
            ways.append(np.full(len(part) - skipped, way))
            at = piece[-1]
        if not found:
            return self.start[row][None].copy(), np.ones(1)
        return np.concatenate(found) * [self.radius, self.radius, 1.0], np.concatenate(ways)


def turned_poses(start: Array, turn: Array, length: Array) -> Array:
    """Poses (..., 3) after a piece of a signed length from `start` (..., 3), in radii: an arc, or straight."""
    x, y, theta = np.moveaxis(np.asarray(start, dtype=float), -1, 0)
    after = theta + turn * length
    straight = turn == 0.0
    sign = np.where(straight, 1.0, turn)
    dx = np.where(straight, length * np.cos(theta), (np.sin(after) - np.sin(theta)) * sign)
    dy = np.where(straight, length * np.sin(theta), (np.cos(theta) - np.cos(after)) * sign)
    return np.stack(np.broadcast_arrays(x + dx, y + dy, after), axis=-1)


def in_radii(start: ArrayLike, end: ArrayLike, radius: float) -> tuple[Array, Array]:
    """Start poses (N, 3), m, and the goal (N, 3) as seen from them, over the radius, heading in (-pi, pi].

    Raises
    ------
    OutOfLimits
        A radius that is not above zero.
    ShapeError
    """
    if not (is_finite(radius) and radius > 0.0):
        raise OutOfLimits(f"radius is {shown(radius)} m; a number above zero is needed")
    a, b = np.broadcast_arrays(np.atleast_2d(vectors("start", start, 3)), np.atleast_2d(vectors("end", end, 3)))
    (dx, dy), c, s = (b - a)[:, :2].T / radius, np.cos(a[:, 2]), np.sin(a[:, 2])
    turn = np.pi - (np.pi - (b - a)[:, 2]) % (2.0 * np.pi)
    return np.array(a), np.column_stack([c * dx + s * dy, c * dy - s * dx, turn])


def chosen(start: Array, radius: float, words: tuple[str, ...], lengths: Array) -> Curves:
    """The shortest of W words for each row: lengths (W, N, k), NaN where a word does not lead there."""
    total = np.where(np.isfinite(lengths).all(axis=2), np.abs(lengths).sum(axis=2), np.inf)
    best = total.argmin(axis=0)
    return Curves(start, radius, tuple(words[k] for k in best), lengths[best, np.arange(len(best))])
