"""All branches of a closed-form inverse, refined where an arm is only nearly of its family: what `Arm.ik` calls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.errors import InputError, ShapeError
from holonom.mechanics.arm.targets import check_lost, points
from holonom.mechanics.kernels.inverse.geometry import UNREACHABLE, refined
from holonom.mechanics.kernels.inverse.result import IkResult
from holonom.mechanics.kernels.protocol import SolvedArm
from holonom.spatial import check_pose

__all__ = ["Branches"]


class Branches:
    """The branches of one arm with a closed form, for many calls; `solver` gives the compiled one's.

    Raises
    ------
    InputError
        It has none.
    """

    def __init__(self, arm: SolvedArm, solver: Callable[[], Callable[..., Any]]) -> None:
        form = arm.closed_form
        if form is None:
            raise InputError(
                f"arm {arm.model.name!r} has no closed-form inverse: its axes lie like those of no known family; "
                "ik_nearest(T, q0) finds one solution numerically"
            )
        self._arm, self._call, self._limits = arm, solver(), (arm.limits.lower, arm.limits.upper)
        self._poses, self._exact = form.task == "pose", form.exact
        self._nowhere = bytes([UNREACHABLE] * len(form.names))
        """Bytes of a status without a branch that reaches the target."""

    def take(self, T: ArrayLike, q0: ArrayLike | None, threads: int) -> IkResult:
        """Arguments, result and errors as for `Arm.ik`; no joint of this arm stays as in q0."""
        del q0
        target = T if self._poses else points(T)
        try:
            found: IkResult = self._call(target, threads=threads)
        except ShapeError:
            if self._poses:
                check_pose(T, "T")  # names what is wrong with it
            raise
        q, status, names = found
        if self._poses and (status.ndim > 1 or status.tobytes() == self._nowhere):
            check_lost(T, status)
        if self._exact:
            return found
        goal, task = np.asarray(target, dtype=float), "pose" if self._poses else "position"
        q, status = refined(self._arm.fk, self._arm.jacobian, self._limits, task, goal, q, status)
        return IkResult(q, status, names)
