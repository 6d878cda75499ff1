"""The closed loop of a base, compiled: the controller's step and the plant's in turn, each millisecond; nothing else.

With a buffer `run` fills it with what is true and what the controller says and returns, so that a run of any length
needs the memory of one buffer; with an empty one it only drives on, between two looks of a program or a joystick. Both
are the same steps, compiled once: they give the same bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.drive_signals import WheelSignals
from holonom.machine.base.kernels import RUNNING, control_step, path_ending, say
from holonom.machine.base.params import BaseParams, BaseTask, Work
from holonom.sim.base.log_kernels import log_body, log_wheels
from holonom.sim.base.step_kernels import BasePlantParams, advance
from holonom.trace.call.borrow import borrowed
from holonom.trace.code.loops import loop

__all__ = ["LogBuffer", "joined", "run"]

Records = NDArray[np.void]


class LogBuffer(NamedTuple):
    """N milliseconds of a base with n fours of wheels."""

    body: Records  # (N,) BODY_SAMPLE
    wheels: Records  # (N, n) WHEEL_SAMPLE
    controlled: Records  # (N,) CONTROL_SAMPLE
    seen: Array  # (N, 4, 4 n) SEEN_WHEEL_SAMPLE

    def part(self, first: int, last: int) -> LogBuffer:
        """Return its milliseconds from one up to another, on the same memory."""
        part = slice(first, last)
        return LogBuffer(self.body[part], self.wheels[part], self.controlled[part], self.seen[part])


def joined(logs: Sequence[LogBuffer]) -> LogBuffer:
    """Return logs one after the other."""
    return LogBuffer(
        np.concatenate([log.body for log in logs]),
        np.concatenate([log.wheels for log in logs]),
        np.concatenate([log.controlled for log in logs]),
        np.concatenate([log.seen for log in logs]),
    )


@loop(error_model="numpy")
def run(
    params: BaseParams,
    task: BaseTask,
    signals: WheelSignals,
    control: Records,
    known: Records,
    seen: Records,
    work: Work,
    plant: BasePlantParams,
    body: Records,
    wheels: Records,
    noise: Array,
    log: LogBuffer,
) -> int:
    """Drive on for as many milliseconds as `noise` has rows; return how many it took.

    With a log of as many rows it ends where the path does, which `control` then says, or where the base tips over;
    without (an empty one) a base at the end of its path holds.
    """
    params, task, signals, work, plant = borrowed((params, task, signals, work, plant))
    logged = len(log.body) > 0
    for k in range(len(noise)):
        if logged:
            control[0].ended = path_ending(control[0], task.path)
            if control[0].ended != RUNNING or body[0].tipped != 0:
                return k
        control_step(params, task, signals, control, known, seen, work)
        if logged:
            log_body(plant.body[0], body[0], log.body[k])
            log_wheels(wheels, log.wheels[k])
            say(control[0], known, seen, log.controlled[k], log.seen[k])
        advance(plant, body, wheels, signals, noise[k])
    control[0].ended = path_ending(control[0], task.path)
    return len(noise)
