"""The drive of one axis, compiled: what is around its loops from power-on to power-off, and what it does about faults.

    OFF -> CHECKING -> RELEASING (-> HOMING) -> RUNNING
                                     RUNNING -> SLOWING -> CLOSING -> OFF    stop of category 1
                                              SLOWING -> HOLDING             category 2: it stands powered
    any -> OFF                                                               category 0: brake and power at once
    any -> BLIND -> OFF                                                      the encoder is not believed: by back-emf

Signals come in, a voltage, a brake and the power stage's enable go out; the plant it never sees.
"""

from __future__ import annotations

import functools
from typing import Any

from holonom.arrays import Array
from holonom.control.servo.kernels import axis_violation
from holonom.control.servo.watch_kernels import (
    BLOCKED,
    COUNTS,
    LINE,
    UNSURE,
    WINDING,
    DriveSeen,
    DriveWatchState,
    unsuspecting,
    watch_drive,
)
from holonom.devices.encoders.counters.index import IndexState, index_step
from holonom.devices.encoders.homing.potentiometer import potentiometer_step
from holonom.devices.encoders.homing.states import HomingState
from holonom.machine.axis.drive_records import (
    BLIND,
    CHECKING,
    CLOSING,
    HOLDING,
    HOMING,
    NONE,
    OFF,
    RELEASING,
    RUNNING,
    SLOWING,
    AxisDriveParams,
    AxisDriveState,
    AxisSignals,
    CheckParams,
    StopParams,
)
from holonom.machine.axis.kernels import (
    POSITION_LOOP,
    AxisServoState,
    current_between,
    current_only,
    homed,
    powered,
    standing,
)
from holonom.trace.code.loops import loop

__all__ = ["drive_between", "drive_place", "drive_step_of"]

OFFSET, SUPPLY, POSITION, BRAKE = 21, 22, 23, 24
"""Failed checks, beside the causes of `watch_drive`."""
HOMING_FAULT = 24
"""Beside these the faults of a homing, from 1 on."""
HOMED = 5
"""Phase of a homing that is done."""
SPEED, CURRENT = 5, 6
"""Of `axis_violation`."""
OTHER_COUNTS = 100  # of a turn, one part that is missing: no lost edges, another encoder
USUAL = 0.02  # of the usual current, each look
CONDUCTS = 0.2  # part by which the test current may be off


@loop(error_model="numpy", forceinline=True)
def _look(
    params: AxisDriveParams, state: AxisDriveState, k: int, seen: AxisSignals, current: float, reference: Array
) -> tuple[int, tuple[DriveWatchState, IndexState, float, float, float]]:
    """What is wrong at this step (0: nothing): once each sample of the speed loop, from means since the last one."""
    p, s = params, state
    voltages, currents, usual = s.voltages + s.servo.voltage, s.currents + current, s.usual
    if not p.supervised or k % p.servo.speed_samples != 0:
        return 0, (s.watch, s.index_state, voltages, currents, usual)
    index = index_step(p.index_params, s.index_state, seen.counts, seen.pulses, seen.index_count)
    off = 1 if index.fault == 0 and abs(index.total_lost) > 1 else index.fault
    off = 3 if off == 1 and abs(index.lost) * OTHER_COUNTS > p.index_params.counts_per_rev else off
    n = float(p.servo.speed_samples)
    mean = (currents + p.watch.current_before * (s.watch.current - current)) / n
    means = DriveSeen(
        seen.counts, seen.edges_a, seen.edges_b, off, seen.line_fault, seen.bad_frame, voltages / n, mean, current,
        s.servo.current_reference, usual,
    )  # fmt: skip
    watch = watch_drive(p.watch, s.watch, means)
    usual += USUAL * (mean - usual) if watch.differs == 0 and s.phase != BLIND else 0.0
    found = watch.cause if s.power == 1 and s.phase != CHECKING and (s.phase != BLIND or s.first == 0) else 0
    if found == 0 and s.phase == RUNNING and k % p.servo.position_samples == 0:
        wanted = s.servo.angle if p.servo.outer != POSITION_LOOP else _at(reference, s.place, 0)
        found = axis_violation(p.limits, wanted, s.servo.angle, s.servo.rate, current)
    return found, (watch, index, 0.0, 0.0, usual)


@loop(error_model="numpy", forceinline=True)
def _home(
    params: AxisDriveParams, state: AxisDriveState, phase: int, found: int, k: int, seen: AxisSignals, held: float
) -> tuple[int, int, HomingState, AxisServoState, float]:
    """A step of the homing.

    Phase, what is wrong, its state, the servo (which knows its zero once it is done), and the angle that is held, which
    goes ahead at the homing's speed.
    """
    p, s, homing, servo = params, state, state.homing, state.servo
    if phase != HOMING:
        return phase, found, homing, servo, held
    if k % p.servo.speed_samples == 0:
        homing = potentiometer_step(p.homing, homing, seen.counts, seen.pulses, seen.index_count, seen.potentiometer)
        if homing.fault != 0 and found == 0:
            found = HOMING_FAULT + homing.fault
        if homing.phase == HOMED:
            servo = homed(p.servo, s.servo, homing.offset)
            return RUNNING, found, homing, servo, servo.angle
        held += homing.speed * p.servo.encoder.resolution * p.watch.dt
    return phase, found, homing, servo, held


@loop(error_model="numpy", forceinline=True)
def drive_between(params: AxisDriveParams, state: AxisDriveState, measured: float) -> AxisDriveState:
    """A drive's step while it runs, at a step that is no sample of the outer loops: a current (A) comes in.

    Nothing is looked at and nothing is decided then; the place on the path is the caller's to move (`drive_place`).
    """
    s = state
    current = measured - s.zero
    return AxisDriveState(
        current_between(params.servo, s.servo, current), s.watch, s.index_state, s.homing, s.phase, s.steps + 1,
        s.place, s.rate, s.held, s.category, s.voltages + s.servo.voltage, s.currents + current, s.usual, s.zero,
        s.checked, s.checked_count, s.brake, s.power, s.found, s.first,
    )  # fmt: skip


@loop(error_model="numpy", forceinline=True)
def drive_place(state: AxisDriveState, reference: Array) -> AxisDriveState:
    """The drive that runs, a sample of the position loop further on its path."""
    s = state
    place = min(s.place + 1.0, reference.shape[1] - 1.0)
    return AxisDriveState(
        s.servo, s.watch, s.index_state, s.homing, s.phase, s.steps, place, 1.0, s.held, s.category, s.voltages,
        s.currents, s.usual, s.zero, s.checked, s.checked_count, s.brake, s.power, s.found, s.first,
    )  # fmt: skip


@loop(error_model="numpy", forceinline=True)
def _react(phase: int, category: int, found: int, asked: int) -> tuple[int, int]:
    """Phase and category of its stop after what was found, and what is asked for."""
    if found != 0:
        reaction = _reaction(found)
        if reaction == OFF or (reaction == BLIND and phase != OFF) or (reaction == SLOWING and phase == RUNNING):
            phase, category = reaction, 1
    if asked != NONE and phase in (RUNNING, HOLDING, RELEASING):
        phase, category = (OFF if asked == 0 else SLOWING), asked
    return phase, category


@loop(error_model="numpy", forceinline=True)
def _at(reference: Array, place: float, row: int) -> float:
    """A row of the reference at a place between its samples."""
    place = min(place, reference.shape[1] - 1.0)
    k = int(place)
    after = min(k + 1, reference.shape[1] - 1)
    return float(reference[row, k] + (place - k) * (reference[row, after] - reference[row, k]))


@loop(error_model="numpy", forceinline=True)
def _reaction(cause: int) -> int:
    """Phase that a cause leads to: an open winding cannot brake; what the encoder says is not believed, or it is."""
    if cause == WINDING or cause >= OFFSET:
        return OFF
    return BLIND if UNSURE <= cause <= COUNTS or cause in (SPEED, CURRENT, BLOCKED) else SLOWING


@loop(error_model="numpy", forceinline=True)
def _goes_on(stop: StopParams, phase: int, steps: int, rate: float, category: int, emf: float, homes: bool) -> int:
    """The phase after one that has come to its end."""
    if phase == RELEASING and steps >= stop.opening + stop.settling:
        return HOMING if homes else RUNNING
    if phase == SLOWING and rate <= 0.0 and steps >= stop.settling:
        return HOLDING if category == 2 else CLOSING
    if phase == CLOSING and steps >= stop.closing + stop.settling:
        return OFF
    if phase == BLIND and steps >= stop.closing and emf < stop.slow:
        return OFF
    return phase


@loop(error_model="numpy", forceinline=True)
def _check(
    check: CheckParams, state: AxisDriveState, seen: AxisSignals, current: float
) -> tuple[int, int, float, float, int]:
    """Self-check with the brake closed: phase, failed check (0: none), current's zero, sum, count at the start."""
    s, step, half = state, state.steps, check.torque_steps // 2
    if step == 0 and seen.line_fault != 0:
        return OFF, LINE, s.zero, 0.0, seen.counts
    if step < check.zero_steps:
        return CHECKING, 0, s.zero, s.checked + seen.current, seen.counts
    if step == check.zero_steps:
        zero = s.checked / check.zero_steps
        if not abs(zero) <= check.greatest_zero:
            return OFF, OFFSET, zero, 0.0, seen.counts
        if not check.least_supply <= seen.supply <= check.most_supply:
            return OFF, SUPPLY, zero, 0.0, seen.counts
        if not abs(seen.potentiometer - s.servo.angle) <= check.apart:
            return OFF, POSITION, zero, 0.0, seen.counts
        return CHECKING, 0, zero, 0.0, seen.counts
    tested = step - check.zero_steps
    if tested == half or tested == check.torque_steps:
        wanted = check.current if tested == half else -check.current
        if not abs(current - wanted) <= CONDUCTS * check.current:
            return OFF, WINDING, s.zero, 0.0, s.checked_count
        if abs(seen.counts - s.checked_count) > check.turns:
            return OFF, BRAKE, s.zero, 0.0, s.checked_count
    return (RELEASING if tested >= check.torque_steps else CHECKING), 0, s.zero, 0.0, s.checked_count


@functools.cache
def _act_of(servo_step: Any) -> Any:
    """The loops in a phase, around the step of a servo."""

    @loop(error_model="numpy", forceinline=True)
    def act(
        params: AxisDriveParams, state: AxisDriveState, servo: AxisServoState, phase: int, steps: int, k: int,
        seen: AxisSignals, current: float, emf: float, held: float, speed: float, reference: Array,
    ) -> AxisServoState:  # fmt: skip
        """The loops in a phase."""
        p, s = params, state
        if phase == OFF or (phase == CHECKING and steps < p.check.zero_steps):
            return standing(p.servo, servo, seen.counts)
        if phase == CHECKING:
            second = steps >= p.check.zero_steps + p.check.torque_steps // 2
            return current_only(p.servo, servo, -p.check.current if second else p.check.current, current)
        if phase == BLIND:
            most, brakes = p.watch.max_current, s.usual - p.stop.emf_gain * emf
            return current_only(p.servo, servo, min(max(brakes, -most), most), current)
        if phase == RELEASING:
            servo = powered(servo, p.hold) if steps == 0 else servo
        if phase in (RELEASING, HOMING):
            r = held if p.servo.outer == POSITION_LOOP else speed
            return servo_step(p.servo, servo, k, seen.counts, current, r, 0.0, 0.0, seen.load_counts, seen.tachometer)
        r = _at(reference, s.place, 0)
        v = s.rate * _at(reference, s.place + p.servo.speed_lead, 1)
        a = s.rate * s.rate * _at(reference, s.place + p.servo.acceleration_lead, 2)
        if p.servo.outer != POSITION_LOOP:
            r, v, a = s.rate * r, s.rate * r, v
        if phase == SLOWING:
            a -= p.stop.slowing * p.stop.samples * v
        return servo_step(p.servo, servo, k, seen.counts, current, r, v, a, seen.load_counts, seen.tachometer)

    return act


@functools.cache
def drive_step_of(servo_step: Any) -> Any:
    """The compiled step of a drive around `axis_servo_step`, or that of another servo."""
    act = _act_of(servo_step)

    @loop(error_model="numpy", forceinline=True)
    def drive_step(
        params: AxisDriveParams, state: AxisDriveState, k: int, seen: AxisSignals, reference: Array, asked: int
    ) -> AxisDriveState:
        """One step of the current loop; `servo.voltage`, `brake` and `power` of what comes back act until the next one.

        Parameters
        ----------
        params, state
            Of this drive.
        k
            Steps before.
        seen
            What is measured.
        reference
            (3, n) at the motor, a sample each of the position loop: position, speed, acceleration; or, by the outermost
            loop, speeds, currents.
        asked
            Category of the stop that is asked for, `NONE` without.
        """
        p, s = params, state
        current = seen.current - s.zero
        found, looked = _look(p, s, k, seen, current, reference)
        watch, index, voltages, currents, usual = looked
        phase, zero, checked, checked_count, held = s.phase, s.zero, s.checked, s.checked_count, s.held
        if phase == CHECKING:
            phase, found, zero, checked, checked_count = _check(p.check, s, seen, current)
            held = s.servo.angle
            if phase == RELEASING:  # the shaft stands: all of the voltage is the resistance's
                watch = unsuspecting(watch, s.servo.voltage / current)
        phase, found, homing, homing_servo, held = _home(p, s, phase, found, k, seen, held)
        phase, category = _react(phase, s.category, found, asked)
        steps = s.steps + 1 if phase == s.phase else 0
        phase = _goes_on(p.stop, phase, steps, s.rate, category, abs(watch.emf) - watch.allowed, p.homes)
        steps = steps if phase == s.phase else 0
        speed = homing.speed * p.servo.encoder.resolution
        servo = act(p, s, homing_servo, phase, steps, k, seen, current, watch.emf, held, speed, reference)
        place, rate = s.place, s.rate
        if k % p.servo.position_samples == p.servo.position_samples - 1:
            rate = 1.0 if phase == RUNNING else max(rate - p.stop.slowing, 0.0) if phase == SLOWING else 0.0
            place = min(place + rate, reference.shape[1] - 1.0)
        named = found if found != UNSURE else 0
        brake = 1 if phase in (OFF, CHECKING, CLOSING, BLIND) else 0
        power = 0 if phase == OFF or (phase == CHECKING and steps < p.check.zero_steps) else 1
        return AxisDriveState(
            servo, watch, index, homing, phase, steps, place, rate, held, category, voltages, currents, usual, zero,
            checked, checked_count, brake, power, s.found | (1 << named if named != 0 else 0),
            s.first if s.first != 0 else named,
        )  # fmt: skip

    return drive_step
