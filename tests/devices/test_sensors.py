"""Tachometer, current, inertial and force sensors; contact force by torques."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from holonom.devices import (
    CurrentSensor,
    ForceSensor,
    Imu,
    Tachometer,
    allan_deviation,
    contact_force,
    current_reading,
    drift_step,
    fit_crosstalk,
    fit_tool,
    tachometer_step,
)
from holonom.errors import CalibrationError, HolonomError, ModelError, NotAPose, NotFinite, OutOfLimits, ShapeError

G = np.array([0.0, 0.0, -9.81])
seeds = st.integers(0, 2**32 - 1)


# Tachometer


@pytest.mark.parametrize("speed", [-300.0, -20.0, 5.0, 100.0])
def test_a_tachometer_reads_the_speed_with_its_filtered_ripple(speed: float) -> None:
    sheet, dt = Tachometer(0.07, 0.02, 22, 1e-3), 1e-6
    params, filtered, read = sheet.params(dt), 0.0, []
    for k in range(int(math.tau / 22 / abs(speed) / dt) * 3 + 10_000):
        found, filtered = tachometer_step(params, filtered, speed * k * dt, speed, 0.0)
        read.append(found / sheet.gain)
    last = np.array(read[-int(2 * math.tau / 22 / abs(speed) / dt) :])
    assert last.mean() == pytest.approx(speed, rel=1e-3)
    assert 0.5 * np.ptp(last) == pytest.approx(sheet.ripple_at(speed), rel=2e-3)


def test_a_tachometer_is_late_by_its_filter() -> None:
    sheet, dt = Tachometer(0.07, 0.0, 22, 2e-3), 1e-5
    params, filtered, found = sheet.params(dt), 0.0, 0.0
    for k in range(5000):
        found, filtered = tachometer_step(params, filtered, 0.0, 1000.0 * k * dt, 0.0)
    assert 1000.0 * 4999 * dt - found / 0.07 == pytest.approx(1000.0 * sheet.delay, rel=0.01)


# Current


@given(
    current=st.floats(-10.0, 10.0),
    white=st.floats(-3.0, 3.0),
    offset=st.floats(-0.5, 0.5),
    gain=st.floats(-0.1, 0.1),
    resolution=st.one_of(st.just(0.0), st.floats(1e-7, 0.3)),
)
def test_a_settled_current_is_read_within_its_error(
    current: float, white: float, offset: float, gain: float, resolution: float
) -> None:
    sensor = CurrentSensor(20.0, 0.05, offset, gain, resolution)
    found, _ = current_reading(sensor.params(1e-4), 0.0, current, white)
    assert abs(found - current) <= sensor.error(current) * (1.0 + 1e-12) + 1e-12
    if resolution > 1e-3:
        assert abs(found / resolution - round(found / resolution)) < 1e-6


def test_the_current_filter_is_exact_and_the_range_ends() -> None:
    sensor = CurrentSensor(5.0, lag=2e-3)
    for dt in (1e-5, 1e-4, 1e-3):
        params, filtered, found = sensor.params(dt), 0.0, 0.0
        for _ in range(round(3e-3 / dt)):
            found, filtered = current_reading(params, filtered, 4.0, 0.0)
        assert found == pytest.approx(4.0 * (1.0 - math.exp(-1.5)), rel=1e-9)
    for side in (-1.0, 1.0):
        assert current_reading(CurrentSensor(5.0).params(1e-4), 0.0, 9.0 * side, 0.0)[0] == 5.0 * side


# IMU


def test_an_imu_at_rest_has_the_allan_deviation_of_its_sheet() -> None:
    imu, dt, n = Imu(gyro_noise=1e-3, gyro_walk=2e-3, accelerometer_noise=2e-2, accelerometer_walk=5e-2), 0.01, 400_000
    read = imu.measure(np.zeros((n, 3)), np.zeros((n, 3)), dt, np.random.default_rng(7))
    for data, noise, walk in ((read.rate, 1e-3, 2e-3), (read.force, 2e-2, 5e-2)):
        for size in (5, 40, 400):
            means = data[: n - n % size].reshape(-1, size, 3).mean(axis=1)
            found = math.sqrt(0.5 * float((np.diff(means, axis=0) ** 2).mean()))
            # of sampled data: the walk has stood still over each sample
            assert found == pytest.approx(allan_deviation(noise, walk, size * dt), rel=0.06)


@given(seed=seeds, scale=st.floats(-0.5, 0.5))
def test_an_imu_is_its_step_axis_by_axis(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    imu = Imu(gyro_bias=(0.1, -0.2, 0.3), gyro_scale=scale, accelerometer_scale=-scale, gyro_walk=0.1)
    rate, force = rng.normal(size=(2, 20, 3))
    read = imu.measure(rate, force, 0.01, np.random.default_rng(seed))
    white, steps = np.random.default_rng(seed).standard_normal((2, 20, 6))
    for axis in range(6):
        params = imu.gyro_params(0.01) if axis < 3 else imu.accelerometer_params(0.01)
        bias = (*imu.gyro_bias, *imu.accelerometer_bias)[axis]
        for k in range(20):
            assert read.bias[k, axis] == pytest.approx(bias, abs=1e-12)
            truth = np.concatenate([rate, force], axis=1)[k, axis]
            found, bias = drift_step(params, bias, truth, white[k, axis], steps[k, axis])
            assert np.concatenate(read[:2], axis=1)[k, axis] == pytest.approx(found, abs=1e-12)


def test_an_imu_without_errors_reads_the_truth() -> None:
    imu = Imu(0.0, 0.0, accelerometer_noise=0.0, accelerometer_walk=0.0)
    rate, force = np.random.default_rng(1).normal(size=(2, 50, 3))
    read = imu.measure(rate, force, 1e-3, np.random.default_rng(2))
    np.testing.assert_array_equal(read.rate, rate)
    np.testing.assert_array_equal(read.force, force)


# Force


def matrix(rng: np.random.Generator, part: float = 0.05) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in (np.eye(6) + part * rng.uniform(-1.0, 1.0, (6, 6))).tolist())


@given(seed=seeds)
def test_a_wrench_comes_back_through_crosstalk_and_bias(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bias = tuple(rng.normal(size=6).tolist())
    sensor = ForceSensor(0.0, 0.0, bias, matrix(rng))  # type: ignore[arg-type]
    truth = 30.0 * rng.normal(size=(4, 5, 6))
    read = sensor.measure(truth, rng)
    np.testing.assert_allclose(sensor.wrench(read), truth, atol=1e-9)
    np.testing.assert_allclose(
        sensor.wrench(read, np.zeros(6)), truth + np.linalg.solve(sensor.matrix, bias), atol=1e-9
    )


@given(seed=seeds, poses=st.integers(7, 30))
def test_crosstalk_is_found_from_known_loads(seed: int, poses: int) -> None:
    rng = np.random.default_rng(seed)
    sensor = ForceSensor(0.0, 0.0, tuple(rng.normal(size=6).tolist()), matrix(rng))  # type: ignore[arg-type]
    loads = rng.normal(size=(poses, 6)) * [50.0, 50.0, 50.0, 2.0, 2.0, 2.0]
    loads[:6] += np.diag([200.0, 200.0, 200.0, 9.0, 9.0, 9.0])
    found = fit_crosstalk(loads, sensor.measure(loads, rng))
    np.testing.assert_allclose(found.matrix, sensor.matrix, atol=1e-8)
    np.testing.assert_allclose(found.bias, sensor.bias, atol=1e-7)


def hung(
    rng: np.random.Generator, poses: int, mass: float, centre: np.ndarray, sensor: ForceSensor, gravity: np.ndarray = G
) -> tuple[np.ndarray, np.ndarray]:
    """Orientations, and decoupled readings of a tool that hangs there; every particle of it by itself."""
    R = Rotation.random(poses, random_state=int(rng.integers(2**31))).as_matrix()
    offsets = rng.normal(size=(5, 3)) * 0.05
    offsets -= offsets.mean(axis=0)
    wrenches = np.zeros((poses, 6))
    for offset in offsets:
        pull = np.einsum("nji,j->ni", R, gravity) * mass / 5
        wrenches += np.concatenate([pull, np.cross(centre + offset, pull)], axis=1)
    return R, sensor.wrench(sensor.measure(wrenches, rng), np.zeros(6))


@given(seed=seeds, poses=st.integers(4, 12), mass=st.floats(0.1, 20.0))
def test_a_tool_is_found_from_four_poses(seed: int, poses: int, mass: float) -> None:
    rng = np.random.default_rng(seed)
    R, read = hung(
        rng, poses, mass, (centre := 0.1 * rng.normal(size=3)), ForceSensor(0.0, 0.0, (3.0, -2.0, 5.0, 0.1, 0.2, -0.3))
    )
    spread = np.linalg.svd(R[:, 2] - R[:, 2].mean(axis=0))[1]
    try:
        found = fit_tool(R, read, gravity=G)
    except CalibrationError:
        assert spread[1] < 0.1
        return
    assert found.mass == pytest.approx(mass, rel=1e-6)
    np.testing.assert_allclose(found.centre, centre, atol=1e-6)
    np.testing.assert_allclose(found.bias, [3.0, -2.0, 5.0, 0.1, 0.2, -0.3], atol=1e-5)
    contact = np.array([1.0, 2.0, 3.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(found.contact(R, read + contact), np.broadcast_to(contact, read.shape), atol=1e-5)


def test_errors_of_a_tool_are_what_they_say() -> None:
    """1,000 calibrations with noise: what each is off by, over the error it states, has a deviation of 1."""
    rng, centre = np.random.default_rng(3), np.array([0.01, -0.02, 0.08])
    sensor = ForceSensor(0.2, 0.01, (1.0, 2.0, 3.0, 0.1, 0.2, 0.3))
    off = []
    for _ in range(1000):
        R, read = hung(rng, 12, 1.5, centre, sensor)
        found = fit_tool(R, read, gravity=G)
        off.append(
            [
                (found.mass - 1.5) / found.mass_error,
                *((found.centre - centre) / found.centre_error),
                *((found.bias - sensor.bias) / found.bias_error),
            ]
        )
    np.testing.assert_allclose(np.mean(off, axis=0), 0.0, atol=0.15)
    np.testing.assert_allclose(np.std(off, axis=0), 1.0, atol=0.12)
    assert found.force_noise == pytest.approx(0.2, rel=0.5)


def test_no_tool_has_no_centre() -> None:
    rng = np.random.default_rng(5)
    R, read = hung(rng, 8, 0.0, np.zeros(3), ForceSensor(0.2, 0.01))
    found = fit_tool(R, read, gravity=G)
    assert abs(found.mass) < 3.0 * found.mass_error
    assert np.isinf(found.centre_error).all()
    np.testing.assert_array_equal(found.centre, 0.0)


# Contact


@given(seed=seeds, n=st.integers(3, 8), m=st.sampled_from([3, 6]))
def test_a_contact_is_told_within_its_error(seed: int, n: int, m: int) -> None:
    if m > n:
        return
    rng = np.random.default_rng(seed)
    J, wrench, model = rng.normal(size=(m, n)), 20.0 * rng.normal(size=m), 10.0 * rng.normal(size=n)
    error = rng.uniform(0.0, 2.0, n)
    exact = contact_force(J, model + J.T @ wrench, model, np.zeros(n))
    np.testing.assert_allclose(exact.wrench, wrench, rtol=1e-6, atol=1e-6)
    assert exact.residual < 1e-8
    np.testing.assert_array_equal(exact.error, 0.0)
    found = contact_force(J, model + J.T @ wrench + error * rng.uniform(-1.0, 1.0, n), model, error)
    assert (np.abs(found.wrench - wrench) <= found.error * (1.0 + 1e-9) + 1e-9).all()
    worst = np.sign(np.linalg.pinv(J.T)[0]) * error
    found = contact_force(J, model + J.T @ wrench + worst, model, error)
    assert found.wrench[0] - wrench[0] == pytest.approx(found.error[0], rel=1e-6)
    if n > m:  # torques that no wrench at this point gives
        other = np.linalg.svd(J)[2][-1]
        found = contact_force(J, model + J.T @ wrench + 3.0 * other, model, error)
        np.testing.assert_allclose(found.wrench, wrench, rtol=1e-6, atol=1e-6)
        assert found.residual == pytest.approx(3.0 * np.abs(other).max(), rel=1e-6)


EYE = np.broadcast_to(np.eye(3), (4, 3, 3))
TURNED = Rotation.random(4, random_state=1).as_matrix()
SIX = tuple(tuple(0.0 for _ in range(6)) for _ in range(6))


@pytest.mark.parametrize(
    ("make", "error", "named"),
    [
        (lambda: Tachometer(0.0), ModelError, "gain is 0"),
        (lambda: Tachometer(0.07).params(0.0), ModelError, "dt is 0"),
        (lambda: Tachometer(0.07).ripple_at(math.nan), ModelError, "speed is nan"),
        (lambda: CurrentSensor(-1.0), ModelError, "most is -1"),
        (lambda: CurrentSensor(1.0, resolution=2.0), ModelError, "resolution is 2"),
        (lambda: CurrentSensor(1.0, resolution=1e-12), ModelError, "resolution is 1e-12; over 1 A"),
        (lambda: CurrentSensor(1.0).error(1.5), ModelError, "current is 1.5; it must be finite and at most 1"),
        (lambda: CurrentSensor(1.0).params(-1.0), ModelError, "dt is -1"),
        (lambda: Imu(gyro_noise=-1.0), ModelError, "gyro_noise is -1"),
        (lambda: Imu(gyro_bias=(0.0, math.nan, 0.0)), ModelError, "gyro_bias is nan"),
        (lambda: Imu().gyro_params(0.0), ModelError, "dt is 0"),
        (lambda: Imu().measure(np.zeros((2, 3)), np.zeros((3, 3)), 0.1, np.random.default_rng()), ShapeError, "force"),
        (lambda: Imu().measure([[0, 0, math.inf]], [[0, 0, 0]], 0.1, np.random.default_rng()), NotFinite, "rate"),
        (lambda: allan_deviation(1.0, 1.0, 0.0), ModelError, "time is 0"),
        (lambda: ForceSensor(-0.1), ModelError, "force_noise is -0.1"),
        (lambda: ForceSensor(crosstalk=SIX), ModelError, "condition number"),  # type: ignore[arg-type]
        (lambda: ForceSensor().wrench(np.zeros(5)), ShapeError, r"readings has shape \(5,\)"),
        (lambda: ForceSensor().measure(np.full(6, math.nan), np.random.default_rng()), NotFinite, "wrench"),
        (lambda: fit_tool(EYE[:3], np.zeros((3, 6)), gravity=G), CalibrationError, "3 poses came; at least 4"),
        (lambda: fit_tool(EYE, np.zeros((4, 6)), gravity=G), CalibrationError, "tilt the sensor about two axes"),
        (lambda: fit_tool(EYE, np.zeros((4, 6)), gravity=np.zeros(3)), CalibrationError, "state gravity"),
        (lambda: fit_tool(EYE[:2], np.zeros((4, 6)), gravity=G), ShapeError, "one for each wrench"),
        (lambda: fit_tool(2.0 * EYE, np.zeros((4, 6)), gravity=G), NotAPose, "rotation matrices are needed"),
        (lambda: fit_tool(-EYE, np.zeros((4, 6)), gravity=G), NotAPose, "mirrors"),
        (
            lambda: fit_tool(
                TURNED, np.concatenate([TURNED[:, 2] * 9.81, np.zeros((4, 3))], axis=1), gravity=G
            ),
            CalibrationError,
            "mass would be -1 kg",
        ),
        (lambda: fit_crosstalk(np.eye(6), np.eye(6)), CalibrationError, "6 loads came; at least 7"),
        (lambda: fit_crosstalk(np.ones((8, 6)), np.ones((8, 6))), CalibrationError, "do not tell all unknowns"),
        (lambda: contact_force(np.eye(3), [1, 2, 3], [0, 0, 0], [-1, 0, 0]), OutOfLimits, "tau_error holds -1"),
        (lambda: contact_force(np.ones((3, 2)), [1, 2], [0, 0], [0, 0]), OutOfLimits, "2 joints cannot tell 3"),
        (lambda: contact_force(np.diag([1, 1, 0.0]), [1, 2, 3], [0] * 3, [0] * 3), OutOfLimits, "singular"),
        (lambda: contact_force(np.eye(3), [1, 2], [0] * 3, [0] * 3), ShapeError, "tau_motor"),
    ],
)  # fmt: skip
def test_bad_input_is_named(make: object, error: type[HolonomError], named: str) -> None:
    with pytest.raises(error, match=named):
        make()  # type: ignore[operator]
