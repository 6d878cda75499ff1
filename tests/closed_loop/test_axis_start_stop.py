"""Power-on, servo-on and the stops of an axis, on the Puma's shoulder stretched out (46.0 N m)."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import holonom as hm
from holonom.closed_loop.axis_faults import AxisFault
from holonom.control import design_cascade
from holonom.control.servo.causes import Cause
from holonom.devices import DcMotor, Encoder, Friction, Gear, PotentiometerHoming
from holonom.devices.power.brake import Brake
from holonom.errors import OutOfLimits
from holonom.machine.axis.drive import DriveSettings
from holonom.machine.axis.drive_records import CLOSING, HOLDING, HOMING, OFF, RUNNING
from holonom.sim import Axis, Load, simulate_axis

WEIGHT = -46.0  # N m: it would fall in the positive direction


def shoulder() -> Axis:
    """Joint 2 with all others locked; Armstrong's and Corke's numbers, as the preset has them."""
    arm = hm.load_arm("puma560")
    joint = arm.model.joints[1]
    motor, ratio = joint.motor, joint.motor.gear_ratio
    stretched = [0.0, 0.0, -1.5446, 0.0, 0.0, 0.0]
    assert arm.gravity(stretched)[1] == pytest.approx(46.0, abs=0.05)
    inertia = arm.mass_matrix(stretched)[1, 1] - motor.rotor_inertia * ratio**2
    rubs = joint.friction
    return Axis(
        DcMotor(
            motor.resistance, motor.inductance, motor.torque_constant, motor.torque_constant, motor.rotor_inertia,
            motor.max_voltage, motor.max_current,
        ),
        Load(inertia),
        Encoder(motor.encoder_counts),
        Gear(ratio),
        Friction(rubs.viscous / ratio**2, rubs.coulomb_positive / ratio, rubs.coulomb_negative / ratio),
        max_speed=math.radians(54.0),
    )  # fmt: skip


AXIS = shoulder()
GAINS = design_cascade(AXIS.servo_axis())
COUNT = 2.0 * math.pi / 800 / 107.815
SETTINGS = DriveSettings(start="off", brake=Brake(1.0, engage=0.02, release=0.03), hold=WEIGHT / 107.815)


@pytest.mark.parametrize("model", [0.95, 1.0, 1.05])
def test_the_arm_does_not_sag_when_it_is_switched_on_and_stopped(model: float) -> None:
    settings = dataclasses.replace(SETTINGS, hold=model * SETTINGS.hold)
    run = simulate_axis(AXIS, GAINS, np.zeros(300), load_torque=WEIGHT, drive=settings, stop=(0.4, 1))
    assert not run.events
    assert np.abs(run.position).max() < 4.0 * COUNT
    assert set(run.phase) >= {RUNNING, CLOSING, OFF}
    assert run.phase[-1] == OFF
    assert run.current[-1] == 0.0
    powered = np.flatnonzero(run.current_reference)
    assert powered[0] > 0  # the self-check begins without power


@pytest.mark.parametrize(("delay", "falls"), [(0.02, 0.0705), (0.05, 0.433)])
def test_category_0_falls_for_as_long_as_the_brake_takes(delay: float, falls: float) -> None:
    """0.0705 deg in 20 ms, 0.433 in 50 ms: free fall against its friction, other joints locked."""
    settings = dataclasses.replace(SETTINGS, brake=Brake(10.0, engage=delay, release=0.03))
    run = simulate_axis(AXIS, GAINS, np.zeros(600), load_torque=WEIGHT, drive=settings, stop=(0.4, 0))
    at = run.position[np.flatnonzero(run.time >= 0.4)[0]]
    after = run.position[np.flatnonzero(run.time >= 0.4 + delay)[0]]
    assert math.degrees(after - at) == pytest.approx(falls, rel=0.02)
    assert run.position[-1] - after < 0.2 * (after - at)  # the brake stops it
    assert run.speed[-1] == 0.0


def test_category_2_stands_powered_where_the_path_came_to_its_end() -> None:
    t = np.arange(1000) * 1e-3
    course = 0.2 * t
    run = simulate_axis(
        AXIS, GAINS, np.stack([course, np.full(1000, 0.2), np.zeros(1000)]), load_torque=WEIGHT, stop=(0.5, 2)
    )
    assert run.phase[-1] == HOLDING
    assert run.position[-1] == pytest.approx(0.2 * (0.5 + 0.5 * 0.2), abs=1e-3)  # a stop in 0.2 s
    assert np.abs(run.position - run.reference)[600:].max() < 5e-3
    assert abs(run.current[-1]) > 1.0  # it carries the load


def test_category_1_stops_on_the_path_then_brakes() -> None:
    t = np.arange(1000) * 1e-3
    course = 0.3 * t
    run = simulate_axis(AXIS, GAINS, np.stack([course, np.full(1000, 0.3), np.zeros(1000)]), stop=(0.5, 1))
    assert run.phase[-1] == OFF
    assert run.position[-1] == pytest.approx(0.3 * 0.6, abs=1e-3)


@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (AxisFault("current_offset", size=1.0), Cause.CURRENT_OFFSET),
        (AxisFault("supply", size=30.0), Cause.SUPPLY),
        (AxisFault("potentiometer", size=2.0 * math.pi), Cause.POSITION_UNKNOWN),
        (AxisFault("brake_slips", size=0.01), Cause.BRAKE_SLIPS),
        (AxisFault("phase_lost"), Cause.PHASE_LOST),
        (AxisFault("line_broken"), Cause.LINE_BROKEN),
    ],
)
def test_a_failed_check_is_named_and_refuses_motion(fault: AxisFault, cause: Cause) -> None:
    run = simulate_axis(AXIS, GAINS, np.linspace(0.0, 0.5, 500), drive=SETTINGS, faults=[fault])
    assert run.events[0].cause == cause
    assert RUNNING not in run.phase
    assert np.abs(run.position).max() < 0.02
    assert run.phase[-1] == OFF


def test_a_small_offset_of_the_shunt_is_taken_off() -> None:
    run = simulate_axis(
        AXIS, GAINS, np.zeros(300), load_torque=WEIGHT, drive=SETTINGS, faults=[AxisFault("current_offset", size=0.1)]
    )
    assert not run.events
    assert np.abs(run.position).max() < 4.0 * COUNT


@pytest.mark.parametrize("stop", [(0.1, 3), (-1.0, 0), (math.nan, 1)])
def test_a_stop_that_there_is_not(stop: tuple[float, int]) -> None:
    with pytest.raises(OutOfLimits, match="a category 0, 1 or 2"):
        simulate_axis(AXIS, GAINS, [0.0], stop=stop)


HOMES = DriveSettings(
    start="off",
    brake=Brake(1.0),
    homing=PotentiometerHoming(800, 800 / (2.0 * math.pi), lowest=-500.0, highest=500.0, speed=2000.0),
)


@pytest.mark.parametrize("start", [0.0, 0.3, -0.7123])
def test_an_axis_finds_its_zero_by_potentiometer_and_index(start: float) -> None:
    run = simulate_axis(AXIS, GAINS, np.full(1500, start), drive=HOMES, start=start)
    assert not run.events
    assert HOMING in run.phase
    assert run.phase[-1] == RUNNING
    assert np.abs(run.seen_position - run.motor_position)[-100:].max() < 2.0 * 2.0 * math.pi / 800
    turned = run.motor_position[np.flatnonzero(run.phase == HOMING)]
    assert np.ptp(turned) < 1.1 * 2.0 * math.pi  # a short move to the next index
    assert abs(run.position[-1] - start) < 2.0 * COUNT


@pytest.mark.parametrize(
    ("fault", "cause"),
    [
        (AxisFault("potentiometer", size=math.pi), Cause.HOMING_WRONG_TURN),
        (AxisFault("index_stuck"), Cause.HOMING_MISSING_INDEX),
        (AxisFault("potentiometer", size=1e4), Cause.HOMING_NO_SIGNAL),
    ],
)
def test_a_homing_that_fails_is_named_and_refuses_motion(fault: AxisFault, cause: Cause) -> None:
    run = simulate_axis(
        AXIS, GAINS, np.full(1500, 0.3), start=0.3, faults=[fault],
        drive=dataclasses.replace(HOMES, homing=dataclasses.replace(HOMES.homing, lowest=-500.0, highest=500.0)),
    )  # fmt: skip
    assert run.events[0].cause == cause
    assert RUNNING not in run.phase
    assert run.phase[-1] == OFF


def test_a_homing_comes_after_power_on() -> None:
    with pytest.raises(OutOfLimits, match="looks for its zero after"):
        dataclasses.replace(HOMES, start="powered")
