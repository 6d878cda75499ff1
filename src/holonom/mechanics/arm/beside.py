"""The closed-form inverse of an arm in a tree: that of the joints that move the tool; others stay as they were."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import ShapeError
from holonom.mechanics.arm.nearest import joint_vectors, joint_weights
from holonom.mechanics.kernels.inverse.result import IkNearest, IkResult
from holonom.mechanics.kernels.protocol import SolvedArm

__all__ = ["Beside"]


class Beside:
    """An arm and the part of it that moves the tool, `chain`, whose joints are those at `places` in q."""

    def __init__(self, arm: SolvedArm, chain: SolvedArm, places: tuple[int, ...]) -> None:
        self.chain = chain
        self.places, self._names, self._limits = places, arm.limits.names, arm.limits
        self._n = arm.n

    def ik(self, T: ArrayLike, q0: ArrayLike | None, threads: int) -> IkResult:
        """As `Arm.ik`; joints beside the way as in q0, else at 0 or the limit that is nearest to it."""
        found = self.chain.ik(T, threads=threads)
        rest = np.clip(np.zeros(self._n), self._limits.lower, self._limits.upper)
        if q0 is not None:
            rest = joint_vectors("q0", q0, self._names)[..., None, :]
        return found._replace(q=self._whole(found.q, rest, "q0"))

    def ik_nearest(self, T: ArrayLike, q0: ArrayLike, weights: ArrayLike | None, threads: int) -> IkNearest:
        """As `Arm.ik_nearest`."""
        start = joint_vectors("q0", q0, self._names)
        counted = joint_weights(weights, self._n)[list(self.places)]
        found = self.chain.ik_nearest(
            T, np.ascontiguousarray(start[..., list(self.places)]), weights=counted, threads=threads
        )
        return found._replace(q=self._whole(found.q, start, "q0"))

    def _whole(self, q: Array, rest: Array, name: str) -> Array:
        """Joints of the whole arm (..., n) from those of the chain and what the others have."""
        try:
            whole = np.array(np.broadcast_to(rest, (*q.shape[:-1], self._n)))
        except ValueError:
            raise ShapeError(
                f"{name} {rest.shape} does not go with {q.shape[:-1]} solutions; give one, or one for each"
            ) from None
        whole[..., list(self.places)] = q
        return whole
