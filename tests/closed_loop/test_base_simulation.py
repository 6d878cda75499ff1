"""A base keeps its path: alone, over ice, with a dead motor; and says what happened, when, to which wheel."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from simulated_bases import BASES, DRIVE, soccer

from holonom.closed_loop.base import simulate_base
from holonom.closed_loop.base_log import BaseLog
from holonom.control.base.traction import TractionSettings
from holonom.errors import OutOfLimits, UnknownName
from holonom.machine.base.paths import PathLimits, ReferencePath, figure_of_eight, plan_path
from holonom.machine.base.settings import BaseSettings, Creep, slip_settings
from holonom.mobile.drive.base_drive import BaseSensors
from holonom.mobile.drive.coupling import Coupling
from holonom.mobile.drive.slip import SlipStatus, detect_slip
from holonom.sim.base.floor import CARPET, ICE, Floor, Material, RectangularPatch
from holonom.sim.base.plant import BaseFault

BASE = soccer()
EIGHT = plan_path(figure_of_eight(3.0), PathLimits(1.4, 2.0))
COUPLING = Coupling(BASE.velocity_coupling, BASE.radius, BASE.alpha)
SLIP = slip_settings(BaseSensors(), DRIVE, 0.02711)
SLIPS = 0.05
"""Slip speed (m/s) from which a wheel counts as slipping; the best grip is there, too."""


def run(path: ReferencePath = EIGHT, seed: int = 0, **arguments: object) -> BaseLog:
    base = arguments.pop("base", BASE)
    return simulate_base(base, DRIVE, path, rng=np.random.default_rng(seed), **arguments)  # type: ignore[arg-type]


def ice_under(wheel: int, at: int, length: float = 0.3, width: float = 0.05) -> Floor:
    """A strip of ice along the track of one wheel, about a sample of EIGHT."""
    place = EIGHT.pose[at, :2] + [BASE.wheels[wheel].x, BASE.wheels[wheel].y]
    angle = float(np.arctan2(EIGHT.twist[at, 1], EIGHT.twist[at, 0]))
    return Floor(CARPET, (RectangularPatch((place[0], place[1]), length, width, ICE, angle),))


@pytest.mark.parametrize("name", ["omni 4", "omni 3", "mecanum"])
@pytest.mark.parametrize("heading", ["fixed", "tangent", "rotating"])
def test_it_keeps_its_path(name: str, heading: str) -> None:
    path = plan_path(figure_of_eight(3.0), PathLimits(1.0, 1.5), heading=heading)
    log = run(path, base=BASES[name])
    assert log.path_error.max() < 0.04
    assert np.abs(log.heading_error).max() < np.radians(2.0)
    assert len(log.time) == len(path.time)
    np.testing.assert_array_equal(log.reference_pose, path.pose)
    assert (log.rate == 1.0).all()
    assert not log.named.any()
    assert not log.dead.any()
    assert log.events == ()
    assert (log.ended, log.driven) == ("done", 1.0)


def test_its_estimate_is_true_and_its_loops_follow() -> None:
    log = run()
    assert np.hypot(*(log.estimated_pose - log.pose)[:, :2].T).max() < 0.03
    assert np.abs(log.estimated_twist - log.twist)[:, :2].max() < 0.05
    assert np.abs(log.wheel_speeds - log.reference_speeds).max() * 0.02711 < 0.06
    assert np.hypot(*(log.estimated_pose - log.reference_pose)[:, :2].T).max() < 0.01


def test_one_seed_gives_the_same_bits_and_another_does_not() -> None:
    a, b, c = run(seed=4), run(seed=4), run(seed=5)
    assert a.pose.tobytes() == b.pose.tobytes()
    assert a.currents.tobytes() == b.currents.tobytes()
    assert a.pose.tobytes() != c.pose.tobytes()


@pytest.mark.parametrize("traction", [TractionSettings(), None], ids=["traction control", "none"])
@pytest.mark.parametrize(("wheel", "at"), [(0, 1900), (1, 1300), (2, 1400), (3, 1250)])
def test_ice_under_one_wheel(wheel: int, at: int, traction: TractionSettings | None) -> None:
    """Slip is raised within 50 ms, and the only wheel ever named alone is the right one."""
    log = run(floor=ice_under(wheel, at), settings=BaseSettings(traction=traction))
    slipping = np.abs(log.slip) > SLIPS
    assert slipping[:, wheel].any()
    begins = int(slipping[:, wheel].argmax())
    raised = int((log.status[begins:] != SlipStatus.NO_SLIP).argmax())
    named = int((log.flagged[begins:] == wheel).argmax())
    assert raised <= 50
    assert log.status[begins + raised] != SlipStatus.NO_SLIP
    assert named <= 50
    assert log.flagged[begins + named] == wheel
    others = np.delete(slipping, wheel, axis=1).any(axis=1)
    assert set(log.flagged[: int(others.argmax()) if others.any() else None]) <= {-1, wheel}
    assert log.path_error.max() < 0.05
    assert f"wheel {wheel + 1} slips" in [event.text for event in log.events]


@pytest.mark.parametrize("narrow", [True, False], ids=["narrow", "wide"])
def test_a_name_is_a_wheel_that_slips(narrow: bool) -> None:
    """Ice anywhere on the way, under one wheel or several: hardly ever is a wheel named that did not just slip."""
    rng = np.random.default_rng(3 if narrow else 4)
    eight = plan_path(figure_of_eight(5.0), PathLimits(2.0, 2.5))
    wrong = named = alone = found = 0
    for _ in range(50):
        log = run(eight, floor=_ice_on_the_way(rng, eight, narrow))
        slip = np.abs(log.slip)
        recent = _lately(slip > 0.5 * SLIPS, 100)
        wrong += int((log.named & ~recent).any(axis=1).sum() > 5)
        named += int(log.named.any())
        for wheel in range(4):
            begins = int((slip[:, wheel] > SLIPS).argmax())
            if slip[begins, wheel] > SLIPS and not np.delete(recent[begins : begins + 150], wheel, axis=1).any():
                alone += 1
                found += bool(log.named[begins : begins + 51, wheel].any())
    assert wrong <= 2
    assert named >= 30
    assert found >= 0.6 * alone


def _ice_on_the_way(rng: np.random.Generator, path: ReferencePath, narrow: bool) -> Floor:
    at, wheel = int(rng.integers(500, len(path.time) - 500)), BASE.wheels[int(rng.integers(4))]
    length, width = (0.3, 0.05) if narrow else (float(rng.uniform(0.1, 0.6)), float(rng.uniform(0.03, 0.3)))
    place = path.pose[at, :2] + [wheel.x, wheel.y]
    angle = float(np.arctan2(path.twist[at, 1], path.twist[at, 0]))
    return Floor(CARPET, (RectangularPatch((place[0], place[1]), length, width, ICE, angle),))


def _lately(what: np.ndarray, samples: int) -> np.ndarray:
    """Whether it was so in any of the last samples."""
    count = np.cumsum(what, axis=0)
    before = np.vstack([np.zeros((samples, what.shape[1]), count.dtype), count[:-samples]])
    lately: np.ndarray = count - before > 0
    return lately


@pytest.mark.parametrize(("centre", "angle"), [((-0.986, 1.004), 144.04), ((-2.14, -1.205), -37.0)])
def test_a_name_ends_with_the_slip_of_its_wheel(centre: tuple[float, float], angle: float) -> None:
    """One wheel slips, then another: the residual changes its sign, and the first is not named any more."""
    eight = plan_path(figure_of_eight(5.0), PathLimits(2.0, 2.5), laps=2)
    log = run(eight, floor=Floor(CARPET, (RectangularPatch(centre, 0.3, 0.05, ICE, np.radians(angle)),)), seed=33)
    assert (np.abs(log.slip) > SLIPS).any()
    assert not (log.named & ~_lately(np.abs(log.slip) > 0.5 * SLIPS, 100)).any()


def test_a_dead_motor_is_not_slip() -> None:
    """The other wheels push harder and creep more; that is known of them."""
    eight = plan_path(figure_of_eight(5.0), PathLimits(2.0, 2.5))
    for wheel in range(4):
        log = run(eight, faults=[BaseFault(3.0, wheel)])
        quiet = ~_lately((np.abs(log.slip) > 0.5 * SLIPS).any(axis=1, keepdims=True), 100)[:, 0]
        assert (log.status[quiet] == SlipStatus.NO_SLIP).all()


@pytest.mark.parametrize(
    "sensors",
    [
        BaseSensors(gyro_noise=np.radians(3.0)),
        BaseSensors(gyro_bias=np.radians(0.5)),
        BaseSensors(gyro_bias=-np.radians(0.3), gyro_noise=np.radians(1.0), accelerometer_noise=0.5),
        BaseSensors(accelerometer_noise=1.0, accelerometer_bias=0.1),
    ],
)
def test_slip_detection_knows_its_sensors(sensors: BaseSensors) -> None:
    """Worse sensors raise no slip where there is none, and name no wheel that does not slip."""
    settings = slip_settings(sensors, DRIVE)
    assert settings.rate_noise >= sensors.gyro_noise
    assert settings.rate_bias >= abs(sensors.gyro_bias)
    assert settings.acceleration_error >= abs(sensors.accelerometer_bias)
    assert (run(settings=BaseSettings(sensors=sensors)).status == SlipStatus.NO_SLIP).all()
    for wheel, at in ((0, 1900), (1, 1300), (2, 1400), (3, 1250)):
        log = run(floor=ice_under(wheel, at), settings=BaseSettings(sensors=sensors))
        assert not (log.named & ~_lately(np.abs(log.slip) > 0.5 * SLIPS, 100)).any()
        assert (log.status != SlipStatus.NO_SLIP).any()


def test_the_log_says_what_the_batch_detector_says() -> None:
    """The loop feeds `slip_step` what `detect_slip` gets from the log, but for the learned zero of the gyro."""
    log = run(floor=ice_under(0, 1900))
    report = detect_slip(
        COUPLING, 0.02711 * log.measured_speeds, SLIP, rate=log.gyro,
        acceleration=np.column_stack([log.acceleration, np.full(len(log.time), np.nan)]),
    )  # fmt: skip
    assert (report.named == log.named).all(axis=1).mean() > 0.98
    np.testing.assert_allclose(report.residual, log.residuals, atol=1e-12)


def test_traction_control_limits_slip_and_gains_time() -> None:
    """Hard acceleration on a slippery floor: far less slip, and the first metre is done earlier."""
    path = plan_path([[0.0, 0.0], [1.5, 0.0], [3.0, 0.0]], PathLimits(2.0, 4.0))
    floor = Floor(Material(0.3, 0.12, 0.05))
    logs = [run(path, floor=floor, settings=BaseSettings(traction=t)) for t in (TractionSettings(), None)]
    metre = [float(log.time[int((log.pose[:, 0] > 1.0).argmax())]) for log in logs]
    assert metre[0] < 0.85 * metre[1]
    assert np.abs(logs[0].slip).max() < 0.3 * np.abs(logs[1].slip).max()


def test_traction_control_on_ice() -> None:
    with_control, without = (
        run(floor=ice_under(0, 1900), settings=BaseSettings(traction=t)) for t in (TractionSettings(), None)
    )
    assert np.abs(with_control.slip).max() < 0.5 * np.abs(without.slip).max()
    assert np.abs(with_control.heading_error).max() < 0.6 * np.abs(without.heading_error).max()


def test_odometry_leaves_the_slipping_wheel_out() -> None:
    seen, unseen = (
        run(floor=ice_under(0, 1900), settings=BaseSettings(traction=None, slip=slip)) for slip in (SLIP, None)
    )
    errors = [np.hypot(*(log.estimated_pose - log.pose)[-1, :2]) for log in (seen, unseen)]
    assert errors[0] < 0.6 * errors[1]
    assert not unseen.named.any()


@pytest.mark.parametrize("wheel", range(4))
def test_a_dead_motor_is_found_and_done_without(wheel: int) -> None:
    """Named within 100 ms while current is asked of it; the path is kept, slower where three motors need it."""
    fault = BaseFault(2.5, wheel)
    log = run(faults=[fault])
    assert (log.dead[-1] == (np.arange(4) == wheel)).all()
    assert log.time[int(log.dead[:, wheel].argmax())] - 2.5 < 0.1
    assert log.path_error.max() < 0.05
    assert np.abs(log.heading_error).max() < np.radians(6.0)
    assert 0.3 < log.rate[-1] < 1.0
    assert log.time[-1] > EIGHT.time[-1]
    np.testing.assert_allclose(log.reference_pose[-1], EIGHT.pose[-1], atol=1e-3)
    assert any(f"wheel {wheel + 1} does not do as told" in event.text for event in log.events)
    assert (log.currents[2501:, wheel] == 0.0).all()


@pytest.mark.parametrize("time", [0.0, 0.2])
@pytest.mark.parametrize("wheel", range(4))
def test_a_motor_that_is_dead_at_standstill_is_done_without(wheel: int, time: float) -> None:
    """Without current it is not jammed, though its wheel still stands: the base drives on."""
    log = run(faults=[BaseFault(time, wheel)])
    assert (log.dead[-1] == (np.arange(4) == wheel)).all()
    assert not log.jammed.any()
    assert log.ended == "done"
    assert log.rate[-1] > 0.3
    assert log.path_error.max() < 0.05


@pytest.mark.parametrize("size", [0.6, 50.0])
@pytest.mark.parametrize("centre", [(2.3, 1.0), (1.1, 0.6), (-1.4, 0.7)])
def test_no_motor_is_dead_on_ice(centre: tuple[float, float], size: float) -> None:
    """Wheels that stand while they are told to turn, current flowing, because others slip: none is jammed."""
    eight = plan_path(figure_of_eight(5.0), PathLimits(2.0, 2.5))
    for seed in range(3):
        log = run(eight, floor=Floor(CARPET, (RectangularPatch(centre, size, size),)), seed=seed)
        assert not log.dead.any()
        assert log.ended == "done"


@pytest.mark.parametrize("wheel", range(4))
@pytest.mark.parametrize("time", [1.0, 2.0, 3.0])
def test_a_jammed_wheel_is_found(wheel: int, time: float) -> None:
    """Only that one, though the base that it holds makes others stand."""
    log = run(faults=[BaseFault(time, wheel, "blocked")])
    assert (log.jammed[-1] == (np.arange(4) == wheel)).all()
    assert log.time[int(log.jammed[:, wheel].argmax())] - time < 0.5
    assert log.ended == "jammed"


def test_a_dead_motor_without_compensation() -> None:
    log = run(faults=[BaseFault(2.5, 1)])
    alone = run(faults=[BaseFault(2.5, 1)], settings=BaseSettings(watch=None))
    assert alone.path_error.max() > 3.0 * log.path_error.max()
    assert not alone.dead.any()


def test_a_jammed_wheel_stops_the_base() -> None:
    log = run(faults=[BaseFault(2.0, "wheel 1", "blocked")])
    assert log.dead[-1, 0]
    assert log.rate[-1] == 0.0
    assert (np.abs(log.twist[-1]) < [0.05, 0.05, 0.2]).all()
    assert log.time[-1] < EIGHT.time[-1]
    assert any("the base stops" in event.text for event in log.events)
    assert log.ended == "jammed"
    gone = np.hypot(*np.diff(log.reference_pose[:, :2], axis=0).T).sum()
    whole = np.hypot(*np.diff(EIGHT.pose[:, :2], axis=0).T).sum()
    assert log.driven == pytest.approx(gone / whole, abs=2e-3)
    assert log.events[-1].text == f"stopped with a jammed wheel after {100 * log.driven:.0f} % of the path"


def test_a_run_that_gets_too_slow_is_cut_off() -> None:
    """The motors that are left must not push as the path needs; the log says that it ends before it does, and where."""
    log = run(faults=[BaseFault(2.0, 0)], settings=BaseSettings(friction=0.01))
    assert log.ended == "cut off"
    assert len(log.time) >= 5 * len(EIGHT.time)
    assert 0.2 < log.driven < 0.9
    assert "cut off after" in log.events[-1].text
    gone = np.hypot(*np.diff(log.reference_pose[:, :2], axis=0).T).sum()
    whole = np.hypot(*np.diff(EIGHT.pose[:, :2], axis=0).T).sum()
    assert log.driven == pytest.approx(gone / whole, abs=2e-3)


def test_it_starts_in_motion() -> None:
    """A reference that starts at speed finds the base at that speed."""
    part = dataclasses.replace(
        EIGHT, time=EIGHT.time[2000:], pose=EIGHT.pose[2000:], twist=EIGHT.twist[2000:],
        acceleration=EIGHT.acceleration[2000:],
    )  # fmt: skip
    log = run(part)
    assert np.hypot(*part.twist[0, :2]) > 0.5
    assert log.path_error.max() < 0.04
    np.testing.assert_allclose(log.twist[0], part.twist[0], atol=1e-12)


def test_half_the_step_gives_the_same_motion() -> None:
    a, b = run(substeps=2), run(substeps=8)
    assert np.hypot(*(a.pose - b.pose)[:, :2].T).max() < 2e-3


def test_bad_input() -> None:
    with pytest.raises(UnknownName, match="wheel 9"):
        run(faults=[BaseFault(1.0, "wheel 9")])
    with pytest.raises(UnknownName, match="blocked"):
        BaseFault(1.0, 0, "melted")
    with pytest.raises(OutOfLimits, match="time"):
        BaseFault(-1.0, 0)
    with pytest.raises(OutOfLimits, match="Creep"):
        Creep(-1.0, 0.8)
    with pytest.raises(OutOfLimits, match="friction"):
        BaseSettings(friction=0.0)
