"""The closed loop of an arm, compiled: the servos' step and the plant's in turn, every 0.1 ms; nothing else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.drive_signals import JointSignals
from holonom.machine.arm.kernels import STOP, servo_step
from holonom.machine.arm.records import ServoTiming
from holonom.sim.arm.kernels import arm_step, compare, sense
from holonom.trace.call.borrow import borrowed
from holonom.trace.code.loops import loop

__all__ = ["run_reference"]

Records = NDArray[np.void]


@loop(error_model="numpy")
def run_reference(
    mode: int,
    timing: ServoTiming,
    clock: NDArray[np.int64],
    signals: JointSignals,
    model: int,
    servos: Records,
    servo_states: Records,
    law: Array,
    plant: int,
    dt: float,
    drives: Records,
    drive_states: Records,
    work: Array,
    reference: Array,
) -> tuple[int, int, int, float]:
    """Drive all axes along reference samples (3, ticks, n), one for each step of the position loops.

    `clock` (1,) counts the steps of the current loops since the start, and is advanced.

    Returns
    -------
    Violation code (0: none), the axis and tick at which it was found, largest contact force (N).
    """
    signals = borrowed(signals)
    n = drive_states.shape[0]
    source, target = work[: 3 * n + 7], work[3 * n + 7 :]
    touch = 0.0
    for tick in range(reference.shape[1]):
        now = reference[:, tick]
        if mode != STOP:
            compare(drive_states, now[0])
        for _ in range(timing.position):
            step = clock[0]
            code, axis = servo_step(mode, timing, step, model, servos, servo_states, now, signals, law)
            if code != 0:
                return code, axis, tick, touch
            touch = max(touch, arm_step(plant, dt, drives, drive_states, signals, source, target))
            clock[0] = step + 1
            if (step + 1) % timing.speed == 0:
                sense(drives, drive_states, signals)
    return 0, 0, 0, touch
