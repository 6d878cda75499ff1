"""A gyro's scale and zero from its rate beside a true heading."""

from __future__ import annotations

import numpy as np
import pytest

from holonom.errors import CalibrationError, NotFinite, ShapeError
from holonom.mobile.odometry import calibrate_gyro


def test_scale_and_bias_come_back_as_surely_as_they_say() -> None:
    normal = []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        t = 0.02 * np.arange(3000)
        heading = 2.0 * np.sin(0.4 * t) + np.sin(1.1 * t + rng.uniform(0.0, 6.0))
        true = np.diff(heading, prepend=heading[0]) / 0.02
        rate = 0.985 * true - 0.02 + 0.02 * rng.normal(size=len(t))
        found = calibrate_gyro(t, rate, heading)
        normal.append([(found.scale - 0.985) / found.scale_sigma, (found.bias + 0.02) / found.bias_sigma])
        assert found.scale == pytest.approx(0.985, abs=5e-3)
    inside = (np.abs(normal) < 2.0).mean()
    assert 0.90 <= inside <= 0.99


def test_motions_that_tell_nothing_and_wrong_rows() -> None:
    t = 0.02 * np.arange(1000)
    for rate, heading, problem, match in (
        (np.ones(1000), t, CalibrationError, "turns always alike"),
        (0.1 * np.random.default_rng(0).normal(size=1000), 1e-3 * np.sin(t), CalibrationError, "turns too little"),
        (np.ones(999), t, ShapeError, "give as many of each"),
        (np.full(1000, np.nan), t, NotFinite, "hold NaN"),
    ):
        with pytest.raises(problem, match=match):
            calibrate_gyro(t, rate, heading)
    with pytest.raises(CalibrationError, match=r"0\.98 s of a gyro came"):
        calibrate_gyro(t[:50], np.ones(50), t[:50])
