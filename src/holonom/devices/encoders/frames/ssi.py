"""SSI: Gray code, highest bit first; a parity bit after it, if it is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices.encoders.frames.gray import gray_decode, gray_encode
from holonom.devices.encoders.frames.record import DecodedFrame, bits_of, frame_of
from holonom.registry import check_fields, parameter

__all__ = ["PARITIES", "SsiFrame"]

PARITIES = {"none": None, "even": 0, "odd": 1}
"""What the ones of a frame, its parity bit included, add up to modulo 2."""


@dataclass(frozen=True, slots=True)
class SsiFrame:
    """A frame of SSI.

    Raises
    ------
    InputError
        Bits that are no whole number from 1 to 64; another parity.
    """

    bits: int = parameter(meaning="bits of the position, turns included", least=1, most=64, example=13)
    parity: str = parameter("none", meaning="bit after the position", choices=PARITIES)

    def __post_init__(self) -> None:
        check_fields(self)

    def encode(self, position: int) -> str:
        """Return the frame of a position."""
        code = bits_of(gray_encode(position, bits=self.bits), self.bits)
        wanted = PARITIES[self.parity]
        return code if wanted is None else code + str((code.count("1") + wanted) % 2)

    def decode(self, frame: str) -> DecodedFrame:
        """Return what a frame says."""
        wanted = PARITIES[self.parity]
        made_of = f"{self.bits} of Gray code" + ("" if wanted is None else ", parity")
        frame_of("ssi", frame, self.bits + (wanted is not None), made_of)
        gray, ones = int(frame[: self.bits], 2), frame[: self.bits].count("1")
        fault = ""
        if wanted is not None and frame.count("1") % 2 != wanted:
            fault = f"parity bit is {frame[-1]}; {ones} ones and {self.parity} parity make {(ones + wanted) % 2}"
        return DecodedFrame(gray_decode(gray, bits=self.bits), not fault, fault, gray=gray, even_parity=ones % 2)
