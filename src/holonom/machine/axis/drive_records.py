"""Memory of an axis's drive: what it reads, its params, its state, by name."""

from __future__ import annotations

from typing import NamedTuple

from holonom.control.servo.kernels import LimitParams
from holonom.control.servo.watch_kernels import DriveWatchParams, DriveWatchState
from holonom.devices.encoders.counters.index import IndexParams, IndexState
from holonom.devices.encoders.homing.potentiometer import PotentiometerParams
from holonom.devices.encoders.homing.states import HomingState
from holonom.machine.axis.kernels import AxisServoParams, AxisServoState

__all__ = [
    "BLIND", "CHECKING", "CLOSING", "HOLDING", "HOMING", "NONE", "OFF", "RELEASING", "RUNNING", "SLOWING",
    "AxisDriveParams", "AxisDriveState", "AxisSignals", "CheckParams", "StopParams",
]  # fmt: skip

OFF, CHECKING, RELEASING, RUNNING, SLOWING, CLOSING, HOLDING, BLIND, HOMING = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""Phases."""
NONE = -1
"""No stop is asked for."""


class AxisSignals(NamedTuple):
    """What the drive reads.

    Count, edges of A and B, index pulses and the count at the last one since power-on; the receivers' word and the
    frame's checksum (0: well); A; the supply, V; the potentiometer, rad at the motor; counts of the load's encoder; the
    tachometer, rad/s.
    """

    counts: int
    edges_a: int
    edges_b: int
    pulses: int
    index_count: int
    line_fault: int
    bad_frame: int
    current: float
    supply: float
    potentiometer: float
    load_counts: int
    tachometer: float


class CheckParams(NamedTuple):
    """Self-check.

    Steps of the current's zero and of the test torque; greatest zero, A; supply, V; test current, A; counts that a
    shaft may turn against its brake; what counter and potentiometer may differ by, rad.
    """

    zero_steps: int
    torque_steps: int
    greatest_zero: float
    least_supply: float
    most_supply: float
    current: float
    turns: int
    apart: float


class StopParams(NamedTuple):
    """Stops.

    Part by which the path slows down each position sample, and how many there are in a second; steps until the brake
    has opened, until it has closed, and until an axis has settled; A per rad/s of the brake by back-emf, speed (rad/s)
    below which it has ended.
    """

    slowing: float
    samples: float
    opening: int
    closing: int
    settling: int
    emf_gain: float
    slow: float


class AxisDriveParams(NamedTuple):
    """Params of a drive's step.

    `hold` is the current (A) that the model says carries the load at rest; `homes`: whether it looks for its zero.
    """

    servo: AxisServoParams
    watch: DriveWatchParams
    index_params: IndexParams
    limits: LimitParams
    check: CheckParams
    stop: StopParams
    hold: float
    supervised: bool
    homing: PotentiometerParams
    homes: bool


class AxisDriveState(NamedTuple):
    """State of a drive.

    Attributes
    ----------
    servo, watch, index_state, homing
        Of its parts.
    phase, steps
        Where it is between power-on and power-off, and for how many steps.
    place, rate, held, category
        On the path: samples, how fast it is gone along, angle that is held before it (rad); category of its stop.
    voltages, currents
        Sums since the last look.
    usual, zero
        The current that the load usually takes; what the shunt shows without any, A.
    checked, checked_count
        Of the self-check: sum, and count at its start.
    brake, power
        What goes out beside the voltage: 1, told to close; 1, on.
    found, first
        All that was found, a bit for each cause, and the first.
    """

    servo: AxisServoState
    watch: DriveWatchState
    index_state: IndexState
    homing: HomingState
    phase: int
    steps: int
    place: float
    rate: float
    held: float
    category: int
    voltages: float
    currents: float
    usual: float
    zero: float
    checked: float
    checked_count: int
    brake: int
    power: int
    found: int
    first: int
