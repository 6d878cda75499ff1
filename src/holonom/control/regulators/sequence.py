"""A regulator over a sequence: references and measurements in, outputs out, all in one compiled loop."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

from holonom.arrays import Array, finite_array, real_array
from holonom.control.regulators.contract import sample_time
from holonom.control.regulators.kernels import ramp_step
from holonom.control.regulators.methods import REGULATORS
from holonom.errors import OutOfLimits, ShapeError
from holonom.trace.code.loops import loop

__all__ = ["respond"]


def respond(
    name: str,
    r: Any,
    y: Any,
    *,
    dt: float,
    limits: tuple[float, float],
    start: float | None = None,
    manual: Any = None,
    rate: float = math.inf,
    **gains: Any,
) -> Array:
    """Outputs of a regulator for references and measurements.

    Parameters
    ----------
    name
        Of `REGULATORS`.
    r, y
        Reference and measurement, (N,); either may be a single number.
    dt
        Sample time, s.
    limits
        Lowest and highest output.
    start
        Output that it takes over from, without a bump at `r[0]`, `y[0]`; None: it starts from rest, all memory 0.
    manual
        (N,), outputs commanded by hand, NaN where the regulator is on; it takes over without a bump.
    rate
        Greatest rate of the reference that the regulator sees, 1/s, beginning at the measurement.
    gains
        Those of the form, by name: `Kc`, `Ti`, ...; `holonom methods regulators` lists them.

    Returns
    -------
    (N,), within the limits.

    Raises
    ------
    UnknownName
        No such regulator or gain; lists what there is.
    InputError
        A gain that is missing; lists what is needed.
    OutOfLimits
        A gain, sample time, rate, or output by hand outside its range; limits that are empty.
    ShapeError, NotFinite
        r and y of other shapes, or NaN. The compiled step itself holds output and state at such a sample.
    """
    regulator = REGULATORS.make(name, gains)
    low, high = _limits(limits, regulator.switches)
    params = regulator.settings.params(sample_time(dt))
    measured = finite_array("y", np.atleast_1d(real_array("y", y)), ("N",))
    wanted = finite_array("r", np.atleast_1d(real_array("r", r)), ("N",))
    n = max(len(measured), len(wanted))
    if not {len(measured), len(wanted)} <= {1, n}:
        raise ShapeError(f"r holds {len(wanted)} samples, y {len(measured)}; as many, or one, are needed")
    measured, wanted = (np.ascontiguousarray(np.broadcast_to(x, n)) for x in (measured, wanted))
    if not rate > 0.0:
        raise OutOfLimits(f"rate is {rate!r}; it must be greater than 0 1/s (inf: no limit)")
    hand = _by_hand(manual, n, low, high)
    seen = measured[0] if rate < math.inf else wanted[0]
    if start is None:
        state = regulator.start(params, 0.0, 0.0, 0.0, low, high)
    else:
        if not low <= start <= high:
            raise OutOfLimits(f"start is {start!r}; an output must be from {low:g} to {high:g}")
        state = regulator.start(params, float(start), seen, measured[0], low, high)
    run = _sequence(regulator.step, regulator.start)
    return run(params, state, wanted, measured, hand, low, high, seen, float(rate) * dt)


def _limits(limits: tuple[float, float], switches: bool) -> tuple[float, float]:
    pair = np.ravel(real_array("limits", limits))
    if len(pair) != 2 or not pair[0] < pair[1]:
        raise OutOfLimits(f"limits are {limits!r}; the lowest and the highest output are needed, in this order")
    low, high = float(pair[0]), float(pair[1])
    if switches and not (math.isfinite(low) and math.isfinite(high)):
        raise OutOfLimits(f"limits are {limits!r}; a regulator that switches needs finite ones")
    return low, high


def _by_hand(manual: Any, n: int, low: float, high: float) -> Array:
    hand = np.full(n, math.nan) if manual is None else real_array("manual", manual)
    if hand.shape != (n,):
        raise ShapeError(f"manual has shape {hand.shape}; ({n},) is needed")
    wrong = ~np.isnan(hand) & ~((hand >= low) & (hand <= high))
    if wrong.any():
        k = int(np.argmax(wrong))
        raise OutOfLimits(f"manual[{k}] is {hand[k]}; an output must be from {low:g} to {high:g}, NaN for automatic")
    return np.ascontiguousarray(hand)


@functools.cache
def _sequence(step: Any, start: Any) -> Any:
    """The loop around a form's step: outputs (N,), the regulator's, or those by hand, which its state follows."""

    @loop
    def sequence(params, state, r, y, manual, low, high, seen, most):  # type: ignore[no-untyped-def]
        outputs = np.empty_like(r)
        for k in range(r.shape[0]):
            by_hand = not math.isnan(manual[k])
            if most == math.inf:
                seen = r[k]
            elif by_hand:
                seen = y[k]
            else:
                seen = ramp_step(seen, r[k], most)
            if by_hand:
                outputs[k] = manual[k]
                state = start(params, manual[k], seen, y[k], low, high)
            else:
                outputs[k], state = step(params, state, seen, y[k], low, high)
        return outputs

    return sequence
