"""Paths from pose to pose: every pose is reached, the reference is one motion, it rests where curvature jumps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from holonom.control import PATH_LAWS
from holonom.control.base.kernels import Planar, pose_step, reference_at
from holonom.errors import InputError, OutOfLimits, ShapeError
from holonom.machine import PATHS, PathLimits, plan_path
from holonom.machine.base.paths.pose_paths import joined
from holonom.mobile import poses
from holonom.mobile.curves import reeds_shepp

PLACES = ((0.0, 0.0, 0.0), (1.2, 0.6, 0.0), (0.6, 0.9, 1.0), (0.6, 0.9, 1.0), (2.0, -1.0, 3.0))
LIMITS = PathLimits(0.6, 0.8)


def off(a: np.ndarray, b: np.ndarray) -> float:
    d = a - b
    return float(max(np.abs(d[..., :2]).max(), np.abs(poses.wrapped(d[..., 2])).max()))


@pytest.mark.parametrize("shape", ["dubins", "reeds_shepp"])
def test_the_reference_is_one_motion_through_all_poses(shape: str) -> None:
    path = plan_path(PATHS.make(shape, {"poses": PLACES, "radius": 0.5}), LIMITS)
    assert off(path.pose[[0, -1]], np.array(PLACES)[[0, -1]]) < 1e-9
    for place in PLACES:
        d = path.pose - place
        d[:, 2] = poses.wrapped(d[:, 2])
        assert np.abs(d).max(axis=1).min() < 1e-3
    c, s = np.cos(path.pose[:, 2]), np.sin(path.pose[:, 2])
    moved = np.gradient(path.pose, 1e-3, axis=0)
    np.testing.assert_allclose(c * moved[:, 0] + s * moved[:, 1], path.twist[:, 0], atol=2e-3)
    np.testing.assert_allclose(c * moved[:, 1] - s * moved[:, 0], 0.0, atol=2e-3)
    np.testing.assert_allclose(moved[:, 2], path.twist[:, 2], atol=4e-3)
    velocity = np.column_stack([c, s]) * path.twist[:, :1]
    change = np.gradient(velocity, 1e-3, axis=0)
    np.testing.assert_allclose(c * change[:, 0] + s * change[:, 1], path.acceleration[:, 0], atol=2e-2)
    np.testing.assert_allclose(c * change[:, 1] - s * change[:, 0], path.acceleration[:, 1], atol=2e-2)
    assert not path.twist[:, 1].any()
    assert np.abs(path.twist[:, 0]).max() <= LIMITS.speed * (1 + 1e-5)
    assert np.hypot(*path.acceleration[:, :2].T).max() <= LIMITS.acceleration * 1.05
    assert np.abs(path.twist[:, 2]).max() <= 2.0 * LIMITS.speed * (1 + 1e-5)
    assert (path.twist[:, 0].min() < 0.0) == (shape == "reeds_shepp")


def test_curvature_changes_at_rest_only() -> None:
    path = plan_path(PATHS.make("reeds_shepp", {"poses": PLACES, "radius": 0.5}), LIMITS, rest=0.4)
    v, w = path.twist[:, 0], path.twist[:, 2]
    moving = np.flatnonzero(np.abs(v) > 1e-6)
    curvature = w[moving] / v[moving]
    jumps = np.flatnonzero(np.abs(np.diff(curvature)) > 1e-6)
    assert len(jumps) > 5
    assert (np.diff(moving)[jumps] >= 400).all()
    assert not path.twist[:400].any()
    assert not path.twist[-400:].any()


def test_straight_on_it_does_not_stop() -> None:
    path = plan_path(PATHS.make("dubins", {"poses": ((0, 0, 0), (1, 0, 0), (2, 0, 0)), "radius": 0.5}), LIMITS)
    middle = path.twist[np.abs(path.pose[:, 0] - 1.0) < 0.01, 0]
    np.testing.assert_allclose(middle, LIMITS.speed, rtol=1e-5)


@pytest.mark.parametrize("law", [name for name in PATH_LAWS if name != "mpc"])
def test_every_law_parks(law: str) -> None:
    """A base with a smallest turning radius of the path's drives it from a start that is off by some millimetres."""
    path = plan_path(PATHS.make("reeds_shepp", {"poses": PLACES[:3], "radius": 0.5}), LIMITS)
    rows = np.column_stack([path.pose, path.twist, path.acceleration])
    made = PATH_LAWS.make(law, {"max_curvature": 2.5})
    params, memory, now = made.settings.params(1e-3), np.zeros(8), np.zeros(9)
    pose, before = Planar(0.005, -0.005, 0.02), Planar(0.0, 0.0, 0.0)
    worst = 0.0
    for i in range(len(rows)):
        reference_at(rows, float(i), 1.0, 0.0, now)
        before = made.step(params, rows, float(i), now, pose, before, before, memory)
        pose = pose_step(pose, before, 1e-3)
        worst = max(worst, math.hypot(pose.x - now[0], pose.y - now[1]))
    assert worst < 0.05
    assert math.hypot(pose.x - PLACES[2][0], pose.y - PLACES[2][1]) < 0.02
    assert abs(math.remainder(pose.turn - PLACES[2][2], 2.0 * math.pi)) < 0.08


def test_bad_input() -> None:
    with pytest.raises(ShapeError, match="at least 2"):
        joined(reeds_shepp, [[0.0, 0.0, 0.0]], 1.0)
    with pytest.raises(ShapeError, match="all the same"):
        joined(reeds_shepp, [[0.0, 0.0, 0.0]] * 2, 1.0)
    with pytest.raises(OutOfLimits, match="radius"):
        PATHS.make("dubins", {"poses": PLACES, "radius": -1.0})
    curve = joined(reeds_shepp, PLACES, 1.0)
    for wrong in ({"heading": "fixed"}, {"laps": 2}, {"start": 0.5}):
        with pytest.raises(InputError, match="driven once along its tangent"):
            plan_path(curve, LIMITS, **wrong)
    with pytest.raises(ShapeError, match="plans one"):
        plan_path(reeds_shepp([[0.0, 0.0, 0.0]] * 2, [1.0, 1.0, 1.0], 1.0), LIMITS)
