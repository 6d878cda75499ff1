"""Width and height that an image file states, read before its pixels are: a small file may unpack to very many."""

from __future__ import annotations

import struct
from collections.abc import Callable

__all__ = ["stated_size"]


def stated_size(data: bytes) -> tuple[int, int] | None:
    """Width and height (px) by the head of a PNG, JPEG, BMP or TIFF file; None of anything else.

    Sources: PNG (ISO/IEC 15948) 11.2.2; JPEG (ITU T.81) B.2.2; TIFF 6.0, section 2; BITMAPINFOHEADER.
    """
    read = next((read for magic, read in _FORMATS if data.startswith(magic)), None)
    try:
        return None if read is None else read(data)
    except (struct.error, IndexError):
        return None


def _png(data: bytes) -> tuple[int, int] | None:
    kind, width, height = struct.unpack_from(">4sII", data, 12)
    return (width, height) if kind == b"IHDR" else None


def _bmp(data: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from("<ii", data, 18)
    return abs(width), abs(height)


def _jpeg(data: bytes) -> tuple[int, int] | None:
    """Of the frame header, the segment SOFn; segments before it say how long they are."""
    at = 2
    while at < len(data):
        while data[at] == 0xFF and data[at + 1] == 0xFF:
            at += 1
        mark, code = data[at], data[at + 1]
        if mark != 0xFF:
            return None
        if 0xC0 <= code <= 0xCF and code not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack_from(">HH", data, at + 5)
            return width, height
        alone = code == 0x01 or 0xD0 <= code <= 0xD8
        at += 2 if alone else 2 + max(2, struct.unpack_from(">H", data, at + 2)[0])
    return None


def _tiff(data: bytes) -> tuple[int, int] | None:
    """Of the first directory: the tags 256 and 257, short or long."""
    order = "<" if data[:2] == b"II" else ">"
    (at,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, at)
    found: dict[int, int] = {}
    for k in range(count):
        tag, kind = struct.unpack_from(order + "HH", data, at + 2 + 12 * k)
        if tag in (256, 257):
            (found[tag],) = struct.unpack_from(order + ("H" if kind == 3 else "I"), data, at + 2 + 12 * k + 8)
    return (found[256], found[257]) if len(found) == 2 else None


_FORMATS: tuple[tuple[bytes, Callable[[bytes], tuple[int, int] | None]], ...] = (
    (b"\x89PNG\r\n\x1a\n", _png),
    (b"\xff\xd8\xff", _jpeg),
    (b"BM", _bmp),
    (b"II*\0", _tiff),
    (b"MM\0*", _tiff),
)
"""What a file of each format begins with."""
