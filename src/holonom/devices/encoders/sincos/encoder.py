"""A 1 Vpp encoder: sine and cosine with offset, gain and phase errors, interpolated by the arctangent (spec 03.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["SinCosEncoder", "SinCosParams", "fine_angle", "interpolate", "quarter_of", "sincos_signals"]

FINE = 4096
"""Points of a period at which the largest error is looked for."""


class SinCosParams(NamedTuple):
    """Lines per turn; amplitude, V; offsets, gain of the sine over the cosine, relative; phase of the sine, rad."""

    lines: int
    amplitude: float
    sine_offset: float
    cosine_offset: float
    gain_ratio: float
    phase_error: float


@dataclass(frozen=True, slots=True)
class SinCosEncoder:
    """An encoder whose channels are a sine and a cosine, one period a line.

    Raises
    ------
    ModelError
        A field outside its range: errors so large that the arctangent does not go round.
    """

    lines: int = parameter(meaning="periods per turn", least=1, most=2**28, example=2048)
    amplitude: float = parameter(0.5, meaning="of the signals, 0.5 V of 1 Vpp", unit="V", above=0.0)
    sine_offset: float = parameter(0.0, meaning="of the sine over the amplitude", least=-0.5, most=0.5)
    cosine_offset: float = parameter(0.0, meaning="of the cosine over the amplitude", least=-0.5, most=0.5)
    gain_ratio: float = parameter(1.0, meaning="amplitude of the sine over that of the cosine", least=0.5, most=2.0)
    phase_error: float = parameter(0.0, meaning="by which the sine leads", unit="rad", least=-0.5, most=0.5)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self) -> SinCosParams:
        """Params of `sincos_signals` and `fine_angle`."""
        offsets = (self.sine_offset, self.cosine_offset)
        return SinCosParams(self.lines, self.amplitude, *offsets, self.gain_ratio, self.phase_error)

    def largest_error(self) -> float:
        """Greatest error (rad of the shaft) of the interpolation within a period, by trying every part of it.

        First order, over the lines: an offset gives itself, a gain ratio of 1 + e gives e/2, a phase error all of it.
        """
        phase = 2.0 * math.pi * np.arange(FINE) / FINE
        sine = self.sine_offset + self.gain_ratio * np.sin(phase + self.phase_error)
        cosine = self.cosine_offset + np.cos(phase)
        error = np.arctan2(sine, cosine) - phase
        return float(np.abs(np.remainder(error + math.pi, 2.0 * math.pi) - math.pi).max()) / self.lines

    def resolution(self, bits: int) -> float:
        """Largest step (rad of the shaft) with converters of some bits over the swing: `sqrt(8) / (2^bits lines)`.

        Where a signal passes zero a step of its converter is `2/2^bits` of phase; half-way between, both step at once.
        """
        require("SinCosEncoder.resolution", "bits", bits, least=2)
        return math.sqrt(8.0) / 2.0**bits / self.lines


@loop
def sincos_signals(params: SinCosParams, angle: float) -> tuple[float, float]:
    """Sine and cosine (V) at an angle of the shaft (rad)."""
    phase = params.lines * angle
    sine = params.sine_offset + params.gain_ratio * math.sin(phase + params.phase_error)
    return params.amplitude * sine, params.amplitude * (params.cosine_offset + math.cos(phase))


@loop
def interpolate(sine: float, cosine: float) -> float:
    """Phase within the period, 0 to 2 pi (rad), by the arctangent."""
    phase = math.atan2(sine, cosine)
    return phase if phase >= 0.0 else phase + 2.0 * math.pi


@loop
def quarter_of(params: SinCosParams, angle: float) -> int:
    """Count of a fourfold counter behind comparators of healthy signals, at an angle of the shaft (rad)."""
    return math.floor(angle * params.lines * 2.0 / math.pi)


@loop
def fine_angle(params: SinCosParams, quarters: int, sine: float, cosine: float) -> float:
    """Angle of the shaft (rad) from the count of quarters of a period and the signals (V).

    The count says which period, the arctangent where in it. The count may be off by more than a quarter: comparators
    switch at other places than the arctangent.
    """
    phase = interpolate(sine, cosine) / (2.0 * math.pi)
    period = math.floor(0.25 * (quarters + 0.5) - phase + 0.5)
    return (period + phase) * 2.0 * math.pi / params.lines
