"""Runs that noise does not explain count as noisier: expectations by repetition, deviations where one differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from calibration_runs import NOMINAL, values, wandering

from holonom.mobile.calibration import Run, calibrate, drive_parameters
from holonom.mobile.calibration.clocks import clock_of
from holonom.mobile.calibration.fitting.noise import Noise, misfit
from holonom.mobile.calibration.fitting.residuals import SURE, Problem
from holonom.mobile.odometry import integrate

DRIVE, TRUTH = "differential", values(NOMINAL["differential"])
PARAMETERS = drive_parameters(DRIVE, NOMINAL[DRIVE])


@pytest.mark.parametrize(
    "q",
    [
        Noise(4e-8, 0.0, 0.0, 0.0), Noise(0.0, 4e-8, 0.0, 0.0), Noise(0.0, 0.0, 1e-6, 1e-6),
        Noise(1e-7, 3e-7, 1e-7, 4e-7),
    ],
)  # fmt: skip
@pytest.mark.parametrize("sure", [[SURE] * 4, [0.0] * 4, [2.0, 2.0, 0.3, 0.05]])
def test_noise_explains_what_repetition_shows(q: Noise, sure: list[float]) -> None:
    """Runs slip two hundred times: their square error is, in the mean, a hundred times what a hundredth explains."""
    rng = np.random.default_rng(6)
    run = wandering(DRIVE, TRUTH, "physical", seed=2, way=0.5)
    motions = run.turns @ PARAMETERS.matrix(TRUTH).T
    way = np.sqrt(np.abs(run.turns).mean(axis=1))[:, None]
    a, b, c, d = np.sqrt(q)
    times = []
    for _ in range(200):
        truth = integrate(motions + way * rng.normal(size=motions.shape) * [a, a, b])
        seen = replace(run, truth=truth + rng.normal(size=truth.shape) * [c, c, d])
        problem = Problem((seen,), PARAMETERS, "midpoint", 1.0, 1.0, np.array([sure]))
        times.append(misfit(problem.parts(np.zeros(3)), Noise(*(0.01 * value for value in q)))[0])
    assert np.mean(times) == pytest.approx(100.0, abs=4.0 * np.std(times) / np.sqrt(200) + 2.0)


def course(turns: list[float], samples: int, slip: float, rng: np.random.Generator, name: str) -> Run:
    """Wheels that turn evenly, a base that slips."""
    rows = np.tile(turns, (samples, 1))
    rows[0] = 0.0
    moved = rows @ PARAMETERS.matrix(TRUTH).T
    moved[1:] += slip * np.sqrt(np.abs(turns).mean()) * rng.normal(size=(samples - 1, 3))
    poses = integrate(moved) + rng.normal(size=moved.shape) * [3e-4, 3e-4, 1e-3]
    return Run(name, 0.05 * np.arange(samples), rows, poses, np.empty((samples, 0)))


def test_an_even_turn_tells_no_clock() -> None:
    """With noise, a clock that stands still explains it: motions that never change."""
    for seed in range(60):
        run = course([-0.1, 0.1], 80, 0.01, np.random.default_rng(seed), "left")
        late, rate = clock_of(run, PARAMETERS.matrix(TRUTH))
        assert abs(late) < 1.5
        assert abs(rate) < 0.05


def test_wheels_that_scrub_on_the_spot_only() -> None:
    """A line and two turns that slip twenty times as much: the wheelbase is as far off as its deviation says."""
    away = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        runs = [
            course([0.12, 0.12], 400, 0.002, rng, "line"),
            course([-0.1, 0.1], 80, 0.04, rng, "left"),
            course([0.1, -0.1], 80, 0.04, rng, "right"),
        ]
        found = calibrate(runs, DRIVE, NOMINAL[DRIVE], data_sheet=False)
        away.append((found.values[0] - TRUTH[0]) / found.deviations[0])
    assert np.mean(np.abs(away) < 2.0) >= 0.85
    assert 0.7 < np.std(away) < 1.3  # by the noise of all runs together: 60 % within two deviations, 2.5
