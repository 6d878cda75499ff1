"""What all regulators share: their settings, and `Regulator`."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from holonom.arrays import is_number
from holonom.errors import OutOfLimits
from holonom.registry import check_fields, parameter

__all__ = ["DISCRETISATIONS", "PiSettings", "PidSettings", "Regulator", "RegulatorSettings", "sample_time"]

DISCRETISATIONS = ("backward", "tustin", "zoh")
"""Backward differences, trapezoids, zero-order hold (step-invariant) of a continuous regulator."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RegulatorSettings(ABC):
    """Gains of a regulator, in the book's letters, and `params` of its compiled step.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    def __post_init__(self) -> None:
        check_fields(self)

    @abstractmethod
    def params(self, dt: float) -> Any:
        """Params of the step at a sample time, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PiSettings(RegulatorSettings):
    """Gains of a PI regulator. A process of negative gain is regulated with r and y exchanged."""

    Kc: float = parameter(meaning="gain, in units of u over units of y", above=0.0, example=2.0)
    Ti: float = parameter(meaning="integral time, infinite for none", unit="s", above=0.0, most=math.inf, example=1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PidSettings(PiSettings):
    """Gains of a PID regulator and how it is made discrete."""

    Td: float = parameter(0.0, meaning="derivative time", unit="s", least=0.0)
    T: float = parameter(0.0, meaning="lag of the derivative's filter", unit="s", least=0.0)
    method: str = parameter("backward", meaning="of making it discrete", choices=DISCRETISATIONS)


@dataclass(frozen=True, slots=True)
class Regulator:
    """A form of regulator and its settings.

    Attributes
    ----------
    step
        Compiled: `step(params, state, r, y, low, high) -> (u, state)`; r, y are reference and measurement, u lies in
        [low, high]. Where r or y is NaN or infinite, output and state are held.
    start
        Compiled: `start(params, u, r, y, low, high) -> state`: with this state, the next step at the same r and y gives
        u: bumpless start, and the state to keep while a hand commands u. `start(params, 0, 0, 0, low, high)` is rest.
    settings
        `settings.params(dt)` are its params.
    recoils
        Whether a single wrong measurement that drives the output to its limit throws it towards the other limit
        afterwards (specification 04.5), derivative apart.
    switches
        Whether its output takes certain values only: on-off, time-proportional.
    """

    step: Callable[..., Any]
    start: Callable[..., Any]
    settings: RegulatorSettings
    recoils: bool
    switches: bool = False


def sample_time(dt: float) -> float:
    """Return a sample time, s.

    Raises
    ------
    OutOfLimits
        It is not finite and positive.
    """
    if not is_number(dt) or not 0.0 < dt < math.inf:
        raise OutOfLimits(f"dt is {dt!r}; a sample time must be finite and greater than 0 s")
    return float(dt)
