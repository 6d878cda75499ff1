"""Remaining errors by type number: steps, ramps, parabolas of the reference and of the load (specification 04.5)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.errors import OutOfLimits

__all__ = ["Remaining", "RemainingErrors", "remaining_errors"]


@dataclass(frozen=True, slots=True)
class Remaining:
    """Error after long, of a step 1, a ramp t, a parabola t^2/2; infinite where it grows for ever."""

    step: float
    ramp: float
    parabola: float


@dataclass(frozen=True, slots=True)
class RemainingErrors:
    """Of the reference, and of a load that acts before the plant, against its output."""

    reference: Remaining
    load: Remaining


def remaining_errors(
    loop_type: int, *, gain: float = 1.0, regulator_type: int = 0, regulator_gain: float | None = None
) -> RemainingErrors:
    """Errors `r - y` that a stable loop is left with.

    With `L = R P -> K/s^N` and `R -> K_R/s^m` for small s, by the final value theorem: of the reference
    `lim s (1/s^(k+1)) / (1 + L)`, of the load `lim s (1/s^(k+1)) P / (1 + L)`, k = 0, 1, 2.

    Parameters
    ----------
    loop_type, gain
        N, integrators of the open loop, and its K.
    regulator_type, regulator_gain
        m, integrators before the place where the load comes in, at most N; K_R, that of the loop unless given (P with
        gain 1).

    Raises
    ------
    OutOfLimits
        A type below 0, a regulator of more integrators than the loop, gains that are not positive.

    Notes
    -----
    Aastroem, Murray, *Feedback Systems*, 12.1; Ogata, *Modern Control Engineering*, 5-8. An integrator of the plant
    takes away what the reference leaves, not what the load leaves.
    """
    known = gain if regulator_gain is None else regulator_gain
    if not 0 <= regulator_type <= loop_type:
        raise OutOfLimits(
            f"remaining_errors: loop_type is {loop_type}, regulator_type {regulator_type}; 0 <= regulator_type <= "
            "loop_type is needed"
        )
    if not (0.0 < gain < math.inf and 0.0 < known < math.inf):
        raise OutOfLimits(f"remaining_errors: gains are {gain!r}, {known!r}; they must be finite and greater than 0")
    less = gain / (1.0 + gain) if loop_type == 0 else 1.0  # without an integrator the loop is not stiff at rest
    reference = _left(loop_type, less / gain)
    load = _left(regulator_type, less / known)
    return RemainingErrors(reference, load)


def _left(integrators: int, error: float) -> Remaining:
    """`error` of the input that so many integrators just do not take away."""
    step, ramp, parabola = (0.0 if k < integrators else error if k == integrators else math.inf for k in range(3))
    return Remaining(step, ramp, parabola)
