"""The one way of putting text on a terminal: what would steer it is shown, not sent.

Names, echoed program lines, what programs type, file names and messages come from files of others. A terminal takes
some characters for commands: to colour, to move, to rename its window, to print a line backwards.
"""

from __future__ import annotations

import re
import sys
from typing import TextIO

from holonom.app.console.pipes import drop_unread

__all__ = ["one_line", "printable", "say", "say_to"]

STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")
"""Control characters but for tab and new line, marks of direction (Unicode annex 9), separators, halves of pairs."""


def printable(text: str) -> str:
    """Return a text, its lines as they are, with every character that steers a terminal as Python writes it: \\x1b."""
    return STEERS.sub(lambda found: ascii(found[0])[1:-1], text)


def one_line(text: str) -> str:
    """Return a name as it stands within a line: a new line in it is shown, too."""
    return printable(text).replace("\n", "\\n").replace("\t", "\\t")


def say(text: str, *, error: bool = False) -> None:
    """Print a text to standard output, or to standard error."""
    stream = sys.stderr if error else sys.stdout
    if stream is not None:
        _print(text, stream)


def say_to(stream: TextIO, text: str) -> None:
    """Print a line while somebody reads: what runs goes on without."""
    try:
        _print(text, stream)
        stream.flush()
    except BrokenPipeError:
        drop_unread()


def _print(text: str, stream: TextIO) -> None:
    """Print; a character that the terminal's encoding lacks is shown as Python writes it."""
    shown, encoding = printable(text), getattr(stream, "encoding", None) or "utf-8"
    print(shown.encode(encoding, "backslashreplace").decode(encoding), file=stream)
