"""Levels: what is made of points between two of them, and what happens when they come late, not at all, or wrong."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.errors import OutOfLimits, ShapeError, UnknownName
from holonom.machine.levels import INTERPOLATIONS, Levels, LevelState, PointBuffer, interpolate

R, SPEED = 0.1, 0.25


def circle(t: np.ndarray) -> np.ndarray:
    w = SPEED / R
    return R * np.stack([np.cos(w * t), np.sin(w * t)], axis=-1)


def buffer(period: float = 0.1, how: str = "linear", start: np.ndarray | None = None) -> PointBuffer:
    levels = Levels(supervisor=period, interpolation=how)
    start = circle(np.array(0.0)) if start is None else start
    return PointBuffer("the supervisor", start, levels, speed=[0.5, 0.5], acceleration=[2.0, 2.0])


@pytest.mark.parametrize(("period", "off"), [(0.1, 0.780e-3), (0.01, 7.8e-6)])
def test_a_circle_through_points_that_are_far_apart(period: float, off: float) -> None:
    """The sagitta `r (1 - cos(v T / 2 r))`: a circle of 0.1 m at 0.25 m/s."""
    held = buffer(period)
    for t in period * np.arange(1, round(1.0 / period) + 1):
        assert held.push(circle(t))
    path = held.take(1000)[0]
    assert R - np.hypot(*path.T).min() == pytest.approx(off, rel=2e-3)


def test_a_cubic_is_nearer_and_holds_are_farther() -> None:
    points, error = circle(0.1 * np.arange(11)), {}
    for how in INTERPOLATIONS:
        path = interpolate(points, 100, how)
        error[how] = np.hypot(*(path - circle(1e-3 * np.arange(1001))).T)[100:-100].max()
        np.testing.assert_allclose(path[::100], points, atol=1e-15)
    assert error["cubic"] < 0.3 * error["linear"]
    assert error["linear"] < 0.1 * error["hold"]


@given(a=st.floats(-2, 2), b=st.floats(-2, 2), ratio=st.integers(1, 20))
def test_lines_stay_lines(a: float, b: float, ratio: int) -> None:
    points = a + b * np.arange(6.0)[:, None] * [1.0, -2.0]
    for how in ("linear", "cubic"):
        wanted = a + b * (np.arange(5 * ratio + 1) / ratio)[:, None] * [1.0, -2.0]
        np.testing.assert_allclose(interpolate(points, ratio, how), wanted, atol=1e-12)


def drive(delay: int, *, last: int = 30, how: str = "linear") -> tuple[PointBuffer, np.ndarray]:
    """A line at 0.25 m/s; from the eleventh period on its points come `delay` periods late, from `last` on none."""
    held, out = buffer(0.1, how, np.zeros(2)), []
    for k in range(30):
        n = k + 1 if k <= 10 else k + 1 - delay
        if k < last and (k <= 10 or n > 11):
            held.push([0.025 * n, 0.0])
        out.append(held.take(100))
    return held, np.concatenate(out, axis=1)


@pytest.mark.parametrize("delay", [1, 2, 5])
@pytest.mark.parametrize("how", ["linear", "cubic"])
def test_a_late_level_is_named_and_the_one_below_stops_on_the_path(delay: int, how: str) -> None:
    held, (position, speed, acceleration) = drive(delay, how=how)
    assert held.state is LevelState.STANDING
    assert held.reason == "the supervisor is late: no point came within its period of 100 ms"
    end = position[-1, 0]
    assert end >= 11 * 0.025 - 1e-9, "what it held is finished"
    assert end == pytest.approx(11 * 0.025 + 0.25**2 / (2 * 2.0), abs=1e-3), "then it brakes as hard as it may"
    assert np.abs(position[:, 1]).max() == 0.0
    assert np.abs(acceleration[1200:]).max() <= 2.0 * (1 + 1e-9)
    assert (np.diff(position[:, 0]) >= -1e-12).all()
    assert (speed[-1] == 0.0).all()
    assert not held.push(position[-1]), "a level that failed is not listened to"
    held.restart()
    assert held.push(position[-1] + [0.01, 0.0])


def test_silence_from_the_beginning_is_standing() -> None:
    held = buffer()
    reference = held.take(500)
    assert held.state is LevelState.STANDING
    assert held.reason == ""
    np.testing.assert_array_equal(reference[0], np.tile(circle(np.array(0.0)), (500, 1)))


def test_silence_in_motion_stops() -> None:
    held, (position, speed, _) = drive(0, last=12)
    assert "late" in held.reason
    assert speed[-1, 0] == 0.0
    assert position[-1, 0] == pytest.approx(12 * 0.025 + 0.25**2 / 4.0, abs=1e-3)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ([np.nan, 0.0], "not finite"),
        ([np.inf, 0.0], "not finite"),
        ([0.5, 0.0], "sent a jump of axis 1: 0.425 in 100 ms"),
    ],
)
def test_what_cannot_be_followed_is_refused_and_named(wrong: list[float], said: str) -> None:
    held = buffer(start=np.zeros(2))
    for n in (1, 2, 3):
        assert held.push([0.025 * n, 0.0])
    assert not held.push(wrong)
    assert not held.push([0.1, 0.0]), "nothing is taken after it"
    position, speed, acceleration = held.take(600)
    assert held.state is LevelState.STANDING
    assert said in held.reason
    assert held.reason.startswith("the supervisor sent")
    assert position[-1, 0] == pytest.approx(3 * 0.025 + 0.25**2 / 4.0, abs=1e-3)
    assert np.isfinite(position).all()
    assert np.abs(acceleration[150:]).max() <= 2.0 * (1 + 1e-9)
    assert speed[-1, 0] == 0.0


def test_a_path_that_ends_at_rest_is_no_fault() -> None:
    held = buffer(0.01, start=np.zeros(2))
    s = np.linspace(0.0, 1.0, 51)
    for x in 0.05 * s**2 * (3 - 2 * s):
        held.push([x, 0.0])
    position = held.take(600)[0]
    assert held.reason == ""
    assert held.state is LevelState.STANDING
    assert position[-1, 0] == pytest.approx(0.05)


def test_bad_input() -> None:
    with pytest.raises(UnknownName, match="did you mean 'linear'"):
        Levels(interpolation="liner")
    for wrong in (
        {"servo": 0.7e-3},
        {"model": 1.5e-3},
        {"supervisor": 0.0},
        {"model": 0.01, "delay": 0.01},
        {"delay": -1e-3},
    ):
        with pytest.raises(OutOfLimits, match="must be a multiple"):
            Levels(**wrong)
    with pytest.raises(ShapeError, match=r"shape \(3,\)"):
        buffer().push([1.0, 2.0, 3.0])
