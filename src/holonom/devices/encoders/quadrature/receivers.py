"""Line receivers: differential pairs of RS-422, 1 Vpp and 11 uA encoders (spec 03.3, 03.5).

A pair carries `middle + d/2` and `middle - d/2`. Both wires together are twice the middle in every state of the signal:
a broken wire goes where the receiver's bias pulls it, and the sum is off in the very sample in which it breaks. Wires
of two pairs that are exchanged leave both sums off whenever the pairs carry different values, one by as much up as the
other down. A pair whose own wires are exchanged only inverts its signal: the index, low nearly everywhere and high
only where A and B are low, tells that (`index_misplaced`); of A or B alone it is the direction.

| kind | middle | amplitude of d | taken | an open wire goes to | sources |
|---|---|---|---|---|---|
| `rs422` | 2.5 V | 4 V | 0.2 V and more | 2.5 V | TIA/EIA-422-B (receiver threshold 0.2 V) |
| `sine_1vpp` | 2.5 V | 0.5 V | 0.3 to 0.6 V | 0 V | encoder makers' interface sheets (1 Vpp: 0.6 to 1.2 Vpp) |
| `current_11ua` | 8 uA | 5.5 uA | 3.5 to 8 uA | 0 uA | encoder makers' interface sheets (11 uApp: 7 to 16 uApp) |

Middles and pulls are those of common circuits; the middle of 11 uA is the mean light on a photo element.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from types import MappingProxyType
from typing import NamedTuple

from holonom.errors import ModelError, UnknownName
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = [
    "LINE_RECEIVERS",
    "LineFault",
    "LineReceiver",
    "ReceiverParams",
    "drive_pair",
    "index_misplaced",
    "line_receiver",
    "receive_pair",
    "receive_pairs",
]


class LineFault(IntEnum):
    """What a receiver says of its lines."""

    NONE = 0
    BROKEN = 1
    SWAPPED = 2
    WEAK = 3


class ReceiverParams(NamedTuple):
    """Middle of a pair, what the sum of its wires may be off by, least and most amplitude, whether it is a sine (1)."""

    middle: float
    mismatch: float
    least: float
    most: float
    analogue: int


@dataclass(frozen=True, slots=True)
class LineReceiver:
    """A receiver of differential pairs, V or uA.

    Raises
    ------
    ModelError
        An amplitude that it would not take itself; a middle or a tolerance that is not positive.
    """

    middle: float = parameter(2.5, meaning="mean of both wires, V or uA", above=0.0)
    amplitude: float = parameter(4.0, meaning="of the difference of both wires, V or uA", above=0.0)
    least: float = parameter(0.2, meaning="smallest amplitude that is taken, V or uA", above=0.0)
    most: float = parameter(10.0, meaning="greatest amplitude that is taken, V or uA", above=0.0)
    mismatch: float = parameter(1.0, meaning="what the sum of both wires may be off by, V or uA", above=0.0)
    pull: float = parameter(2.5, meaning="where an open wire goes, V or uA", least=0.0)
    analogue: bool = parameter(False, meaning="whether the signal is a sine instead of two levels")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if not self.least <= self.amplitude <= self.most:
            raise ModelError(
                f"LineReceiver: amplitude is {self.amplitude:g}; "
                f"it must lie within least {self.least:g} and most {self.most:g}"
            )
        nearest = abs(self.pull - self.middle) - 0.5 * self.most if self.analogue else self._to_a_level()
        if nearest <= self.mismatch:
            raise ModelError(
                f"LineReceiver: an open wire goes to {self.pull:g}, {max(nearest, 0.0):g} from where a healthy one may "
                f"be; that must exceed the mismatch, {self.mismatch:g}"
            )

    def _to_a_level(self) -> float:
        """From where an open wire goes to the nearer of the two levels."""
        return min(abs(self.pull - self.middle - side * 0.5 * self.amplitude) for side in (1.0, -1.0))

    def params(self) -> ReceiverParams:
        """Params of `receive_pair` and `receive_pairs`."""
        return ReceiverParams(self.middle, self.mismatch, self.least, self.most, int(self.analogue))


LINE_RECEIVERS: Mapping[str, LineReceiver] = MappingProxyType(
    {
        "rs422": LineReceiver(2.5, 4.0, 0.2, 10.0, mismatch=1.0, pull=2.5),
        "sine_1vpp": LineReceiver(2.5, 0.5, 0.3, 0.6, mismatch=0.2, pull=0.0, analogue=True),
        "current_11ua": LineReceiver(8.0, 5.5, 3.5, 8.0, mismatch=1.5, pull=0.0, analogue=True),
    }
)
"""Receivers by kind of interface."""


def line_receiver(kind: str) -> LineReceiver:
    """Receiver of a kind of interface.

    Raises
    ------
    UnknownName
    """
    if kind not in LINE_RECEIVERS:
        raise UnknownName("line receiver", kind, LINE_RECEIVERS)
    return LINE_RECEIVERS[kind]


@loop
def drive_pair(params: ReceiverParams, difference: float) -> tuple[float, float]:
    """What both wires carry for a difference."""
    return params.middle + 0.5 * difference, params.middle - 0.5 * difference


@loop
def receive_pair(params: ReceiverParams, plus: float, minus: float) -> tuple[float, int]:
    """Difference of a pair and its fault (`LineFault`) in this sample.

    Broken: the sum of the wires is off, or not a number. Weak: two levels that differ too little or too much. Of a
    sine, the amplitude shows in two channels only: `receive_pairs`.
    """
    difference = plus - minus
    if not abs(plus + minus - 2.0 * params.middle) <= params.mismatch:
        return difference, 1
    if not abs(difference) <= params.most:
        return difference, 3
    if params.analogue == 0 and abs(difference) < params.least:
        return difference, 3
    return difference, 0


@loop
def receive_pairs(
    params: ReceiverParams, a_plus: float, a_minus: float, b_plus: float, b_minus: float
) -> tuple[float, float, int]:
    """Differences of channels A and B (sine and cosine) and their fault (`LineFault`) in this sample.

    Swapped: wires of the two pairs are exchanged, so that one sum is off by as much up as the other one is down.
    """
    first, wrong_a = receive_pair(params, a_plus, a_minus)
    second, wrong_b = receive_pair(params, b_plus, b_minus)
    off_a, off_b = a_plus + a_minus - 2.0 * params.middle, b_plus + b_minus - 2.0 * params.middle
    if wrong_a == 1 and wrong_b == 1 and abs(off_a + off_b) <= params.mismatch:
        return first, second, 2
    fault = wrong_a
    if wrong_b == 1 or fault == 0:
        fault = wrong_b
    if fault == 0 and params.analogue == 1:
        squared = first * first + second * second
        if not params.least * params.least <= squared <= params.most * params.most:
            fault = 3
    return first, second, fault


@loop
def index_misplaced(levels: int) -> bool:
    """Whether the index is high where A or B is: a pair with its wires exchanged, or an index that is stuck."""
    return levels & 4 != 0 and levels & 3 != 0
