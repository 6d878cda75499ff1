"""The closed loop of one axis, compiled: the drive's step and the plant's in turn, at the rate of the current loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.encoders.quadrature.kernels import (
    HEALTHY,
    LineFaults,
    QuadratureParams,
    QuadratureState,
    quadrature_step,
)
from holonom.devices.power.brake import BrakeParams, BrakeState, brake_step
from holonom.machine.axis.drive_kernels import NONE, AxisDriveParams, AxisDriveState, AxisSignals, drive_step
from holonom.sim.axis.kernels import AxisPlantParams, AxisState, axis_step
from holonom.trace.code.loops import loop

__all__ = ["ROWS", "AxisFaults", "Plant", "run_axis"]

ROWS = 12
"""Rows of the log."""


class AxisFaults(NamedTuple):
    """What breaks at a step, and what is wrong from the start.

    At the step: the encoder's lines, its receivers (1), a share of its frames, a phase of the motor (1). From the start:
    the shunt's zero, A; the supply, V; the potentiometer, rad.
    """

    step: int
    lines: LineFaults
    receiver: int
    bad_frames: float
    phase_lost: int
    current_zero: float
    supply: float
    potentiometer: float


class Plant(NamedTuple):
    """Params of all that is not the drive."""

    axis: AxisPlantParams
    encoder: QuadratureParams
    brake: BrakeParams
    faults: AxisFaults


@loop(error_model="numpy")
def run_axis(
    plant: Plant,
    drive: AxisDriveParams,
    state: AxisState,
    shaft: QuadratureState,
    brake: BrakeState,
    own: AxisDriveState,
    reference: Array,
    loads: Array,
    stop_step: int,
    stop_category: int,
    log: Array,
    events: NDArray[np.int64],
) -> int:
    """Run along reference samples (3, n) of the position loop, and on for as long as the log (12, ticks) has room.

    Rows of the log: load angle, motor angle, load speed, motor speed, current, voltage, current reference, speed
    reference, mean of the squared current, estimated speed, phase, place on the path; at the motor shaft. `events`
    (e, 2) take each cause that is found, with its step. Return how many there are.
    """
    k = found = many = bad = 0
    count = shaft.count
    faults = plant.faults
    lines, frames = HEALTHY, 0.0
    for tick in range(log.shape[1]):
        heat = 0.0
        log[0, tick], log[1, tick] = state.load_angle, state.angle
        log[2, tick], log[3, tick] = state.load_speed, state.speed
        log[4, tick], log[5, tick] = state.current, own.servo.voltage if own.power == 1 else 0.0
        log[6, tick], log[7, tick], log[9, tick] = (
            own.servo.current_reference, own.servo.speed_reference, own.servo.rate,
        )  # fmt: skip
        log[10, tick], log[11, tick] = own.phase, own.place
        load = loads[min(tick, loads.shape[0] - 1)]
        for _ in range(drive.servo.position_samples):
            broken = k >= faults.step
            if k == faults.step:
                lines = faults.lines
            shaft = quadrature_step(plant.encoder, lines, shaft, state.angle)
            if k % drive.servo.speed_samples == 0:
                frames += faults.bad_frames if broken else 0.0
                bad = 1 if frames >= 1.0 else 0
                frames -= bad
                count = count if bad == 1 else shaft.count
            seen = AxisSignals(
                count, shaft.edges_a, shaft.edges_b, shaft.pulses, shaft.index_count,
                faults.receiver if broken else 0, bad, state.current + faults.current_zero, faults.supply,
                state.angle + faults.potentiometer,
            )  # fmt: skip
            own = drive_step(drive, own, k, seen, reference, stop_category if k == stop_step else NONE)
            brake = brake_step(plant.brake, brake, own.brake)
            conducts = own.power == 1 and not (broken and faults.phase_lost == 1)
            holds = plant.brake.torque if brake.closed == 1 else 0.0
            state = axis_step(plant.axis, state, own.servo.voltage, load, holds, conducts)
            heat += state.current * state.current
            if own.found != found:
                for code in range(1, 32):
                    if ((own.found ^ found) >> code) & 1 and many < events.shape[0]:
                        events[many, 0], events[many, 1] = k, code
                        many += 1
                found = own.found
            k += 1
        log[8, tick] = heat / drive.servo.position_samples
    return many
