"""Calibration by logs as they are: a marker beside the base, clocks that differ, slip that adds up."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_runs import NOMINAL, values, wandering
from scipy.interpolate import CubicSpline

from holonom.app.odometry_log import read_log
from holonom.mobile.calibration import Run, calibrate, clear_clock, drive_parameters, on_the_clock_of_the_wheels

MARKER = np.array([0.2013, 0.08405, 0.08395, 0.08, 0.008, 0.05])


def _pairs(turns: np.ndarray) -> np.ndarray:
    """Turns of every second sample, with those of the one before."""
    summed = np.cumsum(turns, axis=0)[::2]
    return np.diff(summed, axis=0, prepend=summed[:1])


def test_deviations_of_sixty_sets_with_a_marker_beside_the_base() -> None:
    """Estimates scatter as much as they say, and around the truth, with slip and a noisy truth: z of 60 sets."""
    rng = np.random.default_rng(5)
    z = []
    for k in range(60):
        runs = []
        for j in range(1):
            run = wandering("differential", MARKER, "extended", seed=1000 + 10 * k + j, way=0.5, noise=0.002)
            run = Run(run.name, run.time[::2], _pairs(run.turns), run.truth[::2], run.steering[::2])
            seen = run.truth + rng.normal(size=run.truth.shape) * [0.002, 0.002, 0.003]
            runs.append(replace(run, truth=seen))
        found = calibrate(runs, "differential", NOMINAL["differential"], set_name="extended", data_sheet=False)
        z.append((found.values - MARKER) / found.deviations)
    assert 0.8 < np.std(z) < 1.2
    assert np.all(np.abs(np.mean(z, axis=0)) < 0.5)
    assert np.all((np.std(z, axis=0) > 0.65) & (np.std(z, axis=0) < 1.5))


@pytest.mark.parametrize("late", [-0.73, -0.13, 0.21, 1.4])
def test_a_clock_that_is_late_is_found_and_put_right(late: float) -> None:
    """The truth as another clock saw it; afterwards the calibration is that of a log whose clocks agree."""
    run = wandering("differential", MARKER, "extended", seed=4, way=0.5)
    fine = CubicSpline(run.time, np.column_stack([run.truth[:, :2], run.heading]))
    inner = slice(40, -40)
    parts = (run.time[inner], run.turns[inner], fine(run.time[inner] - late), run.steering[inner])
    shifted, nominal = Run("late", *parts), drive_parameters("differential", NOMINAL["differential"])
    found = clear_clock(shifted, nominal.matrix(nominal.nominal))
    assert found.late == pytest.approx(late, abs=0.02)
    assert abs(found.rate) < 1e-3
    right = on_the_clock_of_the_wheels(shifted, found)
    assert clear_clock(run, nominal.matrix(nominal.nominal)) == (0.0, 0.0)
    values = calibrate([right], "differential", NOMINAL["differential"], set_name="extended").values
    np.testing.assert_allclose(values[:3], MARKER[:3], rtol=1e-3)


@pytest.mark.parametrize(("late", "rate"), [(0.0, 0.02), (0.3, -0.012), (-0.4, 0.006)])
def test_a_clock_that_runs_fast_is_found_and_put_right(late: float, rate: float) -> None:
    """The rate of another clock is neither an offset nor slip; the numbers are those of the robot."""
    run = wandering("differential", MARKER, "extended", seed=4, way=0.5)
    fine = CubicSpline(run.time, np.column_stack([run.truth[:, :2], run.heading]))
    inner = slice(40, -40)
    time = run.time[inner]
    seen = fine(time - late - rate * (time - time.mean()))  # when the truth says `time`, that is what it saw
    shifted, nominal = Run("fast", time, run.turns[inner], seen, run.steering[inner]), NOMINAL["differential"]
    matrix = drive_parameters("differential", nominal).matrix(values(nominal))
    found = clear_clock(shifted, matrix)
    assert found.late == pytest.approx(late, abs=0.03)
    assert found.rate == pytest.approx(rate, abs=1e-3)
    for logged in (shifted, on_the_clock_of_the_wheels(shifted, found)):
        got = calibrate([logged], "differential", nominal, set_name="extended").values
        np.testing.assert_allclose(got[:3], MARKER[:3], rtol=1e-3)


def test_slip_that_adds_up_leaves_the_wheels_as_they_are() -> None:
    """Two runs on a slippery floor, eight times: pieces tell the wheels to 2 %, and honestly."""
    truth = np.array([0.42, 0.0667, 0.0669, 0.0664, 0.0665])
    rng, z, deviations = np.random.default_rng(2), [], []
    for k in range(8):
        runs = []
        for j in range(2):
            run = wandering("mecanum", truth, "physical", seed=50 * k + j, way=0.5, noise=0.003)
            runs.append(replace(run, truth=run.truth + rng.normal(size=run.truth.shape) * [5e-4, 5e-4, 1e-3]))
        found = calibrate(runs, "mecanum", NOMINAL["mecanum"])
        deviations.append(found.deviations / truth)
        z.append((found.values - truth) / found.deviations)
    assert 0.6 < np.sqrt(np.mean(np.square(z))) < 1.4
    assert np.mean(deviations) < 0.025  # whole paths: 0.045


def test_wheels_of_a_published_mecanum_robot_are_alike(data_folder: Path) -> None:
    """Regression of motions over one second (numpy, by another hand) gives 66.7, 66.9, 66.4, 66.5 mm, +-0.5 mm."""
    log = read_log([data_folder / "odometry" / "optiodom" / "omni4"])
    found = calibrate(log.runs, log.drive, log.nominal)
    np.testing.assert_allclose(found.values[1:], [0.0667, 0.0669, 0.0664, 0.0665], atol=1.5e-3)
    assert np.all(found.deviations[1:] < 7e-4)


def test_a_small_offset_is_found_with_the_parameters() -> None:
    run = wandering("differential", MARKER, "extended", seed=4, way=0.5)
    fine = CubicSpline(run.time, np.column_stack([run.truth[:, :2], run.heading]))
    inner = slice(20, -20)
    parts = (run.time[inner], run.turns[inner], fine(run.time[inner] - 0.02), run.steering[inner])
    found = calibrate([Run("late", *parts)], "differential", NOMINAL["differential"], set_name="extended")
    assert found.clocks[0] == pytest.approx(0.02, abs=5e-3)


@pytest.mark.parametrize("yaw", [0.6, 1.3, -2.5, 3.1])
def test_a_marker_may_be_turned_by_any_angle(yaw: float) -> None:
    truth = np.array([*MARKER[:3], -0.12, 0.2, yaw])
    run = wandering("differential", truth, "extended", seed=4, way=0.5)
    found = calibrate([run], "differential", NOMINAL["differential"], set_name="extended")
    np.testing.assert_allclose(found.values[:5], truth[:5], rtol=1e-5)
    assert np.exp(1j * found.values[5]) == pytest.approx(np.exp(1j * yaw), abs=1e-5)
