"""Servos of an axis in a whole simulation: each of them, and what it is for."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from holonom.closed_loop import axis as closed_axis
from holonom.closed_loop.axis_faults import AxisFault
from holonom.closed_loop.axis_kernels import axis_runner
from holonom.closed_loop.axis_tuning import trapezoid, tune_axis
from holonom.control import SERVOS, SampleTimes, design_cascade
from holonom.control.servo.law_design import law_gains, servo_law
from holonom.control.servo.remaining import remaining_errors
from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.errors import OutOfLimits
from holonom.machine.axis.drive import DriveSettings
from holonom.machine.axis.kernels import axis_servo_step
from holonom.sim import Axis, Load, simulate_axis

RE40 = DcMotor(1.13, 0.33e-3, 0.0603, 0.0603, 1.37e-5, 48.0, 10.0)
PLAIN = Axis(RE40, Load(3e-5), Encoder(20_000), friction=Friction(), load_encoder=Encoder(20_000))
RUBBING = dataclasses.replace(PLAIN, load=Load(3e-5, coulomb=0.002), friction=Friction(0.0, 0.004, 0.004))
ELASTIC = dataclasses.replace(RUBBING, stiffness=20.0)
LOOSE = dataclasses.replace(RUBBING, gap=0.01)
AXES = {"notch": ELASTIC, "load_side": LOOSE, "backlash": LOOSE}
COUNT = 2.0 * math.pi / 20_000


def gains_of(name: str, axis: Axis, **given: Any) -> Any:
    return SERVOS.make(name, given).design(axis.servo_axis())


@pytest.mark.parametrize("name", list(SERVOS))
def test_each_servo_goes_where_it_is_told_within_its_limits(name: str) -> None:
    axis = AXES.get(name, RUBBING)
    gains = gains_of(name, axis)
    run = simulate_axis(axis, gains, np.ones(800))
    assert not run.events
    assert run.position.max() < 1.01 + axis.gap / 2.0
    rests = 0.02 if name == "speed_pd" else 0.5 * axis.gap + 20.0 * COUNT  # friction is a load, that PD lets stand
    assert abs(run.position[-1] - 1.0) < rests
    assert np.abs(run.current).max() < 1.1 * RE40.max_current
    assert np.abs(run.speed_reference).max() <= gains.position.max_speed
    if name != "one_loop":
        assert np.abs(run.current_reference).max() <= RE40.max_current


@pytest.mark.parametrize("name", list(SERVOS))
def test_a_constant_load_leaves_no_error_but_of_pd(name: str) -> None:
    axis = dataclasses.replace(AXES.get(name, PLAIN), friction=Friction(), load=Load(3e-5))
    gains = gains_of(name, axis)
    run = simulate_axis(axis, gains, np.zeros(1500), load_torque=np.where(np.arange(1500) < 300, 0.0, 0.1))
    assert np.abs(run.motor_position).max() > 10.0 * COUNT
    if name == "speed_pd":  # i / K / k, the error that carries the load
        wanted = -0.1 / 0.0603 / gains.speed.gain / gains.position.gain
        assert run.position[-1] == pytest.approx(wanted, rel=0.01)
    elif name != "backlash":  # its flank is a matter of the motion
        bent = 0.1 / axis.stiffness
        at = run.motor_position if name == "notch" else run.position
        assert abs(at[-1]) < bent + 4.0 * COUNT


def test_tuning_takes_any_servo() -> None:
    for name in ("two_loops", "one_loop", "disturbance", "tachometer", "speed_pd"):
        found = tune_axis(RUBBING, servo=SERVOS.make(name))
        assert found.loops.keys() == found.gains.margins.keys()
        assert found.verified.overshoot_percent < 1.0
        assert found.loops["angle" if name in ("two_loops", "one_loop") else "speed"].form in ("PID", "PI", "P", "PD")
    pid = tune_axis(RUBBING, servo=SERVOS.make("two_loops"))
    loop, gains = pid.loops["angle"], pid.gains
    s = 30.0j  # the PID as one and as it is made
    assert loop.Ti is not None
    assert loop.Td is not None
    made = (gains.speed.gain + gains.speed.integral_gain / 5e-4 / s) * (1.0 + gains.position.gain / s) * s
    assert loop.Kc * (1.0 + 1.0 / (s * loop.Ti) + s * loop.Td) == pytest.approx(made, rel=1e-9)


def test_the_speed_loop_overshoots_as_its_continuous_design_and_its_prefilter_takes_it_away() -> None:
    """23.2 % without sampling; the small lag is a delay here, mostly, and the observer helps a little."""
    fine = dataclasses.replace(PLAIN, encoder=Encoder(4_000_000))
    gains = design_cascade(fine.servo_axis(), times=SampleTimes(2e-5, 1e-4, 1e-3))
    over = {}
    for prefilter in (False, True):
        run = simulate_axis(
            fine, gains, np.full(300, 2.0), loop="speed", feed_forward=False, drive=DriveSettings(prefilter=prefilter)
        )
        over[prefilter] = 100.0 * (run.speed.max() / 2.0 - 1.0)
    assert over[False] == pytest.approx(23.2, abs=4.0)
    assert over[True] < 1.0


def test_speed_alone_with_one_loop() -> None:
    gains = gains_of("one_loop", PLAIN)
    run = simulate_axis(PLAIN, gains, np.full(400, 100.0), loop="speed", load_torque=0.05)
    assert run.speed[-100:].mean() == pytest.approx(100.0, rel=2e-3)
    assert run.speed.max() < 110.0
    with pytest.raises(OutOfLimits, match="loop is 'current'; this servo has no such loop"):
        simulate_axis(PLAIN, gains, np.zeros(10), loop="current")


def test_a_load_that_is_compensated_disturbs_less() -> None:
    load = np.where(np.arange(600) < 300, 0.0, 0.1)
    dips = {}
    for part in (0.5, 1.0):
        run = simulate_axis(PLAIN, gains_of("disturbance", PLAIN, part=part), np.zeros(600), load_torque=load)
        dips[part] = abs(run.position[-1])
    bare = gains_of("speed_pd", PLAIN)
    rests = 0.1 / 0.0603 / gains_of("disturbance", PLAIN).speed.gain / gains_of("disturbance", PLAIN).position.gain
    assert dips[0.5] == pytest.approx(0.5 * rests, rel=0.02)  # a part of it is left
    assert dips[1.0] < 4.0 * COUNT
    assert bare.speed.integral_gain == 0.0


@pytest.mark.parametrize("factor", [0.6, 1.7])
def test_compensation_bears_a_wrong_inertia(factor: float) -> None:
    true = dataclasses.replace(PLAIN, load=Load(factor * 4.37e-5 - 1.37e-5))
    run = simulate_axis(true, gains_of("disturbance", PLAIN), np.full(600, 0.5), known=PLAIN)
    assert not run.events
    assert np.abs(run.position[-100:] - 0.5).max() < 4.0 * COUNT


def test_a_notch_keeps_an_elastic_axis_quiet() -> None:
    """The cascade of the same axis taken for rigid shakes; with the notch it stands."""
    rigid, unwatched = design_cascade(ELASTIC.servo_axis()), DriveSettings(supervised=False)
    plain = simulate_axis(ELASTIC, rigid, np.ones(800), drive=unwatched)
    quiet = simulate_axis(ELASTIC, gains_of("notch", ELASTIC), np.ones(800))
    assert np.ptp(plain.speed[-100:]) > 5.0
    assert np.ptp(quiet.speed[-100:]) < 0.1


def test_an_encoder_on_the_load_leaves_no_backlash_in_it() -> None:
    load = 0.05  # pushes the load to one flank
    at_motor = simulate_axis(LOOSE, design_cascade(LOOSE.servo_axis()), np.ones(1500), load_torque=load)
    at_load = simulate_axis(LOOSE, gains_of("load_side", LOOSE), np.ones(1500), load_torque=load)
    assert abs(at_motor.position[-1] - 1.0) == pytest.approx(0.5 * LOOSE.gap, rel=0.1)
    assert abs(at_load.position[-1] - 1.0) < 0.05 * LOOSE.gap


def test_a_gap_is_crossed_quickly_at_a_reversal() -> None:
    """There and back and there: error of the load after a reversal, and how long it lasts."""
    axis = dataclasses.replace(LOOSE, gear=Gear(10.0), load=Load(3e-3, coulomb=0.05))
    there = trapezoid(0.3, 1.0, 10.0, 1e-3)
    back = np.stack([0.3 - there[0], -there[1], -there[2]])
    reference = np.concatenate([there, back, there], axis=1)
    servos = (design_cascade(axis.servo_axis()), gains_of("backlash", axis))
    plain, led = (simulate_axis(axis, gains, reference) for gains in servos)
    after = slice(there.shape[1] + 40, None)
    errors = [np.abs(run.position - run.reference)[after] for run in (plain, led)]
    assert errors[0].mean() == pytest.approx(0.5 * axis.gap, rel=0.2)  # half a gap behind, all the way
    assert errors[1].mean() < 0.1 * errors[0].mean()
    begin = there.shape[1]
    crossed = [
        np.flatnonzero((run.motor_position / 10.0 - run.position)[begin:] < -0.45 * axis.gap)[0] for run in (plain, led)
    ]
    assert crossed[1] < 0.6 * crossed[0]


def test_a_tachometer_makes_the_inner_loop_stiff() -> None:
    load = np.where(np.arange(600) < 300, 0.0, 0.1)
    dips = {
        name: np.abs(simulate_axis(PLAIN, gains_of(name, PLAIN), np.zeros(600), load_torque=load).position).max()
        for name in ("three_loops", "tachometer")
    }
    assert dips["tachometer"] < 0.3 * dips["three_loops"]


def test_the_law_without_anything_else_is_the_cascade() -> None:
    """Two compiled servos, written apart: the same run to the last bit that rounding leaves."""
    axis = dataclasses.replace(RUBBING, gap=0.002)
    there = trapezoid(0.3, 20.0, 500.0, 1e-3)
    runs = [
        simulate_axis(axis, gains, there, load_torque=0.02)
        for gains in (design_cascade(axis.servo_axis()), law_gains(axis.servo_axis(), servo_law()))
    ]
    np.testing.assert_allclose(runs[0].position, runs[1].position, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(runs[0].voltage, runs[1].voltage, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("name", ["three_loops", "two_loops", "speed_pd"])
def test_remaining_errors_are_those_of_the_type_number(name: str) -> None:
    """The angle: type 1 by the reference, `K = k`; by the load type 1 with `K_R = k K_i`, or 0 with `k K` (PD)."""
    gains = gains_of(name, PLAIN)
    k, K, Ki, kt = gains.position.gain, gains.speed.gain, gains.speed.integral_gain / 5e-4, 0.0603
    t = np.arange(1500) * 1e-3
    of_reference = remaining_errors(1, gain=k).reference
    ramp = simulate_axis(PLAIN, gains, 2.0 * t, feed_forward=False)
    late = 2.0 * (1.5e-3 if name != "two_loops" else 0.75e-3)  # sampling
    assert ramp.reference[-1] - ramp.position[-1] == pytest.approx(2.0 * of_reference.ramp, abs=late)
    m = 0 if name == "speed_pd" else 1
    of_load = remaining_errors(1 + m, regulator_type=m, regulator_gain=k * (K if m == 0 else Ki)).load
    if m == 1:
        pushed = simulate_axis(PLAIN, gains, 0.0 * t, load_torque=0.1 * t)
        lag = 3.0 * (0.1 / 4.37e-5) / gains.observer_bandwidth**2  # rad/s, of its three poles, where a load grows
        wanted = 0.1 / kt * of_load.ramp + lag / k
        assert -pushed.position[-50:].mean() == pytest.approx(wanted, rel=0.05)
    pushed = simulate_axis(PLAIN, gains, 0.0 * t, load_torque=0.05)
    assert -pushed.position[-1] == pytest.approx(0.05 / kt * of_load.step, rel=0.02, abs=4.0 * COUNT)


@pytest.mark.parametrize("times", [SampleTimes(), SampleTimes(1e-4, 4e-4, 4e-4), SampleTimes(1e-4, 1e-4, 1e-3)])
def test_the_short_way_between_looks_is_the_long_one_to_the_bit(
    times: SampleTimes, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With faults, stops, start by self-check and gaps in it: any step may be the one at which something happens."""
    rng = np.random.default_rng(8)
    gains = design_cascade(LOOSE.servo_axis(), times=times)
    t = np.arange(600) * times.position
    runs: dict[bool, list[Any]] = {True: [], False: []}
    for kind in (None, "edges_lost", "channels_swapped", "blocked", "phase_lost"):
        at, stop = rng.uniform(0.05, 0.2), (rng.uniform(0.2, 0.24), int(rng.integers(3)))
        faults = [] if kind is None else [AxisFault(kind, at)]
        for start in ("powered", "off"):
            drive = DriveSettings(start=start)
            for short in (True, False):
                monkeypatch.setattr(closed_axis, "_runner", lambda _, short=short: axis_runner(axis_servo_step, short))
                run = simulate_axis(
                    LOOSE, gains, 0.3 * np.sin(8.0 * t), load_torque=0.03, faults=faults, stop=stop, drive=drive
                )
                runs[short].append(run)
    for one, other in zip(runs[True], runs[False], strict=True):
        assert one.events == other.events
        for name in ("position", "motor_speed", "current", "voltage", "square_current", "seen_speed", "phase"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
