"""What a frame says, and the checks that all kinds share."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.errors import OutOfLimits, ShapeError

__all__ = ["DecodedFrame", "bits_of", "flag", "frame_of"]


@dataclass(frozen=True, slots=True)
class DecodedFrame:
    """What arrived.

    Attributes
    ----------
    position
        As sent, turns in the upper bits.
    ok
        Whether start bits and CRC or parity are right. If not, the position is not to be used.
    fault
        What is wrong in words, with what came and what was due; empty if it is ok.
    crc, due
        CRC that came, and that of the bits that came; None where the kind has none.
    alarm, n_error, n_warning
        Flags, None where the kind has none. `n_error` and `n_warning` are 1 when there is nothing.
    gray, even_parity
        SSI: the code that came and its even parity, None elsewhere.
    """

    position: int
    ok: bool = True
    fault: str = ""
    crc: int | None = None
    due: int | None = None
    alarm: int | None = None
    n_error: int | None = None
    n_warning: int | None = None
    gray: int | None = None
    even_parity: int | None = None


def bits_of(value: int, bits: int) -> str:
    """Return a value as bits, highest first."""
    return f"{value:0{bits}b}"


def flag(name: str, value: int) -> str:
    """Return a flag as a bit.

    Raises
    ------
    OutOfLimits
        Neither 0 nor 1.
    """
    if value not in (0, 1):
        raise OutOfLimits(f"{name} is {value!r}; it must be 0 or 1")
    return str(int(value))


def frame_of(kind: str, frame: str, length: int, made_of: str) -> str:
    """Return a frame that has the length and letters of its kind.

    Raises
    ------
    ShapeError
        Something else: says what came and what the frame is made of.
    """
    if not isinstance(frame, str) or not set(frame) <= {"0", "1"}:
        raise ShapeError(f"frame is {frame!r}; it must be a string of 0 and 1")
    if len(frame) != length:
        raise ShapeError(f"frame has {len(frame)} bits; one of {kind} has {length}: {made_of}")
    return frame
