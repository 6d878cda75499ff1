"""What the code below `Arm` knows of an arm: its model, limits and compiled equations, but not the class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mechanics.kernels.inverse.closed_form import ClosedForm
from holonom.mechanics.kernels.inverse.result import IkNearest, IkResult
from holonom.model import ArmModel
from holonom.trace import Kernel

__all__ = ["Limits", "SolvedArm"]


@dataclass(frozen=True, slots=True)
class Limits:
    """Joint limits as arrays (n,): rad, rad/s, rad/s2, N m (m, m/s, ... for prismatic joints)."""

    names: tuple[str, ...]
    lower: Array
    upper: Array
    speed: Array
    acceleration: Array
    torque: Array
    turns: tuple[bool, ...]
    """Whether its position is an angle; else it is a length."""


class SolvedArm(Protocol):
    """An arm as the solvers see it; `Arm` is one."""

    model: ArmModel
    n: int

    @property
    def first(self) -> SolvedArm:
        """The arm whose compiled equations it uses: itself, or as it stands elsewhere."""

    def fk(self, q: ArrayLike, /) -> Array:
        """T_wt (..., 4, 4)."""

    def jacobian(self, q: ArrayLike, /) -> Array:
        """J (..., 6, n) in the world."""

    def ik(self, T: ArrayLike, q0: ArrayLike | None = None, *, threads: int = 1) -> IkResult:
        """All branches of the closed form."""

    def ik_nearest(
        self, T: ArrayLike, q0: ArrayLike, *, weights: ArrayLike | None = None, threads: int = 1
    ) -> IkNearest:
        """The nearest solution."""

    @property
    def limits(self) -> Limits:
        """Joint limits as arrays."""

    @property
    def prepared(self) -> Any:
        """What is made once for it: `prepared[build, *options]`."""

    @property
    def closed_form(self) -> ClosedForm | None:
        """Its closed-form inverse, if there is one."""

    def kernel(self, name: str, **options: Any) -> Kernel:
        """Return a compiled equation of the table."""

    def pointer(self, name: str, **options: Any) -> tuple[int, Array]:
        """Address of a compiled equation in C form, and the numbers that follow its own inputs."""
