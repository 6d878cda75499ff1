"""A law of a path as the compiled loop of a controller calls it: by address, so that the loop is compiled once."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple, Protocol

import numpy as np
from numba import carray, from_dtype, types  # type: ignore[attr-defined]
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.control.path_laws.contract import LawSettings
from holonom.trace.call.pointer import call_step
from holonom.trace.call.records import layout_of, record_table
from holonom.trace.code.loops import callback, loop

__all__ = ["MEMORY", "NUMBERS", "LawCall", "law_call", "law_step"]

NOW, PHASE, POSE, TWIST, BEFORE, COMMAND, MEMORY, NUMBERS = 0, 9, 10, 13, 16, 19, 22, 30
"""Where things are in the numbers (30,) that go in and out of a call."""


class LawCall(NamedTuple):
    """Address of a law's compiled step, and its params as bytes."""

    address: int
    params: NDArray[np.uint8]


class _Law(Protocol):
    @property
    def step(self) -> Any: ...
    @property
    def settings(self) -> LawSettings: ...


def law_call(law: _Law, dt: float) -> LawCall:
    """Return what `law_step` takes for a law at a sample time, s."""
    params = law.settings.params(dt)
    kind: Any = type(params)
    layout = layout_of(kind)
    return LawCall(_entry(law.step, kind).address, record_table([params], layout).view(np.uint8))


@functools.cache
def _entry(step: Any, params: Any) -> Any:
    """The step for C: params, path and its length, numbers."""
    layout = from_dtype(layout_of(params))

    @callback(
        types.void(types.CPointer(layout), types.CPointer(types.float64), types.int64, types.CPointer(types.float64)),
        error_model="numpy",
    )
    def entry(given, places, count, numbers):  # type: ignore[no-untyped-def]
        io = carray(numbers, 30)
        command = step(
            carray(given, 1)[0],
            carray(places, (count, 9)),
            io[9],
            io[:9],
            Planar(io[10], io[11], io[12]),
            Planar(io[13], io[14], io[15]),
            Planar(io[16], io[17], io[18]),
            io[22:],
        )
        io[19], io[20], io[21] = command.x, command.y, command.turn

    return entry


@loop(error_model="numpy")
def law_step(
    law: LawCall, path: Array, phase: float, now: Array, pose: Planar, twist: Planar, before: Planar, numbers: Array
) -> Planar:
    """Twist to command, of whichever law; arguments as `PathLaw` says, its memory are the last 8 of `numbers` (30,)."""
    numbers[:PHASE] = now
    numbers[PHASE] = phase
    numbers[POSE], numbers[POSE + 1], numbers[POSE + 2] = pose.x, pose.y, pose.turn
    numbers[TWIST], numbers[TWIST + 1], numbers[TWIST + 2] = twist.x, twist.y, twist.turn
    numbers[BEFORE], numbers[BEFORE + 1], numbers[BEFORE + 2] = before.x, before.y, before.turn
    call_step(law.address, law.params, path, numbers)
    return Planar(numbers[COMMAND], numbers[COMMAND + 1], numbers[COMMAND + 2])
