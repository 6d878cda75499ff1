"""LQR of balance: pitch, its rate, speed and place weighed against the force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holonom.control.balance.contract import BalanceLaw, Pendulum
from holonom.control.balance.kernels import BalanceGains
from holonom.model.gravity import GRAVITY
from holonom.registry import Method, parameter

__all__ = ["LQR", "LqrBalance"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LqrBalance(BalanceLaw):
    """Linear quadratic regulator about upright, with Bryson's weights.

    Raises
    ------
    OutOfLimits
        A number outside its range.

    Notes
    -----
    `A' P + P A - P B R^-1 B' P + Q = 0`, `F = -R^-1 B' P x` (Anderson & Moore, *Optimal Control: Linear Quadratic
    Methods*, 2.3), x pitch, its rate, speed, place. Stable about upright with a gain margin of one half upwards and 60
    degrees of phase; from large leans as far as the largest force carries.
    """

    error_pitch: float = parameter(0.1, meaning="pitch that weighs as much as `effort`", unit="rad", above=0.0)
    error_rate: float = parameter(0.5, meaning="its rate", unit="rad/s", above=0.0)
    error_speed: float = parameter(0.3, meaning="speed", unit="m/s", above=0.0)
    error_place: float = parameter(0.1, meaning="place along the way", unit="m", above=0.0)
    effort: float = parameter(0.1, meaning="force, in parts of gravity on what rolls", unit="", above=0.0)

    def gains(self, body: Pendulum) -> BalanceGains:
        """Gains of `balance_step` for a body."""
        from scipy.linalg import solve_continuous_are  # heavy: on first use

        A, B = body.matrices
        Q = np.diag(np.square(np.reciprocal([self.error_pitch, self.error_rate, self.error_speed, self.error_place])))
        R = np.array([[(self.effort * body.rolling * GRAVITY) ** -2]])
        pitch, rate, speed, place = (-np.linalg.solve(R, B.T @ solve_continuous_are(A, B, Q, R))[0]).tolist()
        return BalanceGains(
            pitch,
            rate,
            speed / pitch,
            place / pitch,
            0.0,
            self.max_lean,
            self.max_place,
            body.max_force,
            self.trim_time * body.time,
        )


LQR = Method(
    "linear quadratic regulator of pitch, its rate, speed and place",
    lambda law: law,
    "Anderson & Moore, Optimal Control: Linear Quadratic Methods, 2.3; Pathak, Franch & Agrawal, T-RO 21(3), 2005",
    LqrBalance,
)
