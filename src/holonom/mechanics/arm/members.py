"""Solution sets: where joints are free, the solution that is nearest to given joints.

A singular branch is one member of a curve of solutions, a redundant arm has such a curve through each of its solutions.
Members are found in three ways: by descent to the reference along the free directions (`pulled`), by following the
curve once round, and by a search between neighbours on it. The distance is the largest weighted difference of a joint.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.mechanics.kernels.inverse.geometry import REACHED, pose_error
from holonom.mechanics.kernels.protocol import SolvedArm
from holonom.model import LIMIT_TOLERANCE

__all__ = ["Reference", "nearest_members", "pulled", "whole_turns"]

FREE = 1e-6
"""Singular value of the Jacobian (m, rad) below which a combination of joints moves nothing."""
ROUNDS, CLIP = 40, 0.5
"""Steps of the descent at most, and the largest of them (rad or m)."""
STEP, WAY = 0.1, 14.0
"""Step along a curve of solutions and the way followed each side: over two turns (of its fastest joint, rad or m)."""
SAME, NEAR = 1e-7, 0.3
"""Distance up to which the descent's member is the reference itself, and up to which no curve is followed."""
DAMPING = 0.03
"""Of steps to a target, per square of the error."""
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True, slots=True)
class Reference:
    """What to be near to: joints q0 (N, n), limits (n,), whole turns (n,) and weights (n,)."""

    q0: Array
    lower: Array
    upper: Array
    turns: Array
    weights: Array

    @property
    def start(self) -> Array:
        """The reference within the limits."""
        return np.clip(self.q0, self.lower, self.upper)

    def take(self, rows: NDArray[np.intp]) -> Reference:
        """The same for some of the rows, or for rows again and again."""
        return Reference(self.q0[rows], self.lower, self.upper, self.turns, self.weights)

    def turned(self, q: Array) -> Array:
        """Joints (N, n) whole turns nearer, within the limits."""
        return whole_turns(q, self.q0, self.lower, self.upper, self.turns)

    def violation(self, q: Array) -> Array:
        """By how much joints (N, n) leave their limits at most, beyond the tolerance."""
        return np.maximum(np.maximum(self.lower - q, q - self.upper) - LIMIT_TOLERANCE, 0.0).max(-1)

    def distance(self, q: Array) -> Array:
        """Largest weighted difference (N,)."""
        return np.asarray((self.weights * np.abs(q - self.q0)).max(-1))

    def cost(self, q: Array) -> Array:
        """The distance; where it is the same along a curve, the other joints decide, and limits before all."""
        apart = self.weights * (q - self.q0)
        return self.distance(q) + 1e-6 * np.linalg.norm(apart, axis=-1) + 1e3 * self.violation(q)


def whole_turns(q: Array, q0: Array, lower: Array, upper: Array, turns: Array) -> Array:
    """Joints (..., n) a number of turns (2 pi; 0: a slide) away that is nearest to q0 among those within the limits."""
    turn = np.where(turns > 0.0, turns, 1.0)
    least = np.ceil((lower - LIMIT_TOLERANCE - q) / turn)
    most = np.floor((upper + LIMIT_TOLERANCE - q) / turn)
    count = np.clip(np.rint((q0 - q) / turn), least, most)
    return np.asarray(np.where((turns > 0.0) & (least <= most), q + turn * np.nan_to_num(count), q))


def nearest_members(arm: SolvedArm, T: Array, q: Array, owner: NDArray[np.intp], to: Reference) -> tuple[Array, Array]:
    """The nearest member of the solution set that each solution belongs to.

    Parameters
    ----------
    T : (N, 4, 4) targets, or points (N, 3).
    q : (M, n), solutions, of the targets of number `owner` (M,).
    to : rows as for T.

    Returns
    -------
    q : (M, n), in reach of its target; its largest violation of a limit (M,), 0 where it keeps them.
    """
    sets = _Sets(arm, T[owner], to.take(owner))
    found = sets.best([q, sets.pulled(sets.to.turned(q)), sets.pulled(sets.to.q0)])
    far = np.flatnonzero((sets.to.distance(found) > NEAR) | (sets.to.violation(found) > 0.0))
    if len(far):
        some = sets.rows(far)
        found[far] = some.best([found[far], some.followed(q[far])])
    off = np.flatnonzero(sets.to.distance(found) > SAME)
    if len(off):
        some = sets.rows(off)
        found[off] = some.best([found[off], some.polished(found[off])])
    return found, sets.to.violation(found)


def pulled(arm: SolvedArm, T: Array, q: Array, to: Reference, rounds: int = ROUNDS) -> Array:
    """Solutions (N, n) moved along their free directions to the least weighted squares from the reference.

    Those that would miss the target or a limit stay as they were.
    """
    sets = _Sets(arm, T, to)
    return sets.best([q, sets.pulled(q, rounds)])


def approached(arm: SolvedArm, T: Array, q: Array, to: Reference) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """The nearest of solutions q (N, n) and of those that steps from the reference lead to.

    Returns
    -------
    Joints (N, n); whether they reach their targets; whether the Jacobian is singular there.
    """
    sets = _Sets(arm, T, to)
    near = sets.approached(to.start)
    found = sets.best([q, near, sets.pulled(to.start), sets.pulled(near)], first_reaches=False)
    return found, ~sets.missed(found), sets.smallest(found) < FREE


class _Sets:
    """The solution sets of targets (N, 4, 4) or (N, 3), a row each."""

    def __init__(self, arm: SolvedArm, T: Array, to: Reference) -> None:
        self.arm, self.T, self.to = arm, T, to
        self.task = 3 if T.ndim == 2 or (arm.closed_form is not None and arm.closed_form.task == "position") else 6
        if self.task == 3 and T.ndim == 3:
            self.T = T[:, :3, 3]
        weights = to.weights if to.weights.any() else np.ones(arm.n)
        self.scale = np.maximum(weights, 1e-3 * weights.max())

    def rows(self, some: NDArray[np.intp]) -> _Sets:
        return _Sets(self.arm, self.T[some], self.to.take(some))

    def best(self, candidates: list[Array], *, first_reaches: bool = True) -> Array:
        """Of each row's candidates that reach the target the one that costs least, else the first."""
        stack = np.stack([candidates[0], *(self.to.turned(q) for q in candidates[1:])])
        cost = np.stack([self.to.cost(q) for q in stack])
        for k in range(first_reaches, len(stack)):
            cost[k, self.missed(stack[k])] = np.inf
        return np.asarray(stack[cost.argmin(0), np.arange(stack.shape[1])])

    def missed(self, q: Array) -> NDArray[np.bool_]:
        return np.asarray(np.linalg.norm(pose_error(self.arm.fk(q), self.T, self.task), axis=-1) > REACHED)

    def steps(self, q: Array) -> tuple[Array, Array]:
        """The least weighted step (N, n) to the target, and the projection (N, n, n), scaled, on what moves nothing."""
        from holonom.numeric.svd import svd  # compiled code, on first use

        error = pose_error(self.arm.fk(q), self.T, self.task)
        U, s, Vt = svd(self.arm.jacobian(q)[:, : self.task] / self.scale)
        held = s > FREE
        k = s.shape[-1]
        inverse = np.where(held, 1.0 / np.where(held, s, 1.0), 0.0)
        shares = inverse * (error[:, None, :] @ U[:, :, :k])[:, 0]
        step = (shares[:, None, :] @ Vt[:, :k])[:, 0] / self.scale
        kept = np.where(held[..., None], Vt[:, :k], 0.0)
        return step, np.eye(q.shape[-1]) - np.swapaxes(kept, -1, -2) @ kept

    def smallest(self, q: Array) -> Array:
        """Smallest singular value of the task's Jacobian (N,)."""
        return np.asarray(np.linalg.svd(self.arm.jacobian(q)[:, : self.task], compute_uv=False)[:, -1])

    def approached(self, q: Array) -> Array:
        """Levenberg-Marquardt steps to the target, damped by the square of the error (Chan & Lawrence 1988)."""
        eye = np.eye(self.task)
        for _ in range(ROUNDS):
            error = pose_error(self.arm.fk(q), self.T, self.task)
            J = self.arm.jacobian(q)[:, : self.task] / self.scale
            damping = DAMPING * (error**2).sum(-1)[:, None, None] + 1e-14
            JT = np.swapaxes(J, -1, -2)
            step = _clipped((JT @ np.linalg.solve(J @ JT + damping * eye, error[..., None]))[..., 0] / self.scale)
            q = q + step
            if np.abs(step).max(initial=0.0) < 1e-13:
                break
        return self.corrected(q)

    def pulled(self, q: Array, rounds: int = ROUNDS) -> Array:
        """Descent to the reference along the free directions."""
        for _ in range(rounds):
            step, free = self.steps(q)
            step = _clipped(step + _clipped((free @ (self.scale * (self.to.q0 - q))[..., None])[..., 0] / self.scale))
            q = q + step
            if np.abs(step).max(initial=0.0) < 1e-13:
                break
        return self.corrected(q)

    def corrected(self, q: Array) -> Array:
        """Newton's method, least steps."""
        for _ in range(2):
            q = q + self.steps(q)[0]
        return q

    def direction(self, q: Array) -> Array:
        """A direction (N, n) that moves nothing, its fastest joint by 1."""
        return _unit(np.linalg.eigh(self.steps(q)[1])[1][..., -1] / self.scale)

    def followed(self, q: Array) -> Array:
        """The best of the members along the curve through q, both ways."""
        best, cost = q, np.full(len(q), np.inf)
        for way in (1.0, -1.0):
            at, ahead = q, way * self.direction(q)
            for _ in range(math.ceil(WAY / STEP)):
                at = self.corrected(at + STEP * ahead)
                ahead = _unit((self.steps(at)[1] @ (self.scale * ahead)[..., None])[..., 0] / self.scale)
                turned = self.to.turned(at)
                value = np.where(self.missed(turned), np.inf, self.to.cost(turned))
                better = value < cost
                best, cost = np.where(better[:, None], turned, best), np.where(better, value, cost)
        return self.polished(best)

    def polished(self, q: Array) -> Array:
        """The best between the neighbours of members on their curves (golden section)."""
        ahead = self.direction(q)

        def at(t: Array) -> tuple[Array, Array]:
            found = self.to.turned(self.corrected(q + t[:, None] * ahead))
            return found, np.where(self.missed(found), np.inf, self.to.cost(found))

        low, high = np.full(len(q), -STEP), np.full(len(q), STEP)
        a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        fa, fb = at(a)[1], at(b)[1]
        best, cost = q, self.to.cost(q)
        while (high - low).max() > 1e-9:
            left = fa < fb
            low, high = np.where(left, low, a), np.where(left, b, high)
            a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            q_new, f_new = at(np.where(left, a, b))
            fa, fb = np.where(left, f_new, fb), np.where(left, fa, f_new)
            better = f_new < cost
            best, cost = np.where(better[:, None], q_new, best), np.where(better, f_new, cost)
        return best


def _unit(v: Array) -> Array:
    """Directions whose fastest joint moves by 1; a row of zeros stays."""
    largest = np.abs(v).max(-1, keepdims=True)
    return np.asarray(v / np.where(largest > 1e-9, largest, np.inf))


def _clipped(step: Array) -> Array:
    largest = np.abs(step).max(-1, keepdims=True)
    return np.asarray(step * np.minimum(1.0, CLIP / np.maximum(largest, 1e-300)))
