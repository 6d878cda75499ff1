"""What all ways to find a zero share: phases, faults, state."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

from holonom.trace.code.loops import loop

__all__ = [
    "HOMING_START",
    "HomingFault",
    "HomingPhase",
    "HomingState",
    "homing_done",
    "homing_failed",
    "homing_state",
    "later",
]


class HomingPhase(IntEnum):
    """Where a homing stands."""

    START = 0
    BACKING_OFF = 1
    SEARCHING = 2
    LEAVING = 3
    TO_INDEX = 4
    DONE = 5
    FAILED = 6


class HomingFault(IntEnum):
    """Why a homing failed."""

    NONE = 0
    TIME_OUT = 1
    WRONG_TURN = 2
    MISSING_INDEX = 3
    MISSING_SWITCH = 4
    STUCK_SWITCH = 5
    NO_SIGNAL = 6
    APART = 7


class HomingState(NamedTuple):
    """How far a homing has got.

    Phase (`HomingPhase`) and fault (`HomingFault`); samples since the start; count and index pulses at the start of the
    phase, and where the potentiometer then was, counts; speed that is asked of the axis, counts/s; once it is done,
    what is added: position = count + offset.
    """

    phase: int
    fault: int
    samples: int
    mark: int
    pulses: int
    coarse: float
    speed: float
    offset: int


HOMING_START = HomingState(0, 0, 0, 0, 0, 0.0, 0.0, 0)
"""State before the first sample."""


@loop
def homing_state(before: HomingState, phase: int, count: int, pulses: int, coarse: float, speed: float) -> HomingState:
    """A phase that begins here."""
    return HomingState(phase, 0, before.samples, count, pulses, coarse, speed, 0)


@loop
def homing_done(before: HomingState, offset: int) -> HomingState:
    """Stop: the zero is found."""
    return HomingState(5, 0, before.samples, before.mark, before.pulses, before.coarse, 0.0, offset)


@loop
def later(state: HomingState) -> HomingState:
    """One sample on."""
    return HomingState(
        state.phase,
        state.fault,
        state.samples + 1,
        state.mark,
        state.pulses,
        state.coarse,
        state.speed,
        state.offset,
    )


@loop
def homing_failed(before: HomingState, fault: int) -> HomingState:
    """Stop: it failed."""
    return HomingState(6, fault, before.samples, before.mark, before.pulses, before.coarse, 0.0, 0)
