"""Reference paths: on the curve, within the limits, and each derivative the derivative of what is above it."""

from __future__ import annotations

import numpy as np
import pytest

from holonom.errors import OutOfLimits, ShapeError, UnknownName
from holonom.machine import Levels
from holonom.machine.base.paths import HEADINGS, PATHS, ClosedCurve, PathLimits, circle, plan_path, sampled, waypoints

CURVES = [name for name in PATHS if PATHS[name].record is ClosedCurve]
LIMITS = PathLimits(1.5, 2.0)


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("heading", HEADINGS)
def test_each_path_with_each_heading(name: str, heading: str) -> None:
    points = PATHS.make(name, {"size": 3.0})
    path = plan_path(points, LIMITS, laps=2, heading=heading, start=0.4)
    speed = np.hypot(*path.twist[:, :2].T)
    assert speed.max() <= LIMITS.speed * (1.0 + 1e-6)
    assert np.hypot(*path.acceleration[:, :2].T).max() <= 1.25 * LIMITS.acceleration
    assert speed[0] == 0.0
    assert speed[-1] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(path.pose[-1, :2], path.pose[0, :2], atol=1e-6)
    assert np.diff(path.time) == pytest.approx(1e-3)
    fine = np.concatenate([points[:-1] + part * np.diff(points, axis=0) for part in np.linspace(0, 1, 20)])
    away = [np.hypot(*(fine - place).T).min() for place in path.pose[::200, :2]]
    assert max(away) < 2e-3


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("heading", HEADINGS)
def test_derivatives(name: str, heading: str) -> None:
    """The twist is the pose's derivative, turned into base_link; the acceleration is the velocity's, likewise."""
    path = plan_path(PATHS.make(name, {"size": 3.0}), LIMITS, heading=heading)
    c, s = np.cos(path.pose[:, 2]), np.sin(path.pose[:, 2])

    def world(a: np.ndarray) -> np.ndarray:
        return np.stack([c * a[:, 0] - s * a[:, 1], s * a[:, 0] + c * a[:, 1], a[:, 2]], axis=1)

    inner = slice(2, -2)
    velocity = world(path.twist)
    np.testing.assert_allclose(np.gradient(path.pose, 1e-3, axis=0)[inner], velocity[inner], atol=2e-3)
    gradient = np.gradient(velocity, 1e-3, axis=0)
    np.testing.assert_allclose(gradient[inner, :2], world(path.acceleration)[inner, :2], atol=0.1)
    np.testing.assert_allclose(gradient[inner, 2], path.acceleration[inner, 2], atol=0.2)


def test_headings() -> None:
    points = circle(2.0)
    fixed = plan_path(points, LIMITS, heading="fixed", start=0.3)
    assert (fixed.pose[:, 2] == 0.3).all()
    tangent = plan_path(points, LIMITS, heading="tangent")
    moving = np.hypot(*tangent.twist[:, :2].T) > 0.1
    assert np.abs(tangent.twist[moving, 1]).max() < 1e-9
    assert tangent.pose[-1, 2] - tangent.pose[0, 2] == pytest.approx(2.0 * np.pi, abs=1e-3)
    rotating = plan_path(points, LIMITS, heading="rotating", turns=-3.0, laps=2)
    assert rotating.pose[-1, 2] == pytest.approx(-12.0 * np.pi, abs=1e-6)


def test_a_straight_line_takes_its_time() -> None:
    """Trapezoid: 3 m at 1.5 m/s and 2 m/s2 take 3/1.5 + 1.5/2 s, and the smoothing on top."""
    path = plan_path([[0.0, 0.0], [3.0, 0.0]], LIMITS, rest=0.0)
    assert path.time[-1] == pytest.approx(2.75 + 2 * LIMITS.rise_time, abs=0.01)
    assert path.pose[-1, 0] == pytest.approx(3.0)


def test_waypoints() -> None:
    path = plan_path(waypoints([[0, 0], [1, 0], [1, 1], [0, 1]], closed=True), LIMITS)
    for corner in ([1, 0], [1, 1], [0, 1]):
        assert np.hypot(*(path.pose[:, :2] - corner).T).min() < 5e-3


def test_bad_input() -> None:
    with pytest.raises(ShapeError, match="waypoints"):
        plan_path([[0.0, 0.0]])
    with pytest.raises(ShapeError, match="the same"):
        plan_path([[0, 0], [1, 0], [1, 0]])
    with pytest.raises(UnknownName, match="tangent"):
        plan_path(circle(1.0), heading="tangents")
    with pytest.raises(OutOfLimits, match="laps"):
        plan_path([[0, 0], [1, 0]], laps=2)
    with pytest.raises(OutOfLimits, match="acceleration"):
        PathLimits(acceleration=-1.0)


@pytest.mark.parametrize("points", [[[0.0, 0.0], [0.4, 0.1], [0.8, 0.0]], [[0.0, 0.0], [1.7, 0.3]]])
@pytest.mark.parametrize("heading", HEADINGS)
def test_an_open_path_ends_where_its_last_point_is(points: list[list[float]], heading: str) -> None:
    """Rounding may carry the distance beyond the length: the end is the end, not the start again."""
    path = plan_path(points, PathLimits(0.8, 1.5), heading=heading)
    np.testing.assert_allclose(path.pose[-1, :2], points[-1], atol=1e-9)
    assert np.hypot(*np.diff(path.pose[:, :2], axis=0).T).max() < 1e-3


@pytest.mark.parametrize(("period", "off"), [(0.1, 0.780e-3), (0.01, 7.8e-6)])
def test_a_base_that_gets_points_of_a_circle(period: float, off: float) -> None:
    """A circle of 0.1 m at 0.25 m/s, points every 100 ms or 10 ms, straight between them."""
    path = plan_path(PATHS.make("circle", {"size": 0.2}), PathLimits(0.25, 5.0), laps=3)
    seen = sampled(path, Levels(supervisor=period))
    assert len(seen.time) == len(path.time)
    fast = np.hypot(*path.twist[:, :2].T) > 0.2499
    inside = 0.1 - np.hypot(seen.pose[fast, 0], seen.pose[fast, 1] - 0.1)
    assert inside.max() == pytest.approx(off, rel=0.02)
    np.testing.assert_allclose(seen.pose[-1], path.pose[-1], atol=1e-12)
    assert np.abs(seen.twist[fast] - path.twist[fast])[:, :2].max() < 0.5 * 0.25 * 0.25 / 0.1 * period + 1e-3
