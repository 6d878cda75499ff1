"""Two masses and a spring between them: motor and load of an elastic joint (spec 03.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["TwoMass", "TwoMassParams", "TwoMassState", "two_mass_step"]


class TwoMassState(NamedTuple):
    """Twist of the shaft (rad, motor less load), speeds of motor and load (rad/s)."""

    twist: float
    motor_speed: float
    load_speed: float


class TwoMassParams(NamedTuple):
    """Rows of the exact step: each state from twist, both speeds, motor and load torque."""

    twist: tuple[float, float, float, float, float]
    motor: tuple[float, float, float, float, float]
    load: tuple[float, float, float, float, float]


@loop
def two_mass_step(params: TwoMassParams, state: TwoMassState, motor_torque: float, load_torque: float) -> TwoMassState:
    """State a step later under a motor torque and a load torque (N m, against positive motion), exact."""
    x, v, w = state.twist, state.motor_speed, state.load_speed
    a, b, c = params.twist, params.motor, params.load
    return TwoMassState(
        a[0] * x + a[1] * v + a[2] * w + a[3] * motor_torque + a[4] * load_torque,
        b[0] * x + b[1] * v + b[2] * w + b[3] * motor_torque + b[4] * load_torque,
        c[0] * x + c[1] * v + c[2] * w + c[3] * motor_torque + c[4] * load_torque,
    )


@dataclass(frozen=True, slots=True)
class TwoMass:
    """Motor and load at the two ends of a shaft; all of it at one side of the gear.

    Raises
    ------
    ModelError
        A number outside its range.
    """

    motor_inertia: float = parameter(meaning="J_M", unit="kg m2", above=0.0, example=1.37e-5)
    load_inertia: float = parameter(meaning="J_L", unit="kg m2", above=0.0, example=3e-5)
    stiffness: float = parameter(meaning="c of the shaft", unit="N m/rad", above=0.0, example=20.0)
    damping: float = parameter(0.0, meaning="d of the shaft", unit="N m s/rad", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def resonance(self) -> float:
        """Undamped angular frequency (rad/s) of both against each other: `sqrt(c (1 / J_M + 1 / J_L))`."""
        return math.sqrt(self.stiffness * (1.0 / self.motor_inertia + 1.0 / self.load_inertia))

    @property
    def antiresonance(self) -> float:
        """Angular frequency (rad/s) at which the load swings against a motor that stands: `sqrt(c / J_L)`."""
        return math.sqrt(self.stiffness / self.load_inertia)

    @property
    def resonance_Hz(self) -> float:
        """The resonance, Hz."""
        return self.resonance / math.tau

    @property
    def antiresonance_Hz(self) -> float:
        """The antiresonance, Hz."""
        return self.antiresonance / math.tau

    @property
    def motor_response(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Numerator and denominator in s, highest power first, from motor torque (N m) to motor speed (rad/s)."""
        return (self.load_inertia, self.damping, self.stiffness), self._poles

    @property
    def load_response(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The same to the speed of the load."""
        return (self.damping, self.stiffness), self._poles

    @property
    def _poles(self) -> tuple[float, ...]:
        total = self.motor_inertia + self.load_inertia
        return self.motor_inertia * self.load_inertia, self.damping * total, self.stiffness * total, 0.0

    def state_matrices(self) -> tuple[Array, Array]:
        """A (3, 3) and B (3, 2) of `x' = A x + B u`: x as `TwoMassState`, u motor torque and load torque."""
        J, L, c, d = self.motor_inertia, self.load_inertia, self.stiffness, self.damping
        A = np.array([[0.0, 1.0, -1.0], [-c / J, -d / J, d / J], [c / L, d / L, -d / L]])
        return A, np.array([[0.0, 0.0], [1.0 / J, 0.0], [0.0, -1.0 / L]])

    def params(self, dt: float) -> TwoMassParams:
        """Params of `two_mass_step` for a step of `dt` (s) in which the torques stand still."""
        from scipy.linalg import expm

        require("TwoMass.params", "dt", dt, above=0.0)
        A, B = self.state_matrices()
        both = np.zeros((5, 5))
        both[:3, :3], both[:3, 3:] = A, B
        rows = expm(dt * both)[:3].tolist()
        return TwoMassParams(*(tuple(row) for row in rows))
