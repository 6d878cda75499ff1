"""`DigitalSignals`: the digital inputs and outputs of a cell, which its robots share."""

from __future__ import annotations

from holonom.signals import Signal, Sink

__all__ = ["DigitalSignals"]


class DigitalSignals:
    """Signals by number; each is off until it is switched on. Mutable state: which are on."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._on: set[int] = set()

    def set(self, number: int, on: bool, time: float) -> None:
        """Switch a signal at a time, s; a change is recorded."""
        if self.get(number) != on:
            (self._on.add if on else self._on.discard)(number)
            self._sink.put(Signal(time, number, on))

    def get(self, number: int) -> bool:
        """Whether a signal is on."""
        return number in self._on
