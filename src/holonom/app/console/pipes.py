"""Output that nobody reads any more, as behind `| head`."""

from __future__ import annotations

import os
import select
import sys
from contextlib import suppress
from typing import TextIO

__all__ = ["BROKEN", "drop_unread"]

BROKEN = 141
"""Exit status: that of a program which SIGPIPE ends, 128 + 13."""


def drop_unread() -> bool:
    """Send to nowhere what standard streams hold that nobody reads; return whether there were such."""
    dropped = [_dropped(stream) for stream in (sys.stdout, sys.stderr) if stream is not None]
    return any(dropped)


def _dropped(stream: TextIO) -> bool:
    if not _unread(stream):
        return False
    with suppress(OSError, ValueError):  # a stream without a file
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    return True


def _unread(stream: TextIO) -> bool:
    """Whether nobody reads: what is left to write says so, or, where a failed print has left nothing, the file."""
    try:
        stream.flush()
        poll = select.poll()
        poll.register(stream.fileno(), 0)
    except BrokenPipeError:
        return True
    except (OSError, ValueError):
        return False
    return any(seen & select.POLLERR for _, seen in poll.poll(0))
