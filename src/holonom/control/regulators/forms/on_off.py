"""Regulators that switch: two, three or five positions, with hysteresis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import Regulator, RegulatorSettings
from holonom.errors import OutOfLimits
from holonom.registry import Method, parameter
from holonom.trace.code.loops import loop

__all__ = [
    "FIVE_POSITIONS",
    "THREE_POSITIONS",
    "TWO_POSITIONS",
    "FiveSettings",
    "OnOffParams",
    "OnOffState",
    "ThreeSettings",
    "TwoSettings",
    "on_off_step",
]


class OnOffParams(NamedTuple):
    """Positions above the lowest one; error up to which each is reached from below (up to four); hysteresis."""

    top: int
    up: tuple[float, float, float, float]
    hysteresis: float


class OnOffState(NamedTuple):
    """Position, from 0 (low) to the top one (high), and last output."""

    position: int
    output: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoSettings(RegulatorSettings):
    """High above half the hysteresis, low below minus that half.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    hysteresis: float = parameter(0.0, meaning="error between switching on and off, in units of y", least=0.0)

    def params(self, dt: float) -> OnOffParams:
        """Params of `on_off_step`, the same at every sample time."""
        del dt
        return OnOffParams(1, (0.5 * self.hysteresis, 0.0, 0.0, 0.0), self.hysteresis)


@dataclass(frozen=True, slots=True, kw_only=True)
class ThreeSettings(RegulatorSettings):
    """High above `inner`, low below `-inner`, the middle of the limits between them; back `hysteresis` earlier.

    Raises
    ------
    OutOfLimits
        A number outside its range, a hysteresis above `inner`.
    """

    inner: float = parameter(meaning="error from which it switches, in units of y", above=0.0, example=0.5)
    hysteresis: float = parameter(0.0, meaning="between switching on and off, in units of y", least=0.0)

    def __post_init__(self) -> None:
        RegulatorSettings.__post_init__(self)
        _fits(self.hysteresis, self.inner, "inner")

    def params(self, dt: float) -> OnOffParams:
        """Params of `on_off_step`, the same at every sample time."""
        del dt
        return OnOffParams(2, (self.hysteresis - self.inner, self.inner, 0.0, 0.0), self.hysteresis)


@dataclass(frozen=True, slots=True, kw_only=True)
class FiveSettings(ThreeSettings):
    """As three positions at half strength, and at full strength beyond `outer`.

    Raises
    ------
    OutOfLimits
        A number outside its range, a hysteresis above `inner` or above `outer - inner`.
    """

    outer: float = parameter(meaning="error from which it switches fully, in units of y", above=0.0, example=1.5)

    def __post_init__(self) -> None:
        ThreeSettings.__post_init__(self)
        _fits(self.hysteresis, self.outer - self.inner, "outer - inner")

    def params(self, dt: float) -> OnOffParams:
        """Params of `on_off_step`, the same at every sample time."""
        del dt
        h = self.hysteresis
        return OnOffParams(4, (h - self.outer, h - self.inner, self.inner, self.outer), h)


def _fits(hysteresis: float, room: float, name: str) -> None:
    if not hysteresis <= room or room <= 0.0:
        raise OutOfLimits(f"hysteresis is {hysteresis!r}, {name} {room!r}; {name} must be positive and not below it")


@loop
def on_off_step(
    params: OnOffParams, state: OnOffState, r: float, y: float, low: float, high: float
) -> tuple[float, OnOffState]:
    """Output and next state: one of the positions, which divide [low, high] evenly."""
    e = r - y
    if not math.isfinite(e):
        return state.output, state
    position = state.position
    while position < params.top and e > params.up[position]:
        position += 1
    while position > 0 and e < params.up[position - 1] - params.hysteresis:
        position -= 1
    u = low + (high - low) * (position / params.top)
    return u, OnOffState(position, u)


@loop
def on_off_start(params: OnOffParams, u: float, r: float, y: float, low: float, high: float) -> OnOffState:
    """State of the position whose output is nearest to u; it switches at the next step if the error asks for it."""
    part = min(max((u - low) / (high - low), 0.0), 1.0)
    position = math.ceil(part * params.top - 0.5)
    return OnOffState(position, low + (high - low) * (position / params.top))


def _regulator(settings: RegulatorSettings) -> Regulator:
    return Regulator(on_off_step, on_off_start, settings, recoils=False, switches=True)


_SOURCE = "Tsypkin, Relay Control Systems, 1984; specification 04.1"
TWO_POSITIONS = Method("high or low, by the sign of the error; no recoil", _regulator, _SOURCE, TwoSettings)
THREE_POSITIONS = Method("high, middle or low; no recoil", _regulator, _SOURCE, ThreeSettings)
FIVE_POSITIONS = Method("high, low, middle and halfway to either; no recoil", _regulator, _SOURCE, FiveSettings)
