"""Least squares: motion matrices agree with bases, true numbers come back, deviations are honest, doubts are named."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calibration_runs import NOMINAL, square, values, wandering
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from holonom.app.calibrate_odometry import calibrate_odometry
from holonom.app.odometry_log import read_log
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
from holonom.mobile.calibration.limits import SACRIFICE, classical, largest_errors, within
from holonom.mobile.calibration.residuals import Problem, path_lever, solve

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
    assert np.all((normal.std(0) > 0.6) & (normal.std(0) < 1.6))
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


HEADINGS = {  # OptiOdom, published_results: headings on the way and at the end before calibration, deg
    "tricyc/circular/140120211440": (107.129424, 101.338803),
    "tricyc/square/140120211446": (83.95621, 60.507896),
    "omni3/circular/221220201730": (7.112191, 6.478107),
    "omni4/circular/231220200510": (8.868256, 7.851371),
    "omni4/square/080920201205": (24.057278, None),  # at the end by a run that is not here
    "diff/square/230620202042": (4.66003, 3.302042),
    "diff/square/231220200045": (7.230344, 5.457208),
    "diff/ivanjko/231220200104": (7.091882, 2.601035),
}

# Every published method of every set that is here: distance (m) and heading (deg) on the way, and the same at the end,
# each the largest over the runs; last what ours may be, in multiples of it, where it is not the better one.
PUBLISHED = [
    ("tricyc/circular/140120211440", "Kallasi", (0.145148, 6.247064, 0.053022, 3.675631), {}),
    ("tricyc/circular/140120211440", "Sousa", (0.129887, 7.378095, 0.037197, 7.091199), {}),
    ("tricyc/square/140120211446", "Kallasi", (0.212335, 24.208987, 0.082691, 0.558982), {}),
    ("tricyc/square/140120211446", "Sousa", (0.162686, 20.382705, 0.119447, 5.563135), {"heading": 1.151}),
    ("omni3/circular/221220201730", "Lin", (0.117556, 2.718219, 0.108121, 1.627792), {}),
    ("omni3/circular/221220201730", "Sousa", (0.071998, 9.901522, 0.059051, 9.80752), {}),
    ("omni4/circular/231220200510", "Lin", (0.037305, 6.480174, 0.02917, 0.971383), {}),
    ("omni4/circular/231220200510", "Sousa", (0.037665, 6.007475, 0.03031, 1.093602), {}),
    ("omni4/square/080920201205", "Lin", (0.058858, 8.196471, 0.046421, 0.606588), {}),
    ("omni4/square/080920201205", "Sousa", (0.052558, 8.353055, 0.028682, 2.42252), {}),
    ("diff/square/230620202042", "UMBmark", (0.022345, 1.760155, 0.007157, 0.874296), {}),
    ("diff/square/230620202042", "Jung", (0.026533, 3.745866, 0.024596, 2.355391), {}),
    ("diff/square/230620202042", "Sousa", (0.019036, 1.878044, 0.00716, 0.422518), {}),
    ("diff/square/231220200045", "UMBmark", (0.049823, 3.556827, 0.020285, 1.443283), {}),
    ("diff/square/231220200045", "Jung", (0.047447, 2.432634, 0.014547, 0.167984), {}),
    ("diff/square/231220200045", "Sousa", (0.043824, 2.651888, 0.023774, 0.498523), {}),
    (
        "diff/ivanjko/231220200104",
        "Ivanjko",
        (0.011552, 7.179304, 0.002426, 0.152058),
        {"distance": 1.0001, "final heading": 1.001},
    ),
    (
        "diff/ivanjko/231220200104",
        "Sousa",
        (0.011532, 7.093278, 0.002799, 2.564843),
        {"distance": 1.002, "heading": 1.013},
    ),
]
ROWS = [f"{p[0]} {p[1]}" for p in PUBLISHED]
MEASURES = ("distance", "heading", "final distance", "final heading")


@cache
def by_the_command(folder: Path) -> dict[str, Any]:
    """What the command finds when nothing else is said."""
    return calibrate_odometry([folder]).data


@pytest.mark.parametrize(("folder", "method", "published", "worse"), PUBLISHED, ids=ROWS)
def test_at_least_as_good_as_published(data_folder: Path, folder: str, method: str, published, worse) -> None:
    """In every column but the named ones, and in those worse by as much as is said here, and not better."""
    data = by_the_command(data_folder / "odometry" / "optiodom" / folder)
    before, after = (
        [errors[key] for key in data["limits"]] for errors in (data["errors_before"], data["errors_after"])
    )
    for our, their in zip(before[1::2], HEADINGS[folder], strict=True):
        assert their is None or our == pytest.approx(their, abs=1e-3)
    for name, our, their in zip(MEASURES, after, published, strict=True):
        assert our <= worse.get(name, 1.0) * their, name
        assert name not in worse or our > their, f"{name} is better now: say so"


@pytest.mark.parametrize(("folder", "method", "published", "worse"), PUBLISHED, ids=ROWS)
def test_published_errors_are_kept_as_limits(data_folder: Path, folder: str, method: str, published, worse) -> None:
    """All four columns of any published method at once, where they are asked for."""
    data = calibrate_odometry([data_folder / "odometry" / "optiodom" / folder], limits=published).data
    assert [data["errors_after"][key] <= limit for key, limit in zip(data["limits"], published, strict=True)] == [
        True
    ] * 4
    assert 0.0 <= data["growth"] < 0.51


@pytest.mark.parametrize(
    ("folder", "way", "end", "least"),
    [
        ("tricyc/square/140120211446", 20.382705, 0.558982, 1.129),
        ("diff/ivanjko/231220200104", 7.093278, 0.152058, 1.012),
    ],
)
def test_two_published_methods_no_odometry_beats_both(
    data_folder: Path, folder: str, way: float, end: float, least: float
) -> None:
    """Headings are linear in the motion matrix: a linear program finds the best of all, as multiple of the limits.

    Sousa's heading on the way and the other method's at the end; one of the two is worse for every matrix there is.
    """
    log = read_log([data_folder / "odometry" / "optiodom" / folder])
    sums = [np.cumsum(run.features, axis=0) for run in log.runs]
    A = np.concatenate([np.vstack([F / way, F[-1:] / end]) for F in sums])
    turned = [np.degrees(run.heading - run.heading[0]) for run in log.runs]
    b = np.concatenate([np.append(h / way, h[-1] / end) for h in turned])
    up = -np.ones((len(b), 1))
    best = linprog([0.0, 0.0, 1.0], np.block([[A, up], [-A, up]]), np.append(b, -b), bounds=(None, None))
    assert best.status == 0
    assert best.fun == pytest.approx(least, abs=1e-3)
    limits = [np.inf, np.radians(way), np.inf, np.radians(end)]
    with pytest.raises(CalibrationError, match="no extended parameters near the least squares keep all errors within"):
        calibrate(log.runs, log.drive, log.nominal, set_name="extended", limits=limits)


def noisy(drive: str, *, seed: int) -> list[Run]:
    truth = off(drive, "physical", np.random.default_rng(seed))
    return [wandering(drive, truth, "physical", seed=100 * seed + j, way=0.5, noise=0.003) for j in range(3)]


def largest(errors: PathErrors) -> np.ndarray:
    return np.array([errors.distance, errors.heading, errors.final_distance, errors.final_heading])


@pytest.mark.parametrize("drive", ["differential", "omni3", "tricycle"])
def test_the_extended_set_is_in_no_column_worse_than_the_classical_one(drive: str) -> None:
    grown = []
    for seed in range(4):
        runs = noisy(drive, seed=seed)
        found = calibrate(runs, drive, NOMINAL[drive], set_name="extended")
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
    for runs, grown in ((noisy("differential", seed=1), None), (slipping, SACRIFICE)):
        problem = Problem(tuple(runs), drive, "midpoint", path_lever(runs), 1.0)
        x = solve(problem, np.zeros(3))
        way, both = replace(problem, final_weight=0.0), []
        for at in (x, classical(problem)):
            cost = np.sum(way.residuals(at)[0] ** 2)
            both.append((np.sqrt(cost), np.sum(problem.residuals(at)[0] ** 2) - cost))
        (old_way, old_end), (new_way, new_end) = both
        assert new_end < old_end
        assert old_way < new_way < 1.01 * (1.0 + SACRIFICE) * old_way
        assert grown is None or new_way / old_way - 1.0 == pytest.approx(grown, rel=0.1)


@pytest.mark.parametrize("column", range(4))
def test_limits_are_kept_with_the_least_squares_there_are(column: int) -> None:
    """Of many parameters around that keep the limits, none has a smaller sum."""
    runs, drive = noisy("differential", seed=3), drive_parameters("differential", NOMINAL["differential"], "extended")
    problem = Problem(tuple(runs), drive, "midpoint", path_lever(runs), 1.0)
    x = solve(problem, np.zeros(6))
    limits = np.full(4, np.inf)
    limits[column] = (0.97 if column < 2 else 0.5) * largest_errors(problem, x)[column]
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
    for runs, limits in ((exact, None), (noisy(drive, seed=2)[:2], [np.inf, np.inf, np.inf, 1e-12])):
        found = calibrate(runs, drive, NOMINAL[drive], set_name="extended", limits=limits)
        assert found.limits[3] == 1e-6
        assert np.all(largest(found.after) <= found.limits)


def test_the_extended_set_is_no_overfit(data_folder: Path) -> None:
    """On runs that a calibration has not seen it is still better than the physical set, and than none."""
    log = read_log([data_folder / "odometry" / "optiodom" / "diff" / "square" / "230620202042"])
    plain, wide = (held_out_errors(log.runs, log.drive, log.nominal, set_name=name) for name in SETS)
    before = calibrate(log.runs, log.drive, log.nominal).before
    assert wide.distance < plain.distance < before.distance
    assert wide.final_heading < 0.3 * before.final_heading
    log = read_log([data_folder / "odometry" / "optiodom" / "omni3"])
    plain, wide = (held_out_errors(log.runs, log.drive, log.nominal, set_name=name) for name in SETS)
    before = calibrate(log.runs, log.drive, log.nominal).before
    assert wide.distance < plain.distance < before.distance
    assert wide.final_heading < plain.final_heading < before.final_heading
