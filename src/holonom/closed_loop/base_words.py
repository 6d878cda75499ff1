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

__all__ = ["BaseWords", "why_stopped"]

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
        self._lost = self._lodged = 0

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
        found = [
            *self._truth(first, slip), *self._slip(first, controlled), *self._motors(first, controlled, goal),
            *self._steering(first, controlled),
        ]  # fmt: skip
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
                jammed, blind, loose = (
                    name in self._members(int(controlled[what][k])) for what in ("jams", "blind", "loose")
                )
                crippled = bool(controlled["crippled"][k])
                more = self._lame(self._lost | int(lost[k])) if not (jammed or crippled) else ""
                what = f"the motor of {name} does not do as told"
                if blind:
                    what = f"the encoder of {name} is stuck"
                elif loose:
                    what = f"{name} pushes nothing, it is off or spins"
                left = self._left(self._lost | int(lost[k])) if crippled else ""
                text = f"{what}; {_go_on(jammed, left, goal)}{more}"
                yield Event(1e-3 * (first + k), "error", "motor watch", text)
            self._lost |= int(lost[k])

    def _steering(self, first: int, controlled: NDArray[np.void]) -> Iterator[Event]:
        if self._base is None or not self._base.steered:
            return
        lodged = controlled["lodged"].astype(np.int64)
        for k in np.flatnonzero(np.diff(lodged, prepend=self._lodged)):
            new = int(lodged[k] & ~self._lodged)
            for i, wheel in enumerate(self._base.wheels):
                if (new >> i) & 1:
                    pinned = bool(controlled["pinned"][k])
                    does = "the path is kept, the base turns about it" if pinned else "the base stops"
                    text = f"the steering of {wheel.name} is stuck; {does}"
                    yield Event(1e-3 * (first + k), "error", "motor watch", text)
            self._lodged |= int(lodged[k])

    def _lame(self, lost: int) -> str:
        """What the motors that are left cannot do any more."""
        if self._base is None or self._base.steered or motors_hold_all(self._base, lost):
            return ""
        kept = {"path": "the path is kept", "heading": "the heading is kept", "both": "both are asked for"}[self._keep]
        return f"; the others cannot hold path and heading at once, {kept}"

    def _left(self, lost: int) -> str:
        """What the motors that are left still drive."""
        base = self._base
        if base is None:
            return "the others do not drive it"
        scale = np.array([1.0, 1.0, 1.0 / base.radius])
        rows = base.rest_coupling / scale @ base.steerable * scale
        works = [i for i in range(len(rows)) if not (lost >> i) & 1]
        left, all_ = (int(np.linalg.matrix_rank(rows[at], tol=1e-6)) for at in (works, list(range(len(rows)))))
        return f"the others drive {left or 'none'} of the {all_} ways to move"

    def _members(self, wheels: int) -> list[str]:
        return [name for i, name in enumerate(self._wheels) if (wheels >> i) & 1]


def _slip_text(named: list[str]) -> str:
    if not named:
        return "a wheel slips; which one is ambiguous"
    return f"{' and '.join(named)} {'slips' if len(named) == 1 else 'slip'}"


def why_stopped(state: np.void) -> str:
    """With what a controller's record says that a base stopped on its way."""
    if state["jams"]:
        return "with a jammed wheel"
    return "with stuck steering" if state["lodged"] else "by motors that are left and do not drive it"


def _go_on(jammed: bool, left: str, goal: float) -> str:
    if jammed:
        return "it is jammed, the base stops"
    if left:
        return f"{left}, the base stops"
    return "driving on without it" + (f", at {100.0 * goal:.0f} % of the speed" if 0.0 < goal < 0.999 else "")
