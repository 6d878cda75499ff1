"""Optical odometry: what sensors under a rigid base must see, back to its motion; their calibration."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.errors import CalibrationError, ModelError, ShapeError
from holonom.mobile.odometry import OpticalSensor, calibrate_optical, optical_increments

seeds = st.integers(0, 2**32 - 1)


def seen(sensor: OpticalSensor, increments: np.ndarray) -> np.ndarray:
    """Counts of a sensor: velocity of its place, turned into its frame, by complex numbers."""
    way = (increments[:, 0] + 1j * increments[:, 1]) + 1j * increments[:, 2] * (sensor.x + 1j * sensor.y)
    own = way * np.exp(-1j * sensor.angle) / sensor.scale
    return np.stack([own.real, own.imag], axis=1)


def some_sensor(rng: np.random.Generator) -> OpticalSensor:
    return OpticalSensor(*rng.uniform(-0.2, 0.2, 2), rng.uniform(-3.0, 3.0), rng.uniform(0.5, 2.0) * 1e-4)


@given(seeds, st.integers(2, 4))
def test_two_or_more_sensors_tell_the_motion(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    sensors, motion = [some_sensor(rng) for _ in range(count)], 0.01 * rng.normal(size=(30, 3))
    found = optical_increments(sensors, np.stack([seen(s, motion) for s in sensors], axis=1))
    assert np.allclose(found.increments, motion, atol=1e-9)
    assert np.allclose(found.residual, 0.0, atol=1e-9)


@given(seeds)
def test_one_sensor_and_a_gyro_tell_it_too(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sensor, motion = some_sensor(rng), 0.01 * rng.normal(size=(30, 3))
    found = optical_increments([sensor], seen(sensor, motion)[:, None], turns=motion[:, 2])
    assert np.allclose(found.increments, motion, atol=1e-9)


@given(seeds)
def test_calibration_finds_the_sensor(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sensor, motion = some_sensor(rng), 0.01 * rng.normal(size=(200, 3))
    found = calibrate_optical(OpticalSensor(0.0, 0.0), seen(sensor, motion), motion)
    assert np.allclose([found.x, found.y, found.scale], [sensor.x, sensor.y, sensor.scale], atol=1e-9)
    assert np.exp(1j * found.angle) == pytest.approx(np.exp(1j * sensor.angle))


def test_a_straight_way_tells_scale_and_angle_only() -> None:
    sensor = OpticalSensor(0.1, -0.05, 0.4, 2e-4)
    motion = np.tile([0.01, 0.0, 0.0], (50, 1))
    found = calibrate_optical(OpticalSensor(0.12, -0.04, 0.0, 1e-4), seen(sensor, motion), motion)
    assert (found.x, found.y) == (0.12, -0.04)  # as it was believed
    assert (found.angle, found.scale) == pytest.approx((0.4, 2e-4))


def test_a_slipping_sensor_shows_in_the_residual() -> None:
    sensors = [OpticalSensor(0.1, 0.0), OpticalSensor(-0.1, 0.0)]
    counts = np.stack([seen(s, np.array([[0.01, 0.0, 0.0]])) for s in sensors], axis=1)
    counts[0, 0, 0] += 0.004
    assert np.abs(optical_increments(sensors, counts).residual).max() == pytest.approx(0.002)


def test_what_cannot_be_told_is_refused() -> None:
    sensor = OpticalSensor(0.1, 0.0)
    for call, problem, match in (
        (lambda: optical_increments([], np.zeros((1, 0, 2))), ModelError, "no optical sensor"),
        (lambda: optical_increments([sensor], np.zeros((1, 1, 2))), ModelError, "give turns too"),
        (lambda: optical_increments([sensor, sensor], np.zeros((1, 2, 2))), ModelError, "one place"),
        (lambda: optical_increments([sensor], np.zeros((1, 2))), ShapeError, "counts have shape"),
        (lambda: optical_increments([sensor], np.zeros((1, 1, 2)), turns=[0.0, 1.0]), ShapeError, "turns"),
        (lambda: calibrate_optical(sensor, np.zeros((5, 2)), np.ones((5, 3))), CalibrationError, "counted nothing"),
        (lambda: calibrate_optical(sensor, np.ones((5, 2)), np.zeros((5, 3))), CalibrationError, "did not move"),
        (lambda: calibrate_optical(sensor, np.ones((4, 2)), np.zeros((5, 3))), ShapeError, "counts"),
    ):
        with pytest.raises(problem, match=match):
            call()
