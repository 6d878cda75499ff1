"""How sure a base is of its pose: honest over many runs, and what theory says of each part."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job
from holonom.closed_loop import simulate_base
from holonom.control.base.path_keeping import EstimateSettings
from holonom.control.base.uncertainty import UncertaintySettings, covariance_along
from holonom.errors import OutOfLimits, ShapeError
from holonom.machine import PATHS, BaseSettings, Creep, PathLimits, plan_path
from holonom.machine.base.uncertainty import pose_uncertainty
from holonom.mobile import BaseSensors
from holonom.mobile.odometry import integrate, integrate_with_covariance
from holonom.sim import Floor, Material

SOCCER = Path(__file__).resolve().parents[2] / "examples" / "03_soccer_robot" / "cell.toml"
JOB = build_job(load_cell(SOCCER), SOCCER).bases[0]
SEEDS, PLACES = 100, 25
NOTHING = UncertaintySettings(start=0.0, start_turn=0.0, gyro_noise=0.0, gyro_bias=0.0, way_noise=0.0, drift=0.0)
CIRCLE = (PATHS.make("circle", {"size": 1.0}), PathLimits(0.8, 1.5), "tangent")
EIGHT = (PATHS.make("figure_of_eight", {"size": 2.0}), PathLimits(1.5, 2.5), "fixed")
CORNER = (np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), PathLimits(1.0, 1.0), "fixed")


def errors(course: tuple, noise: float, bias: float, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Errors (seeds, places, 3) of the believed pose, and their covariances."""
    points, limits, heading = course
    path = plan_path(points, limits, heading=heading)
    sensors = BaseSensors(gyro_noise=noise, gyro_bias=bias)
    creep, settings = Creep(material.creep, material.peak), BaseSettings(sensors=sensors)
    known = pose_uncertainty(JOB.base, JOB.drive, sensors, creep, EstimateSettings())
    missed, sure = [], []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        log = simulate_base(JOB.base, JOB.drive, path, floor=Floor(material), settings=settings, rng=rng)
        assert not log.named.any()
        C = covariance_along(known, 1e-3, log.estimated_pose, log.estimated_twist, log.acceleration)
        at = np.linspace(0, len(log.time) - 1, PLACES).astype(int)
        missed.append((log.estimated_pose - log.pose)[at])
        sure.append(C[at])
    return np.array(missed), np.array(sure)


@pytest.mark.parametrize(
    ("course", "noise", "bias", "material"),
    [
        (CIRCLE, 2.1e-3, 5.2e-4, Material(0.8, 0.65, 0.05)),
        (CIRCLE, 2e-2, -3e-3, Material(0.6, 0.5, 0.04)),
        (EIGHT, 2.1e-3, 5.2e-4, Material(0.8, 0.65, 0.05)),
        (EIGHT, 5e-3, 2e-3, Material(1.0, 0.8, 0.1)),
        (CORNER, 2.1e-3, -5.2e-4, Material(0.8, 0.65, 0.05)),
    ],
)
def test_two_sigma_holds_95_of_100(course, noise, bias, material) -> None:
    missed, sure = errors(course, noise, bias, material)
    deviation = np.sqrt(np.einsum("skii->ski", sure))
    inside = np.abs(missed) <= 2.0 * deviation
    assert (inside.mean(axis=(0, 1)) >= 0.95).all(), inside.mean(axis=(0, 1))
    assert (inside[:, -1].mean(axis=0) >= 0.95).all()
    nees = np.einsum("ski,skij,skj->sk", missed, np.linalg.inv(sure), missed).mean()
    assert 1.0 < nees < 6.0  # 3 in the mean: neither sure of what is wrong, nor unsure of all
    assert (np.sqrt((deviation**2).mean((0, 1))) < 3.0 * np.sqrt((missed**2).mean((0, 1)))).all()


def driven(count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Pose and twist (N, 3) of a curve."""
    t = 1e-3 * np.arange(count)
    twist = np.stack([1.0 + 0.3 * np.sin(t), 0.4 * np.cos(2.0 * t), 0.7 * np.sin(0.5 * t)], axis=1)
    poses = np.concatenate([np.zeros((1, 3)), integrate(1e-3 * twist)[:-1]])
    return poses, twist


def test_noise_is_carried_as_by_the_textbook() -> None:
    """White gyro noise alone: another implementation of Siegwart & Nourbakhsh (5.9)."""
    poses, twist = driven()
    found = covariance_along(
        dataclasses.replace(NOTHING, gyro_noise=3e-3, start_turn=1e-2), 1e-3, poses, twist, np.zeros((len(poses), 2))
    )
    start = np.diag([0.0, 0.0, 1e-4])
    noise = np.diag([0.0, 0.0, (3e-3 * 1e-3) ** 2])
    peer = integrate_with_covariance(1e-3 * twist, noise, covariance=start)
    assert np.allclose(found[-1], peer.covariance[-2], rtol=2e-3, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        ({"gyro_bias": 1e-3, "bias_time": 1e9}, lambda v: v + np.array([0.0, 0.0, 1e-3])),
        ({"scale": 0.01}, lambda v: v * np.array([1.01, 1.01, 1.0])),
    ],
)
def test_a_constant_is_one_sigma_off(change, wrong) -> None:
    """Dead reckoning with the constant wrong by one sigma ends one sigma off."""
    poses, twist = driven()
    found = covariance_along(dataclasses.replace(NOTHING, **change), 1e-3, poses, twist, np.zeros((len(poses), 2)))
    other = integrate(1e-3 * wrong(twist))[-2]
    off = other - poses[-1]
    assert np.allclose(found[-1], np.outer(off, off), rtol=0.02, atol=1e-9)


def test_a_lag_is_made_up_for_in_standing() -> None:
    poses, twist = driven(2)
    twist = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    found = covariance_along(
        dataclasses.replace(NOTHING, force_creep=(4e-3, 4e-3)), 1e-3, poses, twist, np.zeros((2, 2))
    )
    assert found[0, 0, 0] == pytest.approx(16e-6)
    assert not found[1].any()


def test_bad_settings_and_shapes() -> None:
    for change in ({"gyro_bias": -1.0}, {"bias_time": 0.0}, {"turn_lean": (0.0, float("nan"))}):
        with pytest.raises(OutOfLimits, match=next(iter(change))):
            UncertaintySettings(**change)
    with pytest.raises(ShapeError, match="acceleration"):
        covariance_along(NOTHING, 1e-3, np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)))
