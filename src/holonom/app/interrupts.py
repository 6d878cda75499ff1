"""`Interrupts`: Ctrl-C and SIGTERM, as a question that a loop asks between ticks."""

from __future__ import annotations

import signal
import threading
import time
from types import FrameType, TracebackType
from typing import Any, Self

__all__ = ["Interrupts"]

SIGNALS = (signal.SIGINT, signal.SIGTERM)
PATIENCE = 0.12  # s of wall time for the robots to come to rest


class Interrupts:
    """While it is open, the first Ctrl-C or SIGTERM is kept for `requested`; the second one raises `KeyboardInterrupt`.

    Outside the main thread, where no signal arrives, it does nothing.
    """

    def __init__(self) -> None:
        self._requested: float | None = None
        self._before: dict[signal.Signals, Any] = {}

    def requested(self) -> bool:
        """Whether somebody wants it to end."""
        return self._requested is not None

    def overdue(self) -> bool:
        """Whether that was so long ago that the recording is to be closed, whatever still moves."""
        return self._requested is not None and time.perf_counter() - self._requested > PATIENCE

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
        if self._requested is not None:
            raise KeyboardInterrupt
        self._requested = time.perf_counter()
