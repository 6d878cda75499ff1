"""Least squares: motion matrices agree with bases, true numbers come back, deviations are honest, doubts are named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_runs import NOMINAL, square, values, wandering
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.app.odometry_log import OdometryLog, read_log
from holonom.errors import CalibrationError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile import arrangements
from holonom.mobile.calibration import (
    DRIVES,
    SETS,
    PathErrors,
    Run,
    calibrate,
    dead_reckoning,
    drive_parameters,
    held_out_errors,
    path_errors,
)
from holonom.mobile.calibration.fitting.limits import SACRIFICE, classical, largest_errors, within
from holonom.mobile.calibration.fitting.residuals import Problem, path_lever, solve

both = [(drive, name) for drive in DRIVES for name in SETS]
seeds = st.integers(0, 2**32 - 1)


def off(drive: str, name: str, rng: np.random.Generator, share: float = 0.04) -> np.ndarray:
    """True numbers a little off the nominal ones."""
    p = drive_parameters(drive, NOMINAL[drive], name)
    return p.nominal + share * p.scale * rng.uniform(-1.0, 1.0, len(p.names))


@pytest.mark.parametrize(("drive", "name"), both)
@given(seed=seeds)
@settings(max_examples=20)
def test_slopes_by_finite_differences(drive: str, name: str, seed: int) -> None:
    p = drive_parameters(drive, NOMINAL[drive], name)
    at = off(drive, name, np.random.default_rng(seed), 0.2)
    slopes = p.slopes(at)
    for k, d in enumerate(1e-6 * np.eye(len(at))):
        assert np.allclose(slopes[:, :, k], (p.matrix(at + d) - p.matrix(at - d)) / 2e-6, atol=1e-8)


@pytest.mark.parametrize("drive", DRIVES)
def test_the_extended_set_starts_at_the_physical_one(drive: str) -> None:
    plain, wide = (drive_parameters(drive, NOMINAL[drive], name) for name in SETS)
    assert np.allclose(plain.matrix(plain.nominal), wide.matrix(wide.nominal), atol=1e-15)


def test_motion_matrices_are_those_of_the_bases() -> None:
    """Each drive's matrix is the forward model of the base of chapter 6.1; wheels in the same order."""
    third = 2.0 * np.pi / 3.0
    bases = {
        "differential": (arrangements.differential(0.2, (0.042, 0.043)), [0.2, 0.084, 0.086]),
        "omni3": (
            arrangements.omni([-third / 2, third / 2, np.pi], radius=0.195, wheel_radius=0.05),
            [0.195, *[0.1] * 3],
        ),
        "mecanum": (arrangements.mecanum(0.25, 0.15, 0.03), [0.4, *[0.06] * 4]),
        "omni4_any": (
            arrangements.omni([1.0, 2.4, 3.9, 5.3], radius=0.08, wheel_radius=0.027),
            [0.08, *[0.054] * 4, 1.0, 2.4, 3.9, 5.3],
        ),
    }
    for drive, (base, numbers) in bases.items():
        p = drive_parameters(drive, dict(zip(DRIVES[drive], numbers, strict=True)))
        assert np.allclose(base.twist(np.eye(len(base.driven))).T, p.matrix(p.nominal), atol=1e-12), drive
    base = arrangements.tricycle(0.15, 0.1, 0.0325)
    p = drive_parameters("tricycle", NOMINAL["tricycle"])
    for angle in (-0.7, 0.0, 0.3):
        expected = base.twist([1.0], [angle])
        assert np.allclose(p.matrix(p.nominal) @ [np.cos(angle), np.sin(angle)], expected, atol=1e-12)


@pytest.mark.parametrize(("drive", "name"), both)
def test_true_numbers_come_back(drive: str, name: str) -> None:
    """Without noise: every parameter, to nine digits."""
    rng = np.random.default_rng(3)
    truth = off(drive, name, rng)
    runs = [wandering(drive, truth, name, seed=seed, way=0.5) for seed in (1, 2, 3)]
    found = calibrate(runs, drive, NOMINAL[drive], set_name=name)
    p = drive_parameters(drive, NOMINAL[drive], name)
    assert np.allclose(found.matrix, p.matrix(truth), atol=1e-8)
    assert np.allclose(found.values / p.scale, truth / p.scale, atol=1e-7)
    assert found.after.distance < 1e-6 < found.before.distance
    assert np.all(np.diff(found.singular_values) <= 0.0)
    assert found.condition >= 1.0


@pytest.mark.parametrize("drive", ["differential", "omni3"])
def test_deviations_are_what_repetition_shows(drive: str) -> None:
    """Forty times the same drive with other slip: the estimates scatter as much as they said."""
    rng = np.random.default_rng(8)
    truth = off(drive, "physical", rng)
    found = [
        calibrate(
            [wandering(drive, truth, "physical", seed=100 * k + j, way=0.5, noise=0.003) for j in range(3)],
            drive,
            NOMINAL[drive],
        )
        for k in range(40)
    ]
    normal = np.stack([(f.values - truth) / f.deviations for f in found])
    assert np.all((normal.std(0) > 0.7) & (normal.std(0) < 1.4))
    assert np.all(np.abs(normal.mean(0)) < 0.6)
    assert np.allclose(np.diagonal(found[0].correlation), 1.0)


def test_straight_lines_leave_the_wheelbase_open() -> None:
    full = square(2.0, 1, values(NOMINAL["differential"]))
    line = Run("line", full.time[:400], full.turns[:400], full.truth[:400], full.steering[:400])
    with pytest.raises(CalibrationError, match="tells nothing of wheelbase: turn, on the spot"):
        calibrate([line], "differential", NOMINAL["differential"])


def test_one_circle_tells_two_numbers_of_three() -> None:
    turns = np.tile([0.1, 0.12], (300, 1))
    turns[0] = 0.0
    p = drive_parameters("differential", NOMINAL["differential"])
    from holonom.mobile.odometry import integrate

    run = Run("circle", 0.05 * np.arange(300), turns, integrate(turns @ p.matrix(p.nominal).T), np.empty((300, 0)))
    with pytest.raises(CalibrationError, match=r"does not tell wheelbase, diameter_left, diameter_right apart: turn"):
        calibrate([run], "differential", NOMINAL["differential"])


def test_a_steering_that_never_moves_leaves_the_offset_tied() -> None:
    p = drive_parameters("tricycle", NOMINAL["tricycle"])
    from holonom.mobile.odometry import integrate

    turns, steering = np.full((300, 1), 0.1), np.full((300, 1), 0.3)
    features = Run("x", np.arange(300.0), turns, np.empty((0, 3)), steering).features
    run = Run("curve", 0.05 * np.arange(300), turns, integrate(features @ p.matrix(p.nominal).T), steering)
    with pytest.raises(CalibrationError, match="wheelbase"):
        calibrate([run], "tricycle", NOMINAL["tricycle"])


def test_noise_that_drowns_a_parameter_leaves_it_open() -> None:
    """A line with slip: something of a wheelbase always comes out, and is refused by its deviation."""
    rng = np.random.default_rng(0)
    turns = np.full((400, 2), 0.1) + 0.002 * rng.normal(size=(400, 2))
    p = drive_parameters("differential", NOMINAL["differential"])
    from holonom.mobile.odometry import integrate

    slip = 0.003 * rng.normal(size=(400, 3))
    run = Run("line", 0.05 * np.arange(400), turns, integrate(turns @ p.matrix(p.nominal).T + slip), np.empty((400, 0)))
    with pytest.raises(CalibrationError, match="wheelbase"):
        calibrate([run], "differential", NOMINAL["differential"])


def test_runs_take_lists() -> None:
    run = Run("lists", [0.0, 1.0], [[0.0, 0.0], [1.0, 1.0]], [[0.0, 0.0, 0.0]] * 2, [[], []])
    assert run.features.shape == (2, 2)
    with pytest.raises(ShapeError, match="run lists: turns holds no numbers"):
        Run("lists", [0.0, 1.0], [[0.0], [1.0, 1.0]], [[0.0, 0.0, 0.0]] * 2, [[], []])


def test_bad_input_is_refused() -> None:
    nominal = NOMINAL["differential"]
    run = wandering("differential", values(nominal), "physical", seed=1)
    blind = Run("blind", run.time, run.turns, np.empty((0, 3)), run.steering)
    for call, problem, match in (
        (lambda: calibrate([], "differential", nominal), CalibrationError, "no run"),
        (lambda: calibrate([blind], "differential", nominal), CalibrationError, "no ground truth"),
        (lambda: calibrate([run], "omni3", NOMINAL["omni3"]), CalibrationError, "2 wheels .* an omni3 has 3"),
        (lambda: calibrate([run], "diferential", nominal), UnknownName, "did you mean 'differential'"),
        (lambda: calibrate([run], "differential", nominal, set_name="all"), UnknownName, "set of parameters"),
        (lambda: calibrate([run], "differential", nominal, lever=0.0), OutOfLimits, "lever"),
        (lambda: calibrate([run], "differential", nominal, final_weight=-1.0), OutOfLimits, "final weight"),
        (lambda: calibrate([run], "differential", {**nominal, "wheelbase": -1.0}), OutOfLimits, "wheelbase -1"),
        (lambda: held_out_errors([run, run], "differential", nominal), CalibrationError, "three or more"),
        (lambda: path_errors([], []), CalibrationError, "no run"),
        (lambda: Run("x", np.zeros(1), np.zeros((1, 2)), np.zeros((1, 3)), np.zeros((1, 0))), ShapeError, "run x"),
        (lambda: Run("x", np.full(2, np.nan), *[np.zeros((2, k)) for k in (2, 3, 0)]), ShapeError, "time holds NaN"),
    ):
        with pytest.raises(problem, match=match):
            call()


def noisy(drive: str, *, seed: int) -> list[Run]:
    truth = off(drive, "physical", np.random.default_rng(seed))
    return [wandering(drive, truth, "physical", seed=100 * seed + j, way=0.5, noise=0.003) for j in range(3)]


def largest(errors: PathErrors) -> np.ndarray:
    return np.array([errors.distance, errors.heading, errors.final_distance, errors.final_heading])


@pytest.mark.parametrize("drive", ["differential", "omni3", "tricycle"])
def test_on_demand_the_extended_set_is_in_no_column_worse_than_the_classical_one(drive: str) -> None:
    grown = []
    for seed in range(4):
        runs = noisy(drive, seed=seed)
        found = calibrate(runs, drive, NOMINAL[drive], set_name="extended", limits="classical")
        free = calibrate(runs, drive, NOMINAL[drive], set_name="extended", limits=[np.inf] * 4)
        assert np.all(largest(found.after) <= found.limits)
        assert np.any(largest(free.after) > found.limits) == (found.growth > 0.0)
        assert np.all(np.abs(found.values - free.values) < 2.0 * found.deviations)
        grown.append(found.growth)
    assert 0.0 < max(grown) < 0.3
    assert free.growth == 0.0
    assert np.all(np.isinf(calibrate(runs, drive, NOMINAL[drive]).limits))


def test_a_classical_calibration_cares_for_the_ends_as_far_as_the_way_allows() -> None:
    """A run of random motion lets the ends have their way; closed squares with noise do not tell the wheels' size."""
    drive = drive_parameters("differential", NOMINAL["differential"])
    closed = [square(2.0, sense, values(NOMINAL["differential"])) for sense in (-1, 1)]
    walk = np.cumsum(2e-4 * np.random.default_rng(5).normal(size=(2, *closed[0].truth.shape)), axis=1)
    slipping = [replace(run, truth=run.truth + steps) for run, steps in zip(closed, walk, strict=True)]
    for runs in (noisy("differential", seed=1), slipping):
        problem = Problem(tuple(runs), drive, "midpoint", path_lever(runs), 1.0)
        x = solve(problem, np.zeros(3))
        way, both = replace(problem, final_weight=0.0), []
        for at in (x, classical(problem)):
            cost = np.sum(way.residuals(at)[0] ** 2)
            both.append((np.sqrt(cost), np.sum(problem.residuals(at)[0] ** 2) - cost))
        (old_way, old_end), (new_way, new_end) = both
        assert new_end < old_end
        assert old_way < new_way < 1.01 * (1.0 + SACRIFICE) * old_way


@pytest.mark.parametrize("column", range(4))
def test_limits_are_kept_with_the_least_squares_there_are(column: int) -> None:
    """Of many parameters around that keep the limits, none has a smaller sum."""
    runs, drive = noisy("differential", seed=3), drive_parameters("differential", NOMINAL["differential"], "extended")
    problem = Problem(tuple(runs), drive, "midpoint", path_lever(runs), 1.0)
    x = solve(problem, np.zeros(6))
    limits = np.full(4, np.inf)
    limits[column] = (0.97 if column < 2 else 0.8) * largest_errors(problem, x)[column]
    kept = within(problem, x, limits)
    assert kept is not None

    def both(at: np.ndarray) -> tuple[float, float]:
        matrix = drive.matrix(problem.values(at))
        paths = [dead_reckoning(run, matrix) for run in runs]
        return float(np.sum(problem.residuals(at)[0] ** 2)), largest(path_errors(runs, paths))[column] / limits[column]

    least, share = both(kept)
    assert 0.999 < share <= 1.0
    assert least > both(x)[0]
    rng, J = np.random.default_rng(0), problem.residuals(x)[1]
    steps = rng.normal(size=(300, 6)) @ np.linalg.inv(np.linalg.cholesky(J.T @ J))
    for step in 0.02 * np.sqrt(least) * steps:
        cost, share = both(kept + step)
        assert cost > least * (1.0 - 1e-6) or share > 1.0


def test_limits_that_nothing_keeps_or_that_are_none() -> None:
    runs = noisy("differential", seed=2)
    for limits, problem, match in (
        (
            [1e-4] * 4,
            CalibrationError,
            r"within 0\.0001 m on the way, 0\.00573 degrees on the way, .*; give wider limits",
        ),
        ([np.inf, np.inf, 1e-5, np.inf], CalibrationError, r"keep all errors within 1e-05 m at the end; give wider"),
        ([1.0, 1.0], OutOfLimits, "give four above zero"),
        ([1.0, 0.0, 1.0, 1.0], OutOfLimits, "give four above zero"),
        (["wide"] * 4, OutOfLimits, "give four above zero"),
        ([1.0, np.nan, 1.0, 1.0], OutOfLimits, "give four above zero"),
    ):
        with pytest.raises(problem, match=match):
            calibrate(runs, "differential", NOMINAL["differential"], limits=limits)


def test_limits_below_rounding_count_as_what_is_kept() -> None:
    drive, truth = "differential", off("differential", "physical", np.random.default_rng(1))
    exact = [wandering(drive, truth, "physical", seed=j) for j in range(2)]
    for runs, limits in ((exact, "classical"), (exact, [np.inf, np.inf, np.inf, 1e-12])):
        found = calibrate(runs, drive, NOMINAL[drive], set_name="extended", limits=limits)
        assert found.limits[3] == 1e-6
        assert np.all(largest(found.after) <= found.limits)


def by_the_data_sheet(log: OdometryLog) -> PathErrors:
    p = drive_parameters(log.drive, log.nominal)
    return path_errors(log.runs, [dead_reckoning(run, p.matrix(p.nominal)) for run in log.runs])


def test_the_extended_set_is_no_overfit(data_folder: Path) -> None:
    """On runs that a calibration has not seen it is still better than the physical set, and than none."""
    log = read_log([data_folder / "odometry" / "optiodom" / "diff" / "square" / "230620202042"])
    plain, wide = (held_out_errors(log.runs, log.drive, log.nominal, set_name=name) for name in SETS)
    before = by_the_data_sheet(log)
    assert wide.distance < plain.distance < before.distance
    assert wide.final_heading < 0.3 * before.final_heading
    log = read_log([data_folder / "odometry" / "optiodom" / "omni3"])
    plain, wide = (held_out_errors(log.runs, log.drive, log.nominal, set_name=name) for name in SETS)
    before = by_the_data_sheet(log)
    assert wide.distance < plain.distance < before.distance
    assert max(wide.final_heading, plain.final_heading) < before.final_heading  # 9 numbers out of three runs
