"""The solution nearest to given joints of arms without a closed form: what `Arm.ik_nearest` calls for them.

The target is approached from the reference, first at once, then in small steps along the way between the poses. What is
reached so, without a jump, is moved along the arm's self-motion to where it is nearest. Only where that fails other
solutions are looked for, near the reference and then anywhere; such a one is FAR.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from holonom.arrays import Array
from holonom.errors import ShapeError
from holonom.mechanics.arm.members import Reference, pulled
from holonom.mechanics.arm.nearest import joint_vectors, joint_weights
from holonom.mechanics.kernels.inverse.result import IkNearest, IkStatus
from holonom.mechanics.kernels.protocol import SolvedArm
from holonom.mechanics.numerical_inverse import InverseResult, InverseStatus, free_turns, solve_inverse
from holonom.spatial import check_pose

__all__ = ["Searched"]

JUMP = 0.3
"""Largest weighted difference (rad or m) from the reference up to which a solution is taken for the nearest at once."""
STRAIGHT = 0.02
"""Largest weighted difference up to which the least steps to a solution lead to the nearest of its self-motion."""
PIECES = 16
"""Steps in which the way from the reference's pose is gone where it is not gone at once."""
AROUND = (0.1, 0.3, 1.0)
"""How far from the reference (rad or m) searches start where the way does not lead to the target."""
STARTS = 8
"""Of such searches for each distance."""
ROUNDS, RESTARTS = 8, 200
"""Steps of the descent along the self-motion at most; searches from anywhere where all else fails."""
STATUS = np.zeros(len(InverseStatus), dtype=np.int8)
STATUS[[InverseStatus.OK, InverseStatus.NOT_CONVERGED, InverseStatus.LIMIT]] = (
    IkStatus.OK, IkStatus.UNREACHABLE, IkStatus.LIMIT,
)  # fmt: skip


class Searched:
    """The nearest solution of one arm without a closed form, for many calls."""

    def __init__(self, arm: SolvedArm) -> None:
        self._arm, self._limits = arm, arm.limits
        self._turns = np.where(free_turns(arm.model), 2.0 * np.pi, 0.0)

    def take(self, T: ArrayLike, q0: ArrayLike, weights: ArrayLike | None, threads: int) -> IkNearest:
        """Arguments, result and errors as for `Arm.ik_nearest`."""
        arm, target = self._arm, check_pose(T, "T")
        start = joint_vectors("q0", q0, self._limits.names)
        try:
            lead = np.broadcast_shapes(target.shape[:-2], start.shape[:-1])
        except ValueError:
            raise ShapeError(
                f"q0 {start.shape} does not go with T: {target.shape[:-2]} targets; give one q0, or one for each"
            ) from None
        goals = np.broadcast_to(target, (*lead, 4, 4)).reshape(-1, 4, 4)
        starts = np.broadcast_to(start, (*lead, arm.n)).reshape(-1, arm.n)
        to = Reference(starts, self._limits.lower, self._limits.upper, self._turns, joint_weights(weights, arm.n))
        q, status = self._nearest(np.ascontiguousarray(goals), to, threads)
        return IkNearest(q.reshape(*lead, arm.n), status.reshape(lead)[()], np.full(lead, -1)[()], ())

    def _nearest(self, T: Array, to: Reference, threads: int) -> tuple[Array, NDArray[np.int8]]:
        found = self._solved(T, to.start, 0, threads)
        q, status = found.q, STATUS[found.status]
        off = np.flatnonzero(to.distance(q) > STRAIGHT)
        if len(off):
            q[off] = pulled(self._arm, T[off], q[off], to.take(off), ROUNDS)
        far = np.flatnonzero((status != IkStatus.OK) | (to.distance(q) > JUMP))
        if len(far):
            q[far], status[far] = self._along(T[far], to.take(far), q[far], status[far], threads)
        lost = np.flatnonzero(status != IkStatus.OK)
        if len(lost):
            q[lost], status[lost] = self._around(T[lost], to.take(lost), q[lost], status[lost], threads)
        return q, status

    def _solved(self, T: Array, start: Array, restarts: int, threads: int) -> InverseResult:
        return solve_inverse(self._arm, T, start, restarts=restarts, threads=threads)

    def _along(
        self, T: Array, to: Reference, q: Array, status: NDArray[np.int8], threads: int
    ) -> tuple[Array, NDArray[np.int8]]:
        """What small steps between the poses lead to; what was found already (q, status), if that is nearer."""
        at, whole = to.start, np.ones(len(T), dtype=bool)
        for goal in _way(self._arm.fk(at), T):
            found = self._solved(goal, at, 0, threads)
            whole &= (found.status == InverseStatus.OK) & (np.abs(found.q - at).max(-1) < JUMP)
            at = np.where(whole[:, None], found.q, at)
        at = pulled(self._arm, T, at, to, ROUNDS)
        known = status == IkStatus.OK
        nearer = whole & (~known | (to.distance(at) < to.distance(q)))
        rest = np.where(known, IkStatus.FAR, status)
        return np.where(nearer[:, None], at, q), np.where(whole, IkStatus.OK, rest).astype(np.int8)

    def _around(
        self, T: Array, to: Reference, q: Array, status: NDArray[np.int8], threads: int
    ) -> tuple[Array, NDArray[np.int8]]:
        """The nearest of solutions from starts around the reference; where there are none, any solution."""
        rng, row = np.random.default_rng(0), np.arange(len(T))
        every = np.repeat(row, STARTS * len(AROUND))
        radius = np.tile(np.repeat(AROUND, STARTS), len(T))[:, None]
        starts = np.clip(
            to.start[every] + radius * rng.uniform(-1.0, 1.0, (len(every), self._arm.n)), to.lower, to.upper
        )
        found = self._solved(T[every], starts, 0, threads)
        near = to.take(every)
        some = pulled(self._arm, T[every], near.turned(found.q), near, ROUNDS)
        apart = np.where(found.status == InverseStatus.OK, near.distance(some), np.inf).reshape(len(T), -1)
        best, nearest = some.reshape(len(T), -1, self._arm.n)[row, apart.argmin(-1)], apart.min(-1)
        better = nearest < np.where(status == IkStatus.FAR, to.distance(q), np.inf)
        q, status = np.where(better[:, None], best, q), np.where(better, IkStatus.FAR, status)
        lost = np.flatnonzero(status != IkStatus.FAR)
        if len(lost):
            found = self._solved(T[lost], to.start[lost], RESTARTS, threads)
            part = to.take(lost)
            q[lost] = pulled(self._arm, T[lost], part.turned(found.q), part, ROUNDS)
            status[lost] = np.where(found.status == InverseStatus.OK, IkStatus.FAR, STATUS[found.status])
        close = (status == IkStatus.FAR) & (to.distance(q) <= JUMP)
        return q, np.where(close, IkStatus.OK, status).astype(np.int8)


def _way(T0: Array, T1: Array) -> Iterator[Array]:
    """Poses (N, 4, 4) in equal steps of place and of the turn about one axis, to T1."""
    turn = Rotation.from_matrix(np.swapaxes(T0[:, :3, :3], 1, 2) @ T1[:, :3, :3]).as_rotvec()
    for part in np.linspace(0.0, 1.0, PIECES + 1)[1:-1]:
        T = T0.copy()
        T[:, :3, :3] = T0[:, :3, :3] @ Rotation.from_rotvec(part * turn).as_matrix()
        T[:, :3, 3] = T0[:, :3, 3] + part * (T1[:, :3, 3] - T0[:, :3, 3])
        yield T
    yield T1
