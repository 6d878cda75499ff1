"""How TYPE and $ENCODE write values: free format, or `/F8.2`, `/E12.4`, `/I4` and the layout codes."""

from __future__ import annotations

import re
from collections.abc import Sequence

from holonom.lang.program import Value

__all__ = ["FORMATS", "check_format", "render", "shown"]

FORMATS = {
    "/F": "`/Fw.d`: numbers that follow, w columns wide, d decimals; `/F0.d` as wide as needed",
    "/E": "`/Ew.d`: the same with a power of ten",
    "/I": "`/Iw`: rounded to a whole number, w columns wide",
    "/D": "`/D`: back to the free format: whole numbers in full, others to six digits and three decimals at least",
    "/X": "`/Xn`: n spaces (one where n is left out)",
    "/C": "`/Cn`: n line ends (one where n is left out)",
    "/S": "`/S`: the next TYPE goes on in this line",
}
"""Formats of TYPE and $ENCODE: how each is written, and what it does."""

_SHAPE = re.compile(r"(?:([FE])(\d{1,2})\.(\d{1,2})|I(\d{1,2})|([XC])(\d{0,2})|([DS]))", re.IGNORECASE | re.ASCII)


def check_format(code: str) -> bool:
    """Whether `code`, without its slash, is a format that exists."""
    return _SHAPE.fullmatch(code) is not None


def render(items: Sequence[Value], codes: Sequence[str | None]) -> str:
    """Return the text of TYPE: `codes` has one entry per item, None for the next value of `items`."""
    values = iter(items)
    parts: list[str] = []
    number = "g"
    for code in codes:
        if code is None:
            parts.append(_value(next(values), number))
        elif code in ("X", "C") or code[0] in "XC":
            parts.append((" " if code[0] == "X" else "\n") * int(code[1:] or 1))
        elif code != "S":
            number = "g" if code == "D" else code
    return "".join(parts)


def shown(number: float) -> str:
    """Return a number in the free format.

    Whole numbers have all their digits, as far as floats tell them apart (2^53). Others have six significant ones, and
    no fewer than three behind the point: in mm those are micrometres.
    """
    if number.is_integer():
        return f"{number + 0.0:.0f}" if abs(number) <= 2.0**53 else repr(number)
    before = len(f"{abs(number):.0f}") if abs(number) >= 1.0 else 0
    return f"{number:z.{max(6, before + 3)}g}"


def _value(value: Value, number: str) -> str:
    if isinstance(value, str):
        return value
    real = float(value)
    if number == "g":
        return shown(real)
    width, _, decimals = number[1:].partition(".")
    if number[0] == "I":
        return f"{round(real):{int(width)}d}"
    return f"{real:z{int(width)}.{int(decimals)}{number[0].lower()}}"
