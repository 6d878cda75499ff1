"""Least squares: motion matrices agree with bases, true numbers come back, deviations are honest, doubts are named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from calibration_runs import NOMINAL, square, values, wandering
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.app.odometry_log import read_log
from holonom.errors import CalibrationError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile import arrangements
from holonom.mobile.calibration import (
    DRIVES,
    SETS,
    Run,
    calibrate,
    drive_parameters,
    held_out_errors,
    path_errors,
)

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


# OptiOdom, published_results: headings on the way and at the end before calibration (deg); the four errors after, by a
# published method (its own linear least squares, or Sousa et al.), that ours must not exceed in any of the four.
SETS_OF_RUNS = [
    ("tricyc/circular/140120211440", "extended", (107.129424, 101.338803), (0.145148, 6.247064, 0.053022, 3.675631)),
    ("tricyc/circular/140120211440", "extended", (107.129424, 101.338803), (0.129887, 7.378095, 0.037197, 7.091199)),
    ("tricyc/square/140120211446", "extended", (83.95621, 60.507896), (0.212335, 24.208987, 0.082691, 0.558982)),
    ("omni3/circular/221220201730", "extended", (7.112191, 6.478107), (0.071998, 9.901522, 0.059051, 9.80752)),
    ("omni4/circular/231220200510", "physical", (8.868256, 7.851371), (0.037305, 6.480174, 0.02917, 0.971383)),
    ("omni4/circular/231220200510", "physical", (8.868256, 7.851371), (0.037665, 6.007475, 0.03031, 1.093602)),
    ("diff/square/230620202042", "extended", (4.66003, 3.302042), (0.019036, 1.878044, 0.00716, 0.422518)),
    ("diff/square/231220200045", "extended", (7.230344, 5.457208), (0.043824, 2.651888, 0.023774, 0.498523)),
]


@pytest.mark.parametrize(("folder", "name", "headings", "published"), SETS_OF_RUNS)
def test_at_least_as_good_as_published(data_folder: Path, folder: str, name: str, headings, published) -> None:
    log = read_log([data_folder / "odometry" / "optiodom" / folder])
    found = calibrate(log.runs, log.drive, log.nominal, set_name=name)
    before, after = found.before, found.after
    assert np.allclose(np.degrees([before.heading, before.final_heading]), headings, atol=1e-3)
    ours = after.distance, np.degrees(after.heading), after.final_distance, np.degrees(after.final_heading)
    assert np.all(np.array(ours) <= published)


def test_the_extended_set_is_no_overfit(data_folder: Path) -> None:
    """On runs that a calibration has not seen it is still better than the physical set, and than none."""
    log = read_log([data_folder / "odometry" / "optiodom" / "diff" / "square" / "230620202042"])
    plain, wide = (held_out_errors(log.runs, log.drive, log.nominal, set_name=name) for name in SETS)
    before = calibrate(log.runs, log.drive, log.nominal).before
    assert wide.distance < plain.distance < before.distance
    assert wide.final_heading < 0.3 * before.final_heading
