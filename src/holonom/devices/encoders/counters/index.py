"""The index holds the count to the turn: pulses that were lost are found, reported, put right (spec 03.3, 03.5)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = [
    "INDEX_START",
    "IndexCorrection",
    "IndexFault",
    "IndexParams",
    "IndexState",
    "corrected_count",
    "index_step",
]


class IndexFault(IntEnum):
    """What the index says of the count."""

    NONE = 0
    LOST = 1
    MISSING = 2
    MISPLACED = 3


class IndexParams(NamedTuple):
    """Counts per turn, counts that may be off, counts that an index can put right, whether it does at each crossing."""

    counts_per_rev: int
    tolerance: int
    most: int
    each: int


class IndexState(NamedTuple):
    """What the index has told so far.

    Pulses seen, corrected count of the last one, what is added to the count; lost since the last one and in all
    (positive: the counter stands too low), and the fault (`IndexFault`).
    """

    pulses: int
    previous: int
    offset: int
    lost: int
    total_lost: int
    fault: int


INDEX_START = IndexState(0, 0, 0, 0, 0, 0)
"""State before the first index."""


@dataclass(frozen=True, slots=True)
class IndexCorrection:
    """How an index is used: at the reference run only, or at each crossing.

    Raises
    ------
    ModelError
        Counts that an index can put right beyond half a turn: the turn would be another one.
    """

    counts_per_rev: int = parameter(meaning="counts per turn after decoding", least=4, example=4000)
    each_crossing: bool = parameter(True, meaning="put the count right at each crossing, else only tell")
    tolerance: int = parameter(1, meaning="counts that an index may be off before it is a fault", least=0)
    largest: float = parameter(0.25, meaning="part of a turn; an error beyond it is no lost pulse", above=0.0, most=0.5)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.tolerance >= self.params().most:
            raise ModelError(
                f"IndexCorrection: tolerance is {self.tolerance} counts; it must be less than largest, "
                f"{self.params().most} counts"
            )

    def params(self) -> IndexParams:
        """Params of `index_step`."""
        return IndexParams(
            self.counts_per_rev, self.tolerance, int(self.largest * self.counts_per_rev), int(self.each_crossing)
        )


@loop
def corrected_count(state: IndexState, count: int) -> int:
    """The count with all that was found lost."""
    return count + state.offset


@loop
def index_step(params: IndexParams, state: IndexState, count: int, pulses: int, index_count: int) -> IndexState:
    """One look at the counter: its count, the index pulses so far and the count latched at the last one.

    The first index is the reference. At each one after it the corrected count must be `previous index count +
    counts_per_rev * {-1, 0, 1}`; what it is off by was lost (or was too much). More than an index can put right is
    `MISPLACED`: no lost pulse but wrong counts per turn, or a pulse that is none; the count is then left alone. A turn
    and more without one is `MISSING`.
    """
    per_rev, offset = params.counts_per_rev, state.offset
    if pulses == state.pulses:
        away = abs(count + offset - state.previous)
        missing = state.pulses > 0 and away > per_rev + params.most
        return IndexState(
            state.pulses, state.previous, offset, state.lost, state.total_lost, 2 if missing else state.fault
        )
    at = index_count + offset
    if state.pulses == 0:
        return IndexState(pulses, at, offset, 0, 0, 0)
    moved = at - state.previous
    turns = 1 if 2 * moved > per_rev else (-1 if 2 * moved < -per_rev else 0)
    error = state.previous + turns * per_rev - at
    if abs(error) > params.most:
        return IndexState(pulses, at, offset, error, state.total_lost, 3)
    if params.each:
        offset += error
        at += error
    return IndexState(pulses, at, offset, error, state.total_lost + error, 1 if abs(error) > params.tolerance else 0)
