"""Cyclic redundancy check of a string of bits, by the shift register of the hardware."""

from __future__ import annotations

from holonom.devices.encoders.frames.gray import whole_bits

__all__ = ["crc"]


def crc(message: str, *, polynomial: int, width: int, start: int = 0) -> int:
    """Remainder of a message, first bit first.

    Parameters
    ----------
    message : 0 and 1.
    polynomial : without its leading term: `x^5 + x^3 + x + 1` is 0b01011 with width 5.
    width : bits of the remainder.
    start : what the register holds before.

    Raises
    ------
    OutOfLimits
        A polynomial or start that the width does not hold.
    """
    polynomial, register = whole_bits("polynomial", polynomial, width), whole_bits("start", start, width)
    mask = (1 << width) - 1
    for bit in message:
        out = register >> (width - 1) ^ (bit == "1")
        register = (register << 1 & mask) ^ (polynomial if out else 0)
    return register
