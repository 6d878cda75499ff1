"""Events of a base while it drives: slip and lost motors as the controller finds them, and as they are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.mobile import SlipStatus, WheelBase
from holonom.mobile.base.drivable import skids
from holonom.mobile.drive.failed_motor import motors_hold_all
from holonom.signals import Event

__all__ = ["BaseWords"]

PAUSE = 200  # ms of silence after which no wheel slips any more
GRIP = 50  # ms of grip after which a wheel has stopped slipping


class BaseWords:
    """Events from what a base's log says, buffer after buffer. Mutable state: which text came last.

    Parameters
    ----------
    wheels
        Names of the driven wheels.
    slips
        Slip speed, m/s, from which on a wheel truly slips: there friction is largest. Wheels that skid slip to turn,
        which is no event.
    base
        Whose motors are lost; None: what that means for it is not said.
    keep
        What it keeps then, one of `machine.base.settings.KEEP`.
    """

    def __init__(self, wheels: Sequence[str], slips: float, base: WheelBase | None = None, keep: str = "both") -> None:
        self._wheels, self._base, self._keep = tuple(wheels), base, keep
        self._limit = np.inf if base is not None and skids(base.wheels) else slips
        self._last_text, self._silent = "", 0
        self._slipping = np.zeros(len(wheels), np.int64)  # ms for which each goes on slipping
        self._most = np.zeros(len(wheels))  # m/s, largest slip since it began
        self._lost = 0

    def events(self, first: int, controlled: NDArray[np.void], slip: Array, goal: float) -> list[Event]:
        """Return what is new in a buffer, in order of time.

        Parameters
        ----------
        first
            Its first millisecond.
        controlled
            (N,) `CONTROL_SAMPLE`.
        slip
            (N, m) true slip, m/s.
        goal
            Part of its speed at which a path is driven from now on.
        """
        found = [*self._truth(first, slip), *self._slip(first, controlled), *self._motors(first, controlled, goal)]
        return sorted(found, key=lambda event: event.time)

    def _truth(self, first: int, slip: Array) -> Iterator[Event]:
        if self._limit == np.inf:
            return
        over = np.abs(slip) > self._limit
        if not (over.any() or self._slipping.any()):
            return
        for k in range(len(slip)):
            for wheel in np.flatnonzero(over[k] | (self._slipping > 0)):
                name, left = self._wheels[wheel], self._slipping[wheel]
                if over[k, wheel]:
                    self._slipping[wheel] = GRIP
                    self._most[wheel] = max(abs(slip[k, wheel]), self._most[wheel] if left else 0.0)
                    if left == 0:
                        yield Event(1e-3 * (first + k), "debug", "truth", f"{name} slips")
                else:
                    self._slipping[wheel] = left - 1
                    if left == 1:
                        text = f"{name} grips, it slipped at up to {self._most[wheel]:.3f} m/s"
                        yield Event(1e-3 * (first + k), "debug", "truth", text)

    def _slip(self, first: int, controlled: NDArray[np.void]) -> Iterator[Event]:
        slips = (controlled["status"] == SlipStatus.SLIP) | (controlled["status"] == SlipStatus.AMBIGUOUS)
        if not (slips.any() or self._last_text):
            return
        for k in range(len(controlled)):
            self._silent = 0 if slips[k] else self._silent + 1
            if slips[k]:
                text = _slip_text(self._members(int(controlled["flagged"][k])))
                if text != self._last_text:
                    yield Event(1e-3 * (first + k), "warning", "slip detection", text)
                self._last_text = text
            elif self._last_text and self._silent >= PAUSE:
                yield Event(1e-3 * (first + k), "info", "slip detection", "no wheel slips any more")
                self._last_text = ""

    def _motors(self, first: int, controlled: NDArray[np.void], goal: float) -> Iterator[Event]:
        lost = controlled["dead"].astype(np.int64)
        for k in np.flatnonzero(np.diff(lost, prepend=self._lost)):
            for name in self._members(int(lost[k] & ~self._lost)):
                jammed = name in self._members(int(controlled["jams"][k]))
                more = self._lame(self._lost | int(lost[k])) if not jammed else ""
                text = f"the motor of {name} does not do as told; {_go_on(jammed, goal)}{more}"
                yield Event(1e-3 * (first + k), "error", "motor watch", text)
            self._lost |= int(lost[k])

    def _lame(self, lost: int) -> str:
        """What the motors that are left cannot do any more."""
        if self._base is None or motors_hold_all(self._base, lost):
            return ""
        kept = {"path": "the path is kept", "heading": "the heading is kept", "both": "both are asked for"}[self._keep]
        return f"; the others cannot hold path and heading at once, {kept}"

    def _members(self, wheels: int) -> list[str]:
        return [name for i, name in enumerate(self._wheels) if (wheels >> i) & 1]


def _slip_text(named: list[str]) -> str:
    if not named:
        return "a wheel slips; which one is ambiguous"
    return f"{' and '.join(named)} {'slips' if len(named) == 1 else 'slip'}"


def _go_on(jammed: bool, goal: float) -> str:
    if jammed:
        return "it is jammed, the base stops"
    return "driving on without it" + (f", at {100.0 * goal:.0f} % of the speed" if 0.0 < goal < 0.999 else "")
