"""The table of kinds of frames, and the two verbs."""

from __future__ import annotations

from typing import Any

from holonom.devices.encoders.frames.biss import BissFrame
from holonom.devices.encoders.frames.endat import EndatFrame
from holonom.devices.encoders.frames.record import DecodedFrame
from holonom.devices.encoders.frames.ssi import SsiFrame
from holonom.errors import OutOfLimits
from holonom.registry import Method, Table

__all__ = ["FRAMES", "decode_frame", "encode_frame"]


def _itself(frame: Any) -> Any:
    """Return the record: it encodes and decodes."""
    return frame


FRAMES = Table(
    "frames",
    "kind of frame",
    "its record, which encodes a position and decodes a frame",
    {
        "ssi": Method("Gray code, highest bit first, parity if asked for", _itself, "Stegmann, SSI, 1984", SsiFrame),
        "endat": Method(
            "start, alarm, position lowest bit first, CRC-5",
            _itself,
            "EnDat 2.2, its polynomial as published",
            EndatFrame,
        ),
        "biss": Method(
            "start, position highest bit first, error, warning, CRC-6", _itself, "iC-Haus, BiSS-C protocol", BissFrame
        ),
    },
)

_FLAGS = {"alarm": "endat", "n_error": "biss", "n_warning": "biss"}


def encode_frame(
    kind: str,
    position: int,
    *,
    bits: int,
    parity: str | None = None,
    alarm: int | None = None,
    n_error: int | None = None,
    n_warning: int | None = None,
) -> str:
    """Frame in which an absolute encoder sends a position.

    Parameters
    ----------
    kind : a name of `FRAMES`: "ssi", "endat", "biss".
    position : 0 to 2^bits - 1, turns in the upper bits (`join_turns`).
    bits : of the position, 1 to 64.
    parity : of "ssi": "none" (unless said), "even", "odd".
    alarm : of "endat": 1 where the encoder is in trouble.
    n_error, n_warning : of "biss": 0 where there is an error, a warning.

    Returns
    -------
    The bits in the order of sending, as 0 and 1.

    Raises
    ------
    UnknownName
        No such kind, no such parity.
    OutOfLimits
        A position that the bits do not hold, a flag that is neither 0 nor 1, an option of another kind.
    """
    flags = {"alarm": alarm, "n_error": n_error, "n_warning": n_warning}
    given = {name: value for name, value in flags.items() if value is not None}
    for name in given:
        if _FLAGS[name] != kind and kind in FRAMES:
            raise OutOfLimits(f"{name} is no option of {kind}; it is one of {_FLAGS[name]}: leave it out")
    encoded: str = _frame(kind, bits, parity).encode(position, **given)
    return encoded


def decode_frame(kind: str, frame: str, *, bits: int, parity: str | None = None) -> DecodedFrame:
    """What a frame says; arguments as of `encode_frame`.

    A frame that arrived damaged is an answer, not an error: `ok` is False, `fault` says what came and what was due.

    Raises
    ------
    UnknownName, OutOfLimits
        As `encode_frame`.
    ShapeError
        Letters other than 0 and 1, another length.
    """
    decoded: DecodedFrame = _frame(kind, bits, parity).decode(frame)
    return decoded


def _frame(kind: str, bits: int, parity: str | None) -> Any:
    if parity is not None and kind != "ssi" and kind in FRAMES:
        raise OutOfLimits(f"parity is no option of {kind}; it is one of ssi: leave it out")
    return FRAMES.make(kind, {"bits": bits} if parity is None else {"bits": bits, "parity": parity})
