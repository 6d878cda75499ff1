"""Cascade of balance: a PI of the speed asks for a pitch, a PD of the pitch for a force."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.balance.contract import BalanceLaw, Pendulum
from holonom.control.balance.kernels import BalanceGains
from holonom.registry import Method, parameter

__all__ = ["CASCADE", "CascadeBalance"]


@dataclass(frozen=True, slots=True, kw_only=True)
class CascadeBalance(BalanceLaw):
    """Outer loop of speed, inner loop of pitch.

    Raises
    ------
    OutOfLimits
        A number outside its range.

    Notes
    -----
    Inner: `F = (m G phi - D phi''_d)/(c + r m)` gives the body `phi''_d = -w^2 (phi - phi_c) - 2 z w phid`. Outer:
    `phi_c = -k (w_v (v - v_r) + (w_v/T)(p - p_r))` with k the pitch per acceleration: the place is the integral of the
    speed. Stable while the outer loop is slow beside the inner one and beside the zero of the speed, `w_v < 1/time` of
    the body; bandwidths are in parts of `1/time`.
    """

    pitch_bandwidth: float = parameter(
        3.0, meaning="w of the inner loop, in parts of the body's 1/time", unit="", above=1.0
    )
    pitch_damping: float = parameter(1.4, meaning="z of the inner loop", unit="", above=0.0)
    speed_bandwidth: float = parameter(
        0.5, meaning="w_v of the outer loop, in parts of 1/time", unit="", above=0.0, most=1.0
    )
    integral_time: float = parameter(
        5.0, meaning="T of the outer loop, in parts of the body's time", unit="", above=0.0
    )

    def gains(self, body: Pendulum) -> BalanceGains:
        """Gains of `balance_step` for a body."""
        w, D, lever = self.pitch_bandwidth / body.time, body.inertia, body.lever
        speed = body.lean * self.speed_bandwidth / body.time
        return BalanceGains(
            (body.rolling * body.stiffness + D * w * w) / lever,
            2.0 * self.pitch_damping * w * D / lever,
            speed,
            speed / (self.integral_time * body.time),
            body.rolling * body.stiffness / lever,
            self.max_lean,
            self.max_place,
            body.max_force,
            self.trim_time * body.time,
        )


CASCADE = Method(
    "a PI of the speed asks for a pitch, a PD of the pitch for a force",
    lambda law: law,
    "Grasser, D'Arrigo, Colombi & Rufer, IEEE Trans. Industrial Electronics 49(1), 2002",
    CascadeBalance,
)
