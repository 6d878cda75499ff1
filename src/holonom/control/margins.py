"""Margins of an open loop by its frequency response (spec 04.2)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.errors import OutOfLimits

__all__ = ["LoopMargin", "margin_of"]

FREQUENCIES = 3000  # of the search, over ten decades


@dataclass(frozen=True, slots=True)
class LoopMargin:
    """Crossover frequency (rad/s), phase margin (rad) and gain margin (a factor) of an open loop."""

    crossover: float
    phase_margin: float
    gain_margin: float


def margin_of(name: str, loop: Callable[[Any], Any], dt: float) -> LoopMargin:
    """Margins of an open loop by its frequency response, up to `pi / dt`.

    Parameters
    ----------
    name
        What an error calls it.
    loop
        Its response at complex frequencies (n,), rad/s; stable without feedback, integrators apart.
    dt
        Its sample time, s.

    Raises
    ------
    OutOfLimits
        It has none: closed, it is unstable.
    """
    w = np.geomspace(1e-10, 1.0, FREQUENCIES) * math.pi / dt
    response = loop(1j * w)
    size, angle = np.abs(response), np.unwrap(np.angle(response))
    angle -= 2.0 * math.pi * round((angle[0] + 0.5 * math.pi) / (2.0 * math.pi))  # starts between 0 and -180 deg
    falls = np.flatnonzero((size[:-1] >= 1.0) & (size[1:] < 1.0))
    turns = np.flatnonzero((angle[:-1] > -math.pi) & (angle[1:] <= -math.pi))
    at = [_between(np.log(size), np.log(w), k) for k in falls.tolist()]
    crossover = math.exp(at[-1]) if at else w[-1]
    phase = min((math.pi + float(np.interp(x, np.log(w), angle)) for x in at), default=-math.pi)
    gain = min((1.0 / math.exp(float(np.interp(_between(angle + math.pi, np.log(w), k), np.log(w), np.log(size))))
                for k in turns.tolist()), default=math.inf)  # fmt: skip
    if not (phase > 0.0 and gain > 1.0):
        raise OutOfLimits(
            f"the {name} loop is unstable at a sample time of {dt:g} s (phase margin "
            f"{math.degrees(phase):.1f} deg at {crossover:.4g} rad/s); sample faster"
        )
    return LoopMargin(crossover, phase, gain)


def _between(values: Array, places: Array, k: int) -> float:
    """Where values go through zero between samples k and k + 1."""
    part = values[k] / (values[k] - values[k + 1])
    return float(places[k] + part * (places[k + 1] - places[k]))
