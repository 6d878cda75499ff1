"""Table of the laws that balance an inverted pendulum."""

from __future__ import annotations

from holonom.registry import Table

__all__ = ["BALANCE_LAWS"]

_HERE = "holonom.control.balance"

BALANCE_LAWS = Table(
    "balance_laws",
    "law of balance",
    "a `BalanceLaw`: gains of `balance_step` for a body",
    {"lqr": f"{_HERE}.lqr:LQR", "cascade": f"{_HERE}.cascade:CASCADE"},
)
