"""EnDat-like: start bit 1, alarm, position lowest bit first, CRC-5 (`x^5 + x^3 + x + 1`) highest bit first."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices.encoders.frames.crc import crc
from holonom.devices.encoders.frames.gray import whole_bits
from holonom.devices.encoders.frames.record import DecodedFrame, bits_of, flag, frame_of
from holonom.registry import check_fields, parameter

__all__ = ["EndatFrame"]


@dataclass(frozen=True, slots=True)
class EndatFrame:
    """A frame like EnDat's position.

    Its CRC finds every single, triple and burst error up to 5 bits, but no pair 15 or 30 bits apart: the order of x
    modulo the polynomial is 15.

    Raises
    ------
    InputError
        Bits that are no whole number from 1 to 64.
    """

    bits: int = parameter(meaning="bits of the position, turns included", least=1, most=64, example=25)

    def __post_init__(self) -> None:
        check_fields(self)

    def encode(self, position: int, *, alarm: int = 0) -> str:
        """Return the frame of a position; `alarm` 1: the encoder is in trouble."""
        body = flag("alarm", alarm) + bits_of(whole_bits("position", position, self.bits), self.bits)[::-1]
        return "1" + body + bits_of(_check(body), 5)

    def decode(self, frame: str) -> DecodedFrame:
        """Return what a frame says."""
        frame_of("endat", frame, self.bits + 7, f"start, alarm, {self.bits} of position, 5 of CRC")
        body, came = frame[1:-5], int(frame[-5:], 2)
        due = _check(body)
        fault = f"CRC is {came}; the bits that came make {due}" if came != due else ""
        if frame[0] != "1":
            fault = "start bit is 0; it must be 1"
        return DecodedFrame(int(body[:0:-1], 2), not fault, fault, came, due, alarm=int(body[0]))


def _check(body: str) -> int:
    return crc(body, polynomial=0b01011, width=5, start=31) ^ 31
