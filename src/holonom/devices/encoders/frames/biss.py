"""BiSS-C: start bit 1, 0, position highest bit first, error and warning (1: none), CRC-6 (`x^6 + x + 1`), inverted."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices.encoders.frames.crc import crc
from holonom.devices.encoders.frames.gray import whole_bits
from holonom.devices.encoders.frames.record import DecodedFrame, bits_of, flag, frame_of
from holonom.registry import check_fields, parameter

__all__ = ["BissFrame"]


@dataclass(frozen=True, slots=True)
class BissFrame:
    """A frame of BiSS-C from its start bit on.

    Raises
    ------
    InputError
        Bits that are no whole number from 1 to 64.
    """

    bits: int = parameter(meaning="bits of the position, turns included", least=1, most=64, example=18)

    def __post_init__(self) -> None:
        check_fields(self)

    def encode(self, position: int, *, n_error: int = 1, n_warning: int = 1) -> str:
        """Return the frame of a position; `n_error` 0: an error, `n_warning` 0: a warning."""
        position = whole_bits("position", position, self.bits)
        body = bits_of(position, self.bits) + flag("n_error", n_error) + flag("n_warning", n_warning)
        return "10" + body + bits_of(_check(body), 6)

    def decode(self, frame: str) -> DecodedFrame:
        """Return what a frame says."""
        made_of = f"start, 0, {self.bits} of position, error, warning, 6 of CRC"
        frame_of("biss", frame, self.bits + 10, made_of)
        body, came = frame[2:-6], int(frame[-6:], 2)
        due = _check(body)
        fault = f"CRC is {came}; the bits that came make {due}" if came != due else ""
        if frame[:2] != "10":
            fault = f"a frame begins with {frame[:2]}; it must begin with 10"
        flags = {"n_error": int(body[-2]), "n_warning": int(body[-1])}
        return DecodedFrame(int(body[:-2], 2), not fault, fault, came, due, **flags)


def _check(body: str) -> int:
    return crc(body, polynomial=0b000011, width=6) ^ 63
