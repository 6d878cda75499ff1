"""What an inverse gives back: branches with a status each, and the one nearest to given joints."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.mechanics.kernels.inverse import geometry as inverse_geometry

__all__ = ["IkCase", "IkNearest", "IkResult", "IkStatus"]


class IkStatus(IntEnum):
    """What became of one branch of an inverse."""

    OK = inverse_geometry.OK
    UNREACHABLE = inverse_geometry.UNREACHABLE
    LIMIT = inverse_geometry.LIMIT
    SINGULAR = inverse_geometry.SINGULAR
    SINGULAR_LIMIT = inverse_geometry.SINGULAR_LIMIT
    FAR = 5


class IkCase(IntEnum):
    """How many joint vectors reach a target, joint limits aside."""

    OUT_OF_REACH = 0
    REGULAR = 1
    BOUNDARY = 2
    ON_AXIS = 3


class IkResult(NamedTuple):
    """All branches of an inverse.

    q : (..., k, n) rad or m; status : (..., k) int8, an `IkStatus`; names : the k branch names, explained in
    `mechanics.closed_form`.
    A SINGULAR branch reaches the target with a joint that is free (wrist straight; wrist on the axis of joint 1): it
    is chosen 0 (UR: joint 6, so that joint 4 is nearest to the shoulder); SINGULAR_LIMIT is such a branch whose chosen
    joints leave their limits, where others of its solutions may keep them. A LIMIT branch reaches it outside the joint
    limits. An UNREACHABLE one does not reach it: forward kinematics misses it by more than 1e-8 (m, and the rotation's
    entries).
    """

    q: Array
    status: NDArray[np.int8]
    names: tuple[str, ...]

    @property
    def solutions(self) -> NDArray[np.int64]:
        """Number of different joint vectors (...) that reach the target; -1 for infinitely many."""
        reached = self.status != IkStatus.UNREACHABLE
        count = (reached & ~self._repeated()).sum(-1)
        return np.where(self._free.any(-1), -1, count)

    @property
    def case(self) -> NDArray[np.int8]:
        """The `IkCase` (...): out of reach; regular; branches meet (arm stretched); a joint is free (on its axis)."""
        reached = self.status != IkStatus.UNREACHABLE
        met = np.where((reached & self._repeated()).any(-1), IkCase.BOUNDARY, IkCase.REGULAR)
        return np.where(reached.any(-1), np.where(self._free.any(-1), IkCase.ON_AXIS, met), IkCase.OUT_OF_REACH).astype(
            np.int8
        )

    @property
    def _free(self) -> NDArray[np.bool_]:
        """Whether a joint is free in a branch (..., k)."""
        return np.asarray((self.status == IkStatus.SINGULAR) | (self.status == IkStatus.SINGULAR_LIMIT))

    def _repeated(self) -> NDArray[np.bool_]:
        """Whether a branch (..., k) is an earlier one again."""
        return inverse_geometry.repeated(self.q, self.status != IkStatus.UNREACHABLE)


class IkNearest(NamedTuple):
    """The solution nearest to a joint vector: q (..., n), status (...), branch (...): its number in `names`.

    OK, or SINGULAR: of all solutions of all branches the nearest, infinitely many in a singular one. Where the arm has
    no closed form there are no names, and `branch` is -1; OK is then what is reached from the reference without a jump,
    and FAR another solution, beside which a nearer one may exist.
    """

    q: Array
    status: NDArray[np.int8]
    branch: NDArray[np.int64]
    names: tuple[str, ...]
