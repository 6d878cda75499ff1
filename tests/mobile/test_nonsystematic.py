"""What no calibration takes away: the scatter of ends about their course's mean, and what bumps add."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from holonom.errors import CalibrationError
from holonom.mobile.calibration import Run, end_scatter
from holonom.mobile.odometry import integrate

M = np.array([[0.5, 0.5], [0.0, 0.0], [-5.0, 5.0]])


def run(name: str, sense: int, end: np.ndarray) -> Run:
    """A half circle whose truth ends beside odometry's by (x, y, heading) in the frame of its start, turned by 0.7."""
    turns = np.tile([0.02 - 0.001 * sense, 0.02 + 0.001 * sense], (100, 1))
    turns[0] = 0.0
    poses = integrate(turns @ M.T, start=[0.3, -0.2, 0.7])
    c, s = np.cos(0.7), np.sin(0.7)
    off = np.array([c * end[0] - s * end[1], s * end[0] + c * end[1], end[2]])
    return Run(name, 0.1 * np.arange(100), turns, poses + np.linspace(0.0, 1.0, 100)[:, None] * off, np.empty((100, 0)))


def test_scatter_is_that_of_the_ends_about_the_means_of_their_courses() -> None:
    rng = np.random.default_rng(0)
    ends = {1: rng.normal(size=(40, 3)) * [0.01, 0.02, 0.03], -1: rng.normal(size=(40, 3)) * [0.01, 0.02, 0.03]}
    shift = {1: np.array([0.05, 0.0, 0.02]), -1: np.array([-0.02, 0.03, 0.0])}  # systematic, another each way
    runs = [run(f"{sense}-{k}", sense, e + shift[sense]) for sense in (1, -1) for k, e in enumerate(ends[sense])]
    found = end_scatter(runs, M)
    assert found.courses == (0,) * 40 + (1,) * 40
    expected = sum(np.cov(e.T) * 39.0 for e in ends.values()) / 78.0
    assert found.covariance == pytest.approx(expected, rel=1e-6, abs=1e-9)
    assert found.spread == pytest.approx(np.sqrt(expected[0, 0] + expected[1, 1]))
    assert found.common[0] == pytest.approx(ends[1].mean(0) + shift[1], abs=1e-9)
    assert np.isnan(found.bump)


def test_bumps_are_read_against_runs_without() -> None:
    plain = [run(f"plain {s}{k}", s, np.array([0.0, 0.0, 0.01 * k])) for s in (1, -1) for k in range(3)]
    rough = [run(f"rough {s}", s, np.array([0.1, 0.1, 0.2 * s])) for s in (1, -1)]
    found = end_scatter(plain + rough, M, bumped=[r.name for r in rough])
    assert found.bump == pytest.approx(abs(0.2 - 0.01) + abs(-0.2 - 0.01))
    assert found.spread == pytest.approx(0.0, abs=1e-12)  # runs over bumps are not in it


def test_refusals_and_lone_runs() -> None:
    lone = run("lone", 1, np.zeros(3))
    assert np.isnan(end_scatter([lone], M).spread)
    with pytest.raises(CalibrationError, match="runs lone went over bumps and none of that course did not"):
        end_scatter([lone], M, bumped=["lone"])
    with pytest.raises(CalibrationError, match="no run came"):
        end_scatter([], M)
    with pytest.raises(CalibrationError, match="no ground truth"):
        end_scatter([replace(lone, truth=np.empty((0, 3)))], M)
