"""The closed loop of one axis, compiled: the drive's step and the plant's in turn, at the rate of the current loop."""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.encoders.quadrature.kernels import (
    HEALTHY,
    LineFaults,
    QuadratureParams,
    QuadratureState,
    healthy_step,
    quadrature_step,
)
from holonom.devices.power.brake import BrakeParams, BrakeState, brake_step
from holonom.machine.axis.drive_kernels import drive_between, drive_place, drive_step_of
from holonom.machine.axis.drive_records import NONE, RUNNING, AxisDriveParams, AxisDriveState, AxisSignals
from holonom.sim.axis.kernels import AxisPlantParams, AxisState, axis_step
from holonom.trace.code.loops import loop

__all__ = ["ROWS", "AxisFaults", "Plant", "axis_runner"]

JAMMED = 1e9  # N m, of a shaft that nothing turns
ROWS = 13
"""Rows of the log, at the motor shaft.

Load angle, motor angle, load speed, motor speed, current, voltage, current reference, speed reference, mean of the
squared current, estimated speed, phase, place on the path, estimated angle.
"""


class AxisFaults(NamedTuple):
    """What breaks at a step, and what is wrong from the start.

    At the step: the encoder's lines, its receivers (1), a share of its frames, a phase of the motor (1),
    the shaft (1). From the start: the shunt's zero, A; the supply, V; the potentiometer, rad.
    """

    step: int
    lines: LineFaults
    receiver: int
    bad_frames: float
    phase_lost: int
    blocked: int
    current_zero: float
    supply: float
    potentiometer: float


class Plant(NamedTuple):
    """Params of all that is not the drive."""

    axis: AxisPlantParams
    encoder: QuadratureParams
    load_counts_per_rad: float  # of the load's encoder, at the motor
    brake: BrakeParams
    faults: AxisFaults


@loop(error_model="numpy", forceinline=True)
def _note(row: Array, state: AxisState, own: AxisDriveState) -> None:
    """A column of the log; the mean of the squared current follows at its end."""
    row[0], row[1], row[2], row[3] = state.load_angle, state.angle, state.load_speed, state.speed
    row[4], row[5] = state.current, own.servo.voltage if own.power == 1 else 0.0
    row[6], row[7], row[9] = own.servo.current_reference, own.servo.speed_reference, own.servo.rate
    row[10], row[11], row[12] = own.phase, own.place, own.servo.angle


@loop(error_model="numpy", forceinline=True)
def _tell(events: NDArray[np.int64], many: int, step: int, found: int) -> int:
    """Write causes, a bit each, with their step; return how many there are now."""
    for code in range(1, 32):
        if (found >> code) & 1 and many < events.shape[0]:
            events[many, 0], events[many, 1] = step, code
            many += 1
    return many


@loop(error_model="numpy", forceinline=True)
def _between_looks(
    plant: Plant, drive: AxisDriveParams, state: AxisState, shaft: QuadratureState, own: AxisDriveState, load: float,
    heat: float, steps: int,
) -> tuple[tuple[AxisState, QuadratureState], AxisDriveState, float]:  # fmt: skip
    """Steps of a healthy axis that runs, until its drive looks again; and the sum of its squared currents."""
    for _ in range(steps):
        shaft = healthy_step(plant.encoder, shaft, state.angle)
        own = drive_between(drive, own, state.current + plant.faults.current_zero)
        state = axis_step(plant.axis, state, own.servo.voltage, load, 0.0, True)
        heat += state.current * state.current
    return (state, shaft), own, heat


@functools.cache
def axis_runner(servo_step: Any, between: bool) -> Any:
    """The compiled run of an axis under `axis_servo_step`, or the step of another servo.

    `between`: whether that servo's outer loops do nothing between their samples; such steps then take the short way.
    """
    drive_step = drive_step_of(servo_step)

    @loop(error_model="numpy")
    def run_axis(
        plant: Plant, drive: AxisDriveParams, state: AxisState, shaft: QuadratureState, brake: BrakeState,
        own: AxisDriveState, reference: Array, loads: Array, stop_step: int, stop_category: int, log: Array,
        events: NDArray[np.int64],
    ) -> int:  # fmt: skip
        """Run along reference samples (3, n) of the position loop, and on for as long as the log (13, ticks) has room.

        `events` (e, 2) take each cause that is found, with its step. Return how many there are.
        """
        k = found = many = bad = 0
        count, load_count, lines, frames, faults = shaft.counts, 0, HEALTHY, 0.0, plant.faults
        for tick in range(log.shape[1]):
            _note(log[:, tick], state, own)
            heat, load = 0.0, loads[min(tick, loads.shape[0] - 1)]
            end = k + drive.servo.position_samples
            while k < end:
                broken = k >= faults.step
                lines = faults.lines if broken else HEALTHY
                shaft = quadrature_step(plant.encoder, lines, shaft, state.angle)
                if k % drive.servo.speed_samples == 0:  # a frame; a wrong one keeps the last count
                    frames += faults.bad_frames if broken else 0.0
                    bad = 1 if frames >= 1.0 else 0
                    frames -= bad
                    count = count if bad == 1 else shaft.counts
                    load_count = math.floor(state.load_angle * plant.load_counts_per_rad)
                seen = AxisSignals(
                    count, shaft.edges_a, shaft.edges_b, shaft.pulses, shaft.index_count,
                    faults.receiver if broken else 0, bad, state.current + faults.current_zero, faults.supply,
                    state.angle + faults.potentiometer, load_count, state.speed,
                )  # fmt: skip
                own = drive_step(drive, own, k, seen, reference, stop_category if k == stop_step else NONE)
                brake = brake_step(plant.brake, brake, own.brake)
                conducts = own.power == 1 and not (broken and faults.phase_lost == 1)
                holds = plant.brake.torque if brake.closed == 1 else 0.0
                holds = JAMMED if broken and faults.blocked == 1 else holds
                state = axis_step(plant.axis, state, own.servo.voltage, load, holds, conducts)
                heat += state.current * state.current
                if own.found != found:
                    many = _tell(events, many, k, own.found ^ found)
                    found = own.found
                k += 1
                rest = -k % drive.servo.speed_samples
                quiet = own.phase == RUNNING and brake.closed == 0 and brake.told == 0
                if between and quiet and rest > 0 and k + rest <= faults.step and not k <= stop_step < k + rest:
                    (state, shaft), own, heat = _between_looks(plant, drive, state, shaft, own, load, heat, rest)
                    k += rest
                    own = drive_place(own, reference) if k == end else own
            log[8, tick] = heat / drive.servo.position_samples
        return many

    return run_axis
