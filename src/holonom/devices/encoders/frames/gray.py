"""Gray code of any number of bits; positions of several turns (spec 03.3)."""

from __future__ import annotations

from holonom.errors import OutOfLimits

__all__ = ["gray_decode", "gray_encode", "join_turns", "split_turns", "whole_bits"]

MOST_BITS = 1024


def whole_bits(name: str, value: int, bits: int) -> int:
    """Return a value that a number of bits holds.

    Raises
    ------
    OutOfLimits
        Bits below 1 or beyond 1024; a value that is no whole number, negative, or too large.
    """
    if isinstance(bits, bool) or not hasattr(bits, "__index__") or not 1 <= int(bits) <= MOST_BITS:
        raise OutOfLimits(f"bits is {bits!r}; it must be a whole number from 1 to {MOST_BITS}")
    if isinstance(value, bool) or not hasattr(value, "__index__") or not 0 <= int(value) < 1 << int(bits):
        most = f"2^{bits} - 1" if bits > 64 else str((1 << int(bits)) - 1)
        raise OutOfLimits(f"{name} is {value!r}; it must be a whole number from 0 to {most}, as {bits} bits hold")
    return int(value)


def gray_encode(value: int, *, bits: int) -> int:
    """Gray code of a value: `g = b xor (b >> 1)`; neighbours differ in one bit, the last one and the first one, too.

    Raises
    ------
    OutOfLimits
        A value that the bits do not hold.
    """
    value = whole_bits("value", value, bits)
    return value ^ (value >> 1)


def gray_decode(code: int, *, bits: int) -> int:
    """Value of a Gray code: `b = g xor (g >> 1) xor (g >> 2) ...`, by doubling shifts; raises as `gray_encode`."""
    value, shift = whole_bits("code", code, bits), 1
    while shift < bits:
        value ^= value >> shift
        shift *= 2
    return value


def join_turns(turn: int, step: int, *, bits: int, turn_bits: int) -> int:
    """Position of a multi-turn encoder: the turn in the upper `turn_bits`, the step within it in the lower `bits`.

    Raises
    ------
    OutOfLimits
        A turn or a step that its bits do not hold.
    """
    return whole_bits("turn", turn, turn_bits) << bits | whole_bits("step", step, bits)


def split_turns(position: int, *, bits: int, turn_bits: int, signed: bool = False) -> tuple[int, int]:
    """Turn and step of a position; `signed`: turns from `-2^(turn_bits - 1)` on. Raises as `join_turns`."""
    position = whole_bits("position", position, bits + turn_bits)
    turn, step = position >> bits, position & ((1 << bits) - 1)
    return (turn - (1 << turn_bits) if signed and turn >> (turn_bits - 1) else turn), step
