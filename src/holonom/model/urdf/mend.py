"""XML that other readers take though it is not well-formed, mended so that lines stay as they are."""

from __future__ import annotations

import re
from typing import NamedTuple

__all__ = ["Mended", "mended"]

COMMENT = re.compile(rb"<!--(.*?)-->", re.DOTALL)
LONE = re.compile(rb"&(?!#?\w+;)")
END = re.compile(rb"</robot\s*>")


class Mended(NamedTuple):
    """A document, how many lines are missing before it, and what was mended, with its line."""

    content: bytes
    before: int
    faults: tuple[tuple[int, str], ...]


def mended(content: bytes) -> Mended:
    """Return the document without what expat refuses and others pass over; for encodings that agree with ASCII.

    That is: blank space before the XML declaration, `--` within a comment, an `&` that begins no entity, anything
    after the first </robot>.
    """
    start = content.removeprefix(b"\xef\xbb\xbf")
    body = start.lstrip()
    before = start[: len(start) - len(body)].count(b"\n")
    faults = [(1, "blank space before it")] if len(body) < len(start) else []
    for match in COMMENT.finditer(body):
        if b"--" in match[1] or match[1].endswith(b"-"):
            faults.append((_line(body, match.start()) + before, 'a comment with "--" in it'))
    body = COMMENT.sub(lambda match: b"<!--" + match[1].replace(b"-", b" ") + b"-->", body)
    faults += [(_line(body, match.start()) + before, '"&" where "&amp;" is meant') for match in LONE.finditer(body)]
    body = LONE.sub(b"&amp;", body)
    end = END.search(body)
    if end is not None and body[end.end() :].strip():
        faults.append((_line(body, end.end()) + before, "something after </robot>"))
        body = body[: end.end()]
    return Mended(body, before, tuple(faults))


def _line(content: bytes, at: int) -> int:
    return content.count(b"\n", 0, at) + 1
