"""Up/down counters of 12, 16, 24, 32 bits, and their extension to a count that does not wrap (spec 03.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["COUNTER_BITS", "Counter", "unwrap_count", "wrap_count"]

COUNTER_BITS = (12, 16, 24, 32)


@dataclass(frozen=True, slots=True)
class Counter:
    """The up/down counter behind a decoder.

    Raises
    ------
    ModelError
        A number of bits that is not 12, 16, 24 or 32.
    """

    bits: int = parameter(16, meaning="12, 16, 24 or 32", least=12, most=32)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.bits not in COUNTER_BITS:
            raise ModelError(f"Counter: bits is {self.bits}; it must be one of {', '.join(map(str, COUNTER_BITS))}")

    def longest_read_interval(self, counts_per_rev: float, max_speed: float) -> float:
        """Time (s) within which it has to be read at a motor speed (rad/s): `2^(bits-1) / f_max`.

        Half of the counter, not all of it: the difference of two reads carries a sign.
        """
        require("Counter.longest_read_interval", "counts_per_rev", counts_per_rev, least=1.0)
        require("Counter.longest_read_interval", "max_speed", max_speed, above=0.0)
        return 2.0 ** (self.bits - 1) / (counts_per_rev * max_speed / (2.0 * math.pi))


@loop(forceinline=True)
def wrap_count(bits: int, count: int) -> int:
    """Content (0 ... 2^bits - 1) of a counter that has counted so far."""
    return count & ((1 << bits) - 1)


@loop(forceinline=True)
def unwrap_count(bits: int, total: int, counter: int) -> int:
    """64-bit count after a read: the last one plus the signed difference of the two reads.

    The low bits of `total` are the last read, so `total` is the whole state. Right for any motion of less than
    `2^(bits-1)` counts between two reads.
    """
    half = 1 << (bits - 1)
    return total + ((counter - total + half) & ((1 << bits) - 1)) - half
