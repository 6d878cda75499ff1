"""Ctrl-C and SIGTERM: a question that a loop asks between ticks (`Interrupts`), else the end of the process."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType
from typing import Any, Self

__all__ = ["INTERRUPTED", "Interrupted", "Interrupts", "quiet_process"]

INTERRUPTED = 130
"""Exit status."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)
PATIENCE = 0.12  # s of wall time for the robots to come to rest
LINE = "holonom: interrupted"


class Interrupted(KeyboardInterrupt):
    """Somebody wants it to end; its text, if any, says what is kept.

    A class of its own: Python ends by the signal, whatever its exit status, once a plain `KeyboardInterrupt` has gone
    through `exec`, as of a dataclass or a compiler.
    """

    def __str__(self) -> str:
        kept = super().__str__()
        return f"{LINE}; {kept}" if kept else LINE


class Interrupts:
    """While it is open, Ctrl-C and SIGTERM raise `Interrupted`, but for the first one in motion (`keep`).

    That one is kept for `requested`. Outside the main thread, where no signal arrives, it does nothing.
    """

    def __init__(self) -> None:
        self._requested: float | None = None
        self._before: dict[signal.Signals, Any] = {}
        self._keep = False

    def requested(self) -> bool:
        """Whether somebody wants it to end."""
        return self._requested is not None

    def overdue(self) -> bool:
        """Whether that was so long ago that the recording is to be closed, whatever still moves."""
        return self._requested is not None and time.perf_counter() - self._requested > PATIENCE

    def keep(self, wanted: bool = True) -> None:
        """From now on keep the first one, or raise at once again."""
        self._keep = wanted

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.signal(number, self._take) for number in SIGNALS}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _take(self, number: int, frame: FrameType | None) -> None:
        first, self._requested = self._requested is None, self._requested or time.perf_counter()
        if not (first and self._keep):
            raise Interrupted


@contextmanager
def quiet_process() -> Iterator[None]:
    """In it Ctrl-C and SIGTERM end the process at once, with one line and status 130; afterwards they do nothing more.

    No exception: one that is raised while modules are imported or compiled may be lost, or shown. What may not end so
    opens `Interrupts`. A signal that is ignored, as in a job in the background, stays so.
    """
    taken = [number for number in SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    for number in taken:
        signal.signal(number, _leave)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_IGN)


def _leave(number: int, frame: FrameType | None) -> None:
    """Say so, and be gone. What is half printed stays in its buffer where the signal came in the midst of printing."""
    with suppress(Exception):
        sys.stdout.flush()
    with suppress(OSError):
        os.write(2, f"{LINE}\n".encode())
    os._exit(INTERRUPTED)
