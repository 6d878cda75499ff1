"""Intervals of two deviations hold the true numbers of any arrangement: a hundred logs each, with slip and noise."""

from __future__ import annotations

import numpy as np
import pytest
from base_runs import BASES, log_of

from holonom.mobile.calibration import calibrate, derived_parameters
from holonom.mobile.calibration.fitting.pieces import prepared
from holonom.mobile.calibration.fitting.residuals import Problem, path_lever
from holonom.mobile.calibration.fitting.uncertainty import noise_covariance

NOISE = {"slip": 0.002, "place": 0.0005, "heading": 0.001, "ticks": 4096}


@pytest.mark.parametrize("kind", BASES)
def test_intervals_hold_over_a_hundred_logs(kind: str) -> None:
    """One step of least squares from the truth, which is as good as all of them; another path in each log."""
    base = BASES[kind]
    parameters, held = derived_parameters(base), []
    for seed in range(300 if kind == "sphere" else 100):
        rng = np.random.default_rng(seed)
        truth = parameters.nominal + 0.02 * parameters.scale * rng.uniform(-1.0, 1.0, len(parameters.names))
        run = log_of(base, dict(zip(parameters.names, truth, strict=True)), rng, samples=200, **NOISE)
        problem = Problem((run,), parameters, "exact", path_lever([run]), 1.0)
        x = (truth - parameters.nominal) / parameters.scale
        problem = prepared(problem, x)
        r, J = problem.residuals(x)
        step = -np.linalg.lstsq(J, r, rcond=None)[0]
        deviations = np.sqrt(np.diagonal(noise_covariance(problem.parts(x), None, problem.tightness)))
        held.append(np.abs(step) < 2.0 * deviations)
    assert 0.90 <= np.mean(held) <= 0.99


@pytest.mark.parametrize("kind", ["ackermann", "mecanum", "skid_steer"])
def test_a_whole_calibration_gives_the_wheels_back(kind: str) -> None:
    base = BASES[kind]
    parameters = derived_parameters(base)
    rng = np.random.default_rng(7)
    truth = parameters.nominal + 0.02 * parameters.scale * rng.uniform(-1.0, 1.0, len(parameters.names))
    numbers = dict(zip(parameters.names, truth, strict=True))
    runs = [log_of(base, numbers, rng, name=f"run-{j}", **NOISE) for j in range(2)]
    found = calibrate(runs, base, rule="exact")
    assert np.all(np.abs(found.values - truth) < 3.5 * found.deviations)
    assert np.all(found.deviations < 0.05 * parameters.scale)
    assert found.after.distance < found.before.distance
