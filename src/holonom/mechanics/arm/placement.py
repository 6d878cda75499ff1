"""An arm at another base, with another tool, gravity or load: the first one's compiled equations, these as inputs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.kernels.movable import BY_INERTIA, check_movable
from holonom.mechanics.kernels.placement import GIVEN, NEEDED, payload_numbers
from holonom.mechanics.kernels.table import Calls, named
from holonom.model import ArmModel
from holonom.spatial import inverse
from holonom.trace import Kernel

__all__ = ["NO_LOAD", "Placement"]

NO_LOAD = Inertial(0.0, [0.0, 0.0, 0.0], [[0.0] * 3 for _ in range(3)])


class Placement:
    """How an arm differs from the one whose equations it uses; `calls` are those of its kernels, with inputs more.

    Parameters
    ----------
    first, calls, kernel
        The model that the equations were traced for, the calls of its arm, and `Arm.kernel` of it.
    model, payload
        Those of the arm itself; the payload is what its tool's joint carries more than in the first model.
    """

    def __init__(
        self, first: ArmModel, calls: Calls, kernel: Callable[..., Kernel], model: ArmModel, payload: Inertial
    ) -> None:
        self.payload, self._of_first, self._kernel, self._model = payload, calls, kernel, model
        here, there = _numbers(model, payload), _numbers(first, NO_LOAD)
        self.numbers = here
        self._changed = {name for name in GIVEN if not np.array_equal(here[name], there[name])}
        self.same_tool = "tool" not in self._changed
        self._left = there["base"] @ inverse(here["base"])
        self._right = inverse(here["tool"]) @ there["tool"]
        self.calls = Calls(self.call)

    def kernel(self, name: str, **options: Any) -> tuple[Kernel, tuple[Array, ...]]:
        """A kernel that serves any placement, and the arrays that follow its own inputs; none if it depends on none."""
        if name in BY_INERTIA:
            check_movable(self._model)
        found = self._kernel(name, **options, given=NEEDED)
        reads = [f.name for f in found.inputs if f.name in GIVEN]
        if not self._changed.intersection(reads):
            return self._kernel(name, **options), ()
        return found, tuple(self.numbers[name] for name in reads)

    def call(self, key: Any) -> Callable[..., Any]:
        """The call of a kernel, by a key of `Calls`."""
        name, options = named(key)
        kernel, more = self.kernel(name, **options)
        if not more:
            return self._of_first[key]
        plain = kernel.call

        def call(*arrays: Any, out: Any = None, threads: int = 1) -> Any:
            return plain(*arrays, *more, out=out, threads=threads)

        return call

    def from_first(self, target: ArrayLike) -> ArrayLike:
        """Poses T_wt (..., 4, 4), or places where the tool is the same, as the first arm has to reach them.

        Anything else is handed on as it is: who takes it says what is wrong with it.
        """
        try:
            T = np.asarray(target, dtype=float)
        except (TypeError, ValueError):
            return target
        if T.shape[-2:] == (4, 4):
            moved: Array = self._left @ T @ self._right
            return moved
        if T.shape[-1:] == (3,):
            return np.asarray(T @ self._left[:3, :3].T + self._left[:3, 3])
        return target


def _numbers(model: ArmModel, payload: Inertial) -> dict[str, Array]:
    return {
        "base": np.array(model.base),
        "tool": np.array(model.tool),
        "gravity": np.array(model.gravity),
        "payload": np.array(payload_numbers(payload)),
    }
