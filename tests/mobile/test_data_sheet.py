"""Runs and data sheet together: better than runs alone where the data sheet is right, and no worse where it is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.mobile.calibration import drive_parameters
from holonom.mobile.calibration.fitting.data_sheet import BATCH, EACH, FOREIGN, LENGTH, informed

P = drive_parameters("differential", {"wheelbase": 0.3, "diameter_left": 0.1, "diameter_right": 0.1})
"""Scaled by themselves: x are shares."""
seeds = st.integers(0, 2**32 - 1)


def tolerances() -> np.ndarray:
    Q = np.full((3, 3), 0.0)
    Q[1:, 1:] = BATCH**2
    return Q + np.diag([LENGTH, EACH, EACH]) ** 2


def covariance(rng: np.random.Generator, size: float) -> np.ndarray:
    root = size * rng.normal(size=(3, 3))
    return root @ root.T


@pytest.mark.parametrize("size", [1e-4, 2e-3, 1e-2])
def test_robots_that_are_as_data_sheets_say(size: float) -> None:
    """Errors are smaller, in the mean, than those of the runs alone, wherever runs tell less than the data sheet."""
    rng = np.random.default_rng(3)
    ours, alone = 0.0, 0.0
    for _ in range(400):
        truth = rng.multivariate_normal(np.zeros(3), tolerances())
        C = covariance(rng, size)
        x = rng.multivariate_normal(truth, C)
        error = informed(P, x, C)[0] - truth
        ours, alone = ours + error @ error, alone + (x - truth) @ (x - truth)
    assert ours < 1.01 * alone
    if size > 1e-3:
        assert ours < 0.7 * alone


@given(seed=seeds)
@settings(max_examples=30)
def test_another_robot_than_that_of_the_data_sheet(seed: int) -> None:
    """What runs tell surely is left alone where it contradicts the data sheet."""
    rng = np.random.default_rng(seed)
    x = 0.05 * rng.choice([-1.0, 1.0], 3) * rng.uniform(0.8, 1.2, 3)
    C = covariance(rng, 5e-4)
    found, doubt = informed(P, x, C)
    assert doubt > FOREIGN
    assert np.array_equal(found, x)


@given(seed=seeds)
@settings(max_examples=30)
def test_runs_that_tell_nothing_leave_the_data_sheet(seed: int) -> None:
    rng = np.random.default_rng(seed)
    found, _ = informed(P, 0.1 * rng.normal(size=3), np.eye(3))
    assert np.all(np.abs(found) < 0.1 * np.sqrt(np.diagonal(tolerances())) + 1e-3)


def test_numbers_that_no_data_sheet_has() -> None:
    steered = drive_parameters("tricycle", {"wheelbase": 0.3, "diameter": 0.1, "steering_offset": 0.0})
    C = np.diag([1e-4, 1e-4, 1e-3]) ** 2
    found, _ = informed(steered, np.array([0.0, 0.0, 0.2]), C)
    assert found[2] == pytest.approx(0.2)
