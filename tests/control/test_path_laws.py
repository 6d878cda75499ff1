"""Conformance of every law of paths: limits, convergence, cusps, rest; then what each law says of itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are

from holonom.control import PATH_LAWS, PathLaw
from holonom.control.base.kernels import Planar, pose_step, reference_at
from holonom.control.path_laws.contract import AHEAD, nearness
from holonom.control.path_laws.kanayama import KanayamaSettings
from holonom.control.path_laws.ltv import LtvSettings, ltv_gains
from holonom.control.path_laws.pure_pursuit import PurePursuitSettings
from holonom.errors import OutOfLimits
from holonom.trace.code.loops import loop

DT = 1e-3
LAWS = [*PATH_LAWS]
STILL = Planar(0.0, 0.0, 0.0)


def ramp(distance: float, speed: float, acceleration: float = 0.8) -> np.ndarray:
    """Speeds at 1 kHz from rest to rest over a distance: smooth, and a third of a second of rest at both ends."""
    time = max(1.875 * distance / speed, math.sqrt(5.7735 * distance / acceleration))
    s = np.linspace(0.0, 1.0, round(time / DT))
    return np.pad(30.0 * s**2 * (1.0 - s) ** 2 * distance / time, 300)


def driven(*legs: tuple[float, float | None, float]) -> np.ndarray:
    """Path (N, 9) of legs (distance, forwards if above 0; curvature, None: an S that changes sign; speed)."""
    rows = []
    for distance, curvature, speed in legs:
        v = ramp(abs(distance), speed)
        s = np.cumsum(v) * DT
        k = 1.5 * np.sin(2.0 * np.pi * s / s[-1]) if curvature is None else np.full(len(v), curvature)
        v = math.copysign(1.0, distance) * v
        rows.append(np.column_stack([v, v * k]))
    twist = np.vstack(rows)
    out = np.zeros((len(twist), 9))
    pose = STILL
    for i, (v, w) in enumerate(twist):
        out[i, :3], out[i, 3], out[i, 5] = pose, v, w
        pose = pose_step(pose, Planar(v, 0.0, w), DT)
    out[:, 6], out[:, 8] = np.gradient(out[:, 3], DT), np.gradient(out[:, 5], DT)
    out[:, 7] = out[:, 3] * out[:, 5]
    return out


PATHS = {
    "line": driven((3.0, 0.0, 1.0)),
    "backwards": driven((-3.0, 0.0, 1.0)),
    "circle": driven((2.0 * np.pi, 1.0, 1.0)),
    "eight": driven((2.0 * np.pi, 1.0, 0.8), (2.0 * np.pi, -1.0, 0.8)),
    "chicane": driven((6.0, None, 1.0)),
    "chicane backwards": driven((-6.0, None, 0.8)),
    "parking": driven((1.5, 1.0, 0.6), (-1.5, -1.0, 0.6), (1.0, 0.0, 0.6)),
}


@loop(error_model="numpy")
def follow(step, params, path, start, wheelbase, steering_rate, ahead, log):
    """Drive a unicycle, or a bicycle whose steering is slow (wheelbase above 0), along a path; fill log (N, 6)."""
    pose, before, twist = start, Planar(0.0, 0.0, 0.0), Planar(0.0, 0.0, 0.0)
    memory, now = np.zeros(8), np.zeros(9)
    memory[7] = ahead
    delta = 0.0
    last = path.shape[0] - 1
    for i in range(log.shape[0]):
        phase = float(min(i, last))
        reference_at(path, phase, 1.0, 0.0, now)
        before = step(params, path, phase, now, pose, twist, before, memory)
        w = before.turn
        if wheelbase > 0.0:
            if abs(before.x) > 1e-3:
                wanted = math.atan(wheelbase * before.turn / before.x)
                delta += min(max(wanted - delta, -DT * steering_rate), DT * steering_rate)
            w = before.x * math.tan(delta) / wheelbase
        twist = Planar(before.x, 0.0, w)
        log[i, 0], log[i, 1], log[i, 2] = pose.x, pose.y, pose.turn
        log[i, 3], log[i, 4], log[i, 5] = before.x, before.y, before.turn
        pose = pose_step(pose, twist, DT)


def follow_path(
    law: PathLaw, path: np.ndarray, start: tuple[float, float, float] = (0.0, 0.0, 0.0), wheelbase: float = 0.0,
    steering_rate: float = 2.0, ahead: float = 0.0, extra: int = 500,
) -> np.ndarray:  # fmt: skip
    log = np.zeros((len(path) + extra, 6))
    follow(law.step, law.settings.params(DT), path, Planar(*start), wheelbase, steering_rate, ahead, log)
    assert np.isfinite(log).all()
    return log


def beside(log: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Distance (n,) of every 20th place from the path's places."""
    gaps = log[::20, None, :2] - path[None, ::20, :2]
    return np.sqrt((gaps**2).sum(axis=-1).min(axis=1))


@pytest.mark.parametrize("name", PATHS)
@pytest.mark.parametrize("law", LAWS)
def test_it_keeps_every_path(law: str, name: str) -> None:
    """A unicycle and a car whose steering takes half a second to its end, from the start of the path."""
    path = PATHS[name]
    for wheelbase, most in ((0.0, 0.03), (0.3, 0.06)):
        log = follow_path(PATH_LAWS.make(law, {"max_curvature": 3.0}), path, wheelbase=wheelbase)
        assert beside(log, path).max() < most, (law, name, wheelbase)
        assert np.hypot(*(log[-1, :2] - path[-1, :2])) < most, (law, name, wheelbase)
        np.testing.assert_allclose(log[-1, 3:], 0.0, atol=1e-2)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", ["line", "backwards", "circle"])
def test_errors_at_the_start_die_out(law: str, name: str) -> None:
    path = PATHS[name]
    for start in ((0.0, 0.1, 0.0), (-0.1, -0.1, 0.3), (0.05, 0.05, -0.4)):
        log = follow_path(PATH_LAWS.make(law), path, start)
        assert beside(log[-1500:], path).max() < 0.012, (law, start)


@settings(max_examples=15, deadline=None)
@given(
    st.sampled_from(sorted(PATHS)), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-4.0, 4.0),
    st.floats(0.3, 1.5), st.floats(0.5, 3.0), st.floats(0.3, 4.0), st.floats(1.0, 30.0),
    st.sampled_from([1.5, 4.0, math.inf]),
)  # fmt: skip
def test_limits_are_never_exceeded(
    name: str, x: float, y: float, turn: float, v: float, a: float, w: float, wd: float, k: float
) -> None:
    given_limits = {
        "max_speed": v, "max_acceleration": a, "max_turn_rate": w, "max_turn_acceleration": wd, "max_curvature": k,
    }  # fmt: skip
    for law in LAWS:
        log = follow_path(PATH_LAWS.make(law, given_limits), PATHS[name], (x, y, turn))
        command = np.vstack([np.zeros(3), log[:, 3:]])
        change = np.abs(np.diff(command, axis=0)) / DT
        assert np.abs(command[:, 0]).max() <= v * (1 + 1e-9)
        assert np.abs(command[:, 2]).max() <= w * (1 + 1e-9)
        assert change[:, 0].max() <= a * (1 + 1e-9)
        assert change[:, 2].max() <= wd * (1 + 1e-9)
        assert not command[:, 1].any()
        if k < math.inf:
            assert (np.abs(command[:, 2]) <= k * np.abs(command[:, 0]) * (1 + 1e-9) + 1e-12).all()


@pytest.mark.parametrize("law", LAWS)
def test_the_mirrored_path_is_driven_mirrored(law: str) -> None:
    path = PATHS["parking"]
    flip = np.array([1, -1, -1, 1, -1, -1, 1, -1, -1.0])
    one = follow_path(PATH_LAWS.make(law), path, (0.02, 0.05, 0.2))
    other = follow_path(PATH_LAWS.make(law), path * flip, (0.02, -0.05, -0.2))
    np.testing.assert_allclose(one * flip[:6], other, atol=1e-6)


@pytest.mark.parametrize("law", LAWS)
def test_backwards_is_forwards_of_a_turned_robot(law: str) -> None:
    """A path whose headings are turned by half a turn is driven with the speed reversed and the same turning."""
    path = PATHS["chicane"]
    back = path.copy()
    back[:, 2] += math.pi
    back[:, [3, 4, 6, 7]] *= -1.0
    one = follow_path(PATH_LAWS.make(law), path, (0.02, 0.05, 0.2))
    other = follow_path(PATH_LAWS.make(law), back, (0.02, 0.05, 0.2 + math.pi))
    np.testing.assert_allclose(one[:, :2], other[:, :2], atol=1e-6)
    np.testing.assert_allclose(one[:, 3:] * [-1, 1, 1], other[:, 3:], atol=1e-6)


@pytest.mark.parametrize("law", LAWS)
def test_a_base_that_stands_on_a_path_that_stands_stays(law: str) -> None:
    path = np.zeros((100, 9))
    path[:, :3] = (0.3, -0.2, 0.5)
    log = follow_path(PATH_LAWS.make(law), path, (0.3, -0.2, 0.5))
    np.testing.assert_array_equal(log[:, 3:], 0.0)


@given(st.floats(0.2, 3.0), st.booleans())
def test_gains_of_ltv_solve_the_riccati_equation(speed: float, back: bool) -> None:
    law = LtvSettings()
    v = -speed if back else speed
    Q = np.diag([1 / law.error_across**2, 1 / law.error_heading**2])
    A, B, R = np.array([[0.0, v], [0.0, 0.0]]), np.array([[0.0], [-1.0]]), np.array([[1 / law.effort_turn**2]])
    K = -np.linalg.solve(R, B.T @ solve_continuous_are(A, B, Q, R))[0]
    along, across, turn = ltv_gains(law.params(DT), v)
    np.testing.assert_allclose([across, turn], K, rtol=1e-8)
    assert along == pytest.approx(law.effort_speed / law.error_along)


def test_kanayama_is_critically_damped() -> None:
    """An error across on a line at constant speed falls as (1 + h t/2) exp(-h t/2)."""
    path = np.zeros((2500, 9))
    path[:, 0], path[:, 3] = DT * np.arange(2500), 1.0
    law = PathLaw(
        PATH_LAWS.make("kanayama").step, KanayamaSettings(max_turn_acceleration=math.inf, max_acceleration=math.inf)
    )
    log = follow_path(law, path, (0.0, 0.005, 0.0), extra=0)
    t = DT * np.arange(2500)
    np.testing.assert_allclose(log[:, 1], 0.005 * (1.0 + 3.0 * t) * np.exp(-3.0 * t), atol=1e-4)


def test_pure_pursuit_drives_the_arc_through_the_point_ahead() -> None:
    path = PATHS["line"]
    middle = len(path) // 2
    law = PATH_LAWS.make("pure_pursuit", {"min_look_ahead": 0.5, "look_ahead_time": 0.0})
    memory = np.zeros(8)
    memory[0] = middle
    v = path[middle, 3]
    y = 0.1
    pose, before = Planar(path[middle, 0], y, 0.0), Planar(v, 0.0, 2.0 * -y / 0.25 * v)
    command = law.step(law.settings.params(DT), path, float(middle), path[middle], pose, before, before, memory)
    assert command.turn / command.x == pytest.approx(-2.0 * y / 0.25, rel=2e-2)


def test_what_is_ahead_cuts_the_speed() -> None:
    law = PATH_LAWS.make("pure_pursuit", {"position_gain": 0.0})
    free = follow_path(law, PATHS["line"])[:, 3].max()
    half = follow_path(law, PATHS["line"], ahead=nearness(0.6, 1.0, 0.2))[:, 3].max()
    assert half == pytest.approx(0.5 * free, rel=1e-3)
    assert follow_path(law, PATHS["line"], ahead=nearness(0.1, 1.0, 0.2))[:, 3].max() == 0.0
    assert AHEAD == 7


def test_settings_out_of_range_are_refused() -> None:
    with pytest.raises(OutOfLimits, match="min_look_ahead"):
        PurePursuitSettings(min_look_ahead=2.0)
    for law in LAWS:
        for value in (0.0, -1.0, math.nan):
            with pytest.raises(OutOfLimits, match="max_curvature"):
                PATH_LAWS.make(law, {"max_curvature": value})
