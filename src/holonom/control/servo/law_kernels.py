"""Compiled parts of the servos beside the default cascade: filters, the regulator of the speed, the shift in a gap."""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.control.servo.kernels import SpeedParams
from holonom.trace.code.loops import loop

__all__ = [
    "LAW_START",
    "ONE_LOOP",
    "PASSES",
    "THREE_LOOPS",
    "TWO_LOOPS",
    "BiquadParams",
    "BiquadState",
    "LawParams",
    "LawState",
    "biquad_step",
    "gap_shift",
    "law_speed_step",
]

THREE_LOOPS, TWO_LOOPS, ONE_LOOP = 0, 1, 2
"""Position over speed over current, each with its own sample; position over current; position over voltage."""


class BiquadParams(NamedTuple):
    """`(b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2)`."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class BiquadState(NamedTuple):
    """Memory of a biquad, direct form II transposed."""

    z1: float
    z2: float


class LawParams(NamedTuple):
    """What makes a servo another one than the default cascade.

    Attributes
    ----------
    form
        How many loops.
    tachometer
        The speed is that of a tachometer, regulated at the current loop's sample time.
    on_load
        The position is that of the load's encoder.
    compensation
        Part of the disturbance seen by the observer that goes into the current.
    gap, crossing, crossing_gain
        Backlash at the motor, rad; greatest speed through it, rad/s, and 1/s with which it comes to the other flank.
    lead, notch
        Of the speed error; of the regulator's output.
    """

    form: int
    tachometer: bool
    on_load: bool
    compensation: float
    gap: float
    crossing: float
    crossing_gain: float
    lead: BiquadParams
    notch: BiquadParams


class LawState(NamedTuple):
    """Memory of both filters; shift of the motor against the load, rad."""

    lead: BiquadState
    notch: BiquadState
    shift: float


PASSES = BiquadParams(1.0, 0.0, 0.0, 0.0, 0.0)
LAW_START = LawState(BiquadState(0.0, 0.0), BiquadState(0.0, 0.0), 0.0)


@loop(error_model="numpy", forceinline=True)
def biquad_step(params: BiquadParams, state: BiquadState, x: float) -> tuple[float, BiquadState]:
    """Output and next state of a second-order filter."""
    y = params.b0 * x + state.z1
    return y, BiquadState(params.b1 * x - params.a1 * y + state.z2, params.b2 * x - params.a2 * y)


@loop(error_model="numpy", forceinline=True)
def law_speed_step(
    law: LawParams, params: SpeedParams, state: LawState, integral: float, reference: float, rate: float,
    feedforward: float,
) -> tuple[float, float, LawState]:  # fmt: skip
    """Current (A) from motor speeds (rad/s): PI or PD, then the notch, then what is known, clipped last.

    With one loop the current is that of a voltage at rest, `u / R`. The integral stands still while the output is at
    a limit and the error pushes it further.
    """
    error = reference - rate
    led, lead = biquad_step(law.lead, state.lead, error)
    grown = integral + params.integral_gain * error
    passed, notch = biquad_step(law.notch, state.notch, params.gain * led + grown)
    wanted = passed + feedforward
    most, top, emf = params.max_current, params.conductance * params.max_voltage, params.conductance * params.back_emf
    if law.form == ONE_LOOP:
        high = max(min(most + emf * rate, top), -top)
        low = min(max(-most + emf * rate, -top), top)
    else:
        high = max(min(most, top - emf * rate), -most)
        low = min(max(-most, -top - emf * rate), most)
    output = min(max(wanted, low), high)
    stays = (wanted - output) * error > 0.0
    return output, integral if stays else grown, LawState(lead, notch, state.shift)


@loop(error_model="numpy", forceinline=True)
def gap_shift(law: LawParams, shift: float, speed: float, dt: float) -> tuple[float, float]:
    """Where the motor is to be against the load (rad), a sample later, and how fast it gets there (rad/s).

    It pushes with the flank on the side of the motion: half a gap ahead of the load.
    """
    target = math.copysign(0.5 * law.gap, speed) if speed != 0.0 else shift
    rate = min(max(law.crossing_gain * (target - shift), -law.crossing), law.crossing)
    return shift + dt * rate, rate
