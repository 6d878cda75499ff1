"""Linear MPC: the same program solved otherwise, limits, cusps, what it says without its library."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from scipy.optimize import minimize
from test_path_laws import PATHS, beside

from holonom.control import PATH_LAWS
from holonom.control.base.kernels import Planar, pose_step
from holonom.control.path_laws.mpc import LinearMpc, MpcSettings
from holonom.errors import MissingExtra, OutOfLimits, ShapeError

TIGHT = {
    "max_speed": 1.0, "max_acceleration": 1.2, "max_turn_rate": 2.0, "max_turn_acceleration": 6.0, "max_curvature": 2.0,
}  # fmt: skip


def solved_otherwise(s: MpcSettings, path: np.ndarray, phase: int, pose: Planar, before: Planar) -> np.ndarray:
    """Commands (H, 2) by sequential quadratic programming over the commands alone, errors rolled out."""
    H, T = s.horizon, s.period
    ratio = round(T / 1e-3)
    reference = np.array([
        path[np.minimum(np.arange(phase + k * ratio, phase + (k + 1) * ratio), len(path) - 1)][:, [3, 5]].mean(axis=0)
        for k in range(H)
    ])  # fmt: skip
    x, y, theta = path[phase, :3]
    c, d = math.cos(theta), math.sin(theta)
    first = np.array([
        c * (pose.x - x) + d * (pose.y - y), c * (pose.y - y) - d * (pose.x - x), math.remainder(pose.turn - theta,
                                                                                                 2 * math.pi)
    ])  # fmt: skip

    def cost(flat: np.ndarray) -> float:
        e, total = first, 0.0
        for k, (u, r) in enumerate(zip(flat.reshape(H, 2), reference, strict=True)):
            vr, wr = r
            e = e + T * np.array([wr * e[1] + u[0] - vr, -wr * e[0] + vr * e[2], u[1] - wr])
            weight = s.end_weight if k == H - 1 else 1.0
            total += weight * ((e / [s.error_along, s.error_across, s.error_heading]) ** 2).sum()
            total += (((u - r) / [s.effort_speed, s.effort_turn]) ** 2).sum()
        return total

    change = T * np.array([s.max_acceleration, s.max_turn_acceleration])

    def room(flat: np.ndarray) -> np.ndarray:
        u = flat.reshape(H, 2)
        steps = np.diff(np.vstack([[before.x, before.turn], u]), axis=0)
        curve = s.max_curvature * u[:, 0]
        return np.concatenate([(change - steps).ravel(), (change + steps).ravel(), curve - u[:, 1], curve + u[:, 1]])

    bounds = [(-s.max_speed, s.max_speed), (-s.max_turn_rate, s.max_turn_rate)] * H
    start = np.tile([before.x, before.turn], H)
    found = minimize(
        cost, start, bounds=bounds, constraints={"type": "ineq", "fun": room}, method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 300},
    )  # fmt: skip
    assert found.success
    return found.x.reshape(H, 2)


def test_the_same_program_solved_otherwise() -> None:
    pytest.importorskip("osqp", reason="OSQP is not installed; pip install -e '.[mpc]'")
    rng = np.random.default_rng(2)
    settings = MpcSettings(horizon=6, **TIGHT)
    law = LinearMpc(settings)
    for name in ("chicane", "circle", "line"):
        path = PATHS[name]
        for phase in (len(path) // 3, len(path) // 2):
            off = rng.uniform(-1, 1, 3) * [0.1, 0.1, 0.3]
            pose, before = Planar(*(path[phase, :3] + off)), Planar(path[phase, 3], 0.0, path[phase, 5])
            before = Planar(min(before.x, 1.0), 0.0, before.turn)
            other = solved_otherwise(settings, path, phase, pose, before)
            np.testing.assert_allclose(law.plan(path, phase, pose, before)[:, [0, 2]], other, atol=2e-3)


def drive(path: np.ndarray, limits: dict[str, float], start: tuple[float, float, float]) -> np.ndarray:
    """Plan each period, drive its first command; rows (n, 6) at 1 kHz."""
    law = LinearMpc(MpcSettings(**limits))
    pose, before = Planar(*start), Planar(0.0, 0.0, 0.0)
    rows = []
    for i in range(len(path) + 1000):
        if i % 50 == 0:
            plan = law.plan(path, float(min(i, len(path) - 1)), pose, before)
            before = Planar(*plan[0])
        rows.append([*pose, *before])
        pose = pose_step(pose, before, 1e-3)
    return np.array(rows)


@pytest.mark.parametrize("name", ["line", "backwards", "circle", "chicane", "parking"])
def test_paths_are_kept_within_limits(name: str) -> None:
    pytest.importorskip("osqp", reason="OSQP is not installed; pip install -e '.[mpc]'")
    for start in ((0.0, 0.0, 0.0), (-0.05, 0.1, 0.3)):
        log = drive(PATHS[name], TIGHT, start)
        tail = log if start[1] == 0.0 else log[-1500:]
        assert beside(tail, PATHS[name]).max() < 0.03, start
        command = np.vstack([np.zeros(3), log[::50, 3:]])
        change = np.abs(np.diff(command, axis=0)) / 0.05
        assert np.abs(command[:, 0]).max() <= TIGHT["max_speed"] * (1 + 1e-9)
        assert np.abs(command[:, 2]).max() <= TIGHT["max_turn_rate"] * (1 + 1e-9)
        assert change[:, 0].max() <= TIGHT["max_acceleration"] * (1 + 1e-9)
        assert change[:, 2].max() <= TIGHT["max_turn_acceleration"] * (1 + 1e-9)
        assert (np.abs(command[:, 2]) <= TIGHT["max_curvature"] * np.abs(command[:, 0]) * (1 + 1e-9) + 1e-12).all()
        np.testing.assert_allclose(log[-1, 3:], 0.0, atol=0.02)


def test_there_is_a_plan_from_every_command_within_the_limits() -> None:
    """Also from far off, and while it rolls the other way, turning as sharply as it may."""
    pytest.importorskip("osqp", reason="OSQP is not installed; pip install -e '.[mpc]'")
    rng = np.random.default_rng(3)
    law, path = LinearMpc(MpcSettings(**TIGHT)), PATHS["parking"]
    for phase in rng.integers(0, len(path), 40):
        v = rng.uniform(-1.0, 1.0)
        w = rng.uniform(-1.0, 1.0) * min(2.0 * abs(v), 2.0)
        pose = Planar(*(path[phase, :3] + rng.uniform(-1, 1, 3) * [1.0, 1.0, 3.0]))
        assert np.isfinite(law.plan(path, int(phase), pose, Planar(v, 0.0, w))).all()


def test_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(OutOfLimits, match="whole number of ms"):
        MpcSettings(period=0.0105)
    with pytest.raises(OutOfLimits, match="horizon"):
        PATH_LAWS.make("mpc", {"horizon": 1})
    law, path, still = PATH_LAWS.make("mpc", TIGHT), PATHS["line"], Planar(0.0, 0.0, 0.0)
    with pytest.raises(ShapeError, match=r"\(N, 9\)"):
        law.program(path[:, :8], 0.0, still, still)
    with pytest.raises(ShapeError, match="finite"):
        law.program(path, 0.0, Planar(math.nan, 0.0, 0.0), still)
    with pytest.raises(OutOfLimits, match="last command"):
        law.program(path, 0.0, still, Planar(0.1, 0.0, 1.0))
    monkeypatch.setitem(sys.modules, "osqp", None)
    with pytest.raises(MissingExtra, match=r"mpc needs OSQP.*\[mpc\]"):
        law.plan(path, 0.0, still, still)
