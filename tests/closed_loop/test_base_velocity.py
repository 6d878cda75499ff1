"""A base that is driven by velocities: within limits, the nearest it can drive, and it stops when nobody speaks."""

from __future__ import annotations

import copy
import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated_bases import BASES, DRIVE

from holonom.app.about.drive_bench.bases import BASES as ARRANGEMENTS
from holonom.closed_loop import BaseLoop
from holonom.control.base.kernels import Planar
from holonom.control.base.shaping import ShapingSettings
from holonom.control.base.shaping_kernels import AxisShape, drivable_twist, shaping_step
from holonom.errors import OutOfLimits, ShapeError
from holonom.machine import BaseController, BaseSettings, PathLimits, plan_path
from holonom.machine.base.kernels import DONE
from holonom.machine.base.paths import figure_of_eight
from holonom.mobile import WheelBase
from holonom.mobile.drive.sized import sized_base_drive
from holonom.sim import BasePlant

SHAPING = ShapingSettings(
    speed=1.0, acceleration=1.5, jerk=15.0, turn_rate=3.0, turn_acceleration=10.0, turn_jerk=100.0
)


def make(name: str = "omni 4", *, seed: int = 0, **shaping: float) -> BaseLoop:
    base = BASES[name]
    limits = ShapingSettings(**({f: getattr(SHAPING, f) for f in SHAPING.__dataclass_fields__} | shaping))
    controller = BaseController(base, DRIVE, BaseSettings(shaping=limits))
    loop = BaseLoop(controller, BasePlant(base, DRIVE, rng=np.random.default_rng(seed)))
    loop.place((0.0, 0.0, 0.0))
    return loop


def run(loop: BaseLoop, twist: tuple[float, float, float], seconds: float) -> np.ndarray:
    """Drive at 100 Hz; the true twists, one each 10 ms."""
    out = []
    for _ in range(round(100 * seconds)):
        loop.controller.follow_velocity(twist)
        loop.advance(10)
        out.append(loop.plant.twist)
    return np.array(out)


@pytest.mark.parametrize("name", ["omni 4", "omni 3", "mecanum", "differential"])
def test_it_follows(name: str) -> None:
    loop, wanted = make(name), np.array([0.5, 0.3, 1.0])
    if name == "differential":
        wanted[1] = 0.0
    reached = run(loop, tuple(wanted), 1.5)[-1]
    assert (np.abs(reached - wanted) < [0.03, 0.03, 0.06]).all(), reached
    assert np.hypot(*(loop.controller.pose - loop.plant.pose)[:2]) < 0.02


@pytest.mark.parametrize("name", ["omni 4", "differential"])
def test_limits_hold(name: str) -> None:
    """The commanded twist keeps speed, acceleration and jerk whatever is asked for; the base follows it."""
    loop, rng, said, twist = make(name), np.random.default_rng(3), [], np.zeros(3)
    for k in range(3000):
        if k % 10 == 0:
            twist = rng.uniform(-3, 3, 3) * [1, 1, 4] if k % 300 == 0 else twist
            loop.controller.follow_velocity(twist)
        loop.advance(1)
        state = loop.controller.state[0]
        said.append([state[f"shaped_{n}"] for n in ("vx", "vy", "w")])
    v = np.array(said)
    for axis, (speed, acceleration, jerk) in enumerate([(1.0, 1.5, 15.0)] * 2 + [(3.0, 10.0, 100.0)]):
        a = np.diff(v[:, axis]) / 1e-3
        assert np.abs(v[:, axis]).max() <= speed + 1e-9
        assert np.abs(a).max() <= acceleration + 1e-6
        assert np.abs(np.diff(a)).max() / 1e-3 <= jerk + 1e-3
    assert np.abs(v[:, 0]).max() > 0.2
    if name == "differential":
        assert (v[:, 1] == 0.0).all()


@pytest.mark.parametrize("name", ["swerve", "ackermann", "rocker6", "tricycle"])
def test_accelerations_hold_while_wheels_are_steered(name: str) -> None:
    """What waits for wheels is driven on within the limits, not at once when they are there; the base follows it."""
    base, rng = ARRANGEMENTS[name](), np.random.default_rng(4)
    drive = sized_base_drive(base, 2.0, 2.0)
    loop = BaseLoop(BaseController(base, drive, BaseSettings(shaping=SHAPING)), BasePlant(base, drive, rng=rng))
    loop.place((0.0, 0.0, 0.0))
    said, true, twist = [], [], np.zeros(3)
    for k in range(2400):
        if k % 10 == 0:
            twist = rng.uniform(-1, 1, 3) * [1, 1, 2] if k % 600 == 0 else twist
            loop.controller.follow_velocity(twist)
        loop.advance(1)
        state = loop.controller.state[0]
        said.append([state[f"ref_{n}"] for n in ("vx", "vy", "w")])
        true.append(loop.plant.twist)
    v = np.array(said)
    assert (np.abs(np.diff(v, axis=0)).max(axis=0) <= 1e-3 * np.array([1.5, 1.5, 10.0]) * (1 + 1e-9)).all()
    assert np.abs(v).max(axis=0)[[0, 2]].min() > 0.2, "it gets there"
    assert np.sqrt(np.mean((v - true) ** 2, axis=0))[0] < 0.1


@settings(max_examples=30)
@given(start=st.floats(-2, 2), goal=st.floats(-2, 2))
def test_a_speed_is_reached_without_overshoot(start: float, goal: float) -> None:
    shape, v, a, dt = AxisShape(2.0, 3.0, 30.0), start, 0.0, 1e-3
    seen = []
    for _ in range(3000):
        v, a = shaping_step(dt, shape, v, a, goal)
        seen.append(v)
    assert v == pytest.approx(goal, abs=1e-7)
    low, high = min(start, goal), max(start, goal)
    assert low - 1e-9 <= min(seen)
    assert max(seen) <= high + 1e-9
    distance = abs(goal - start)
    least = 2 * np.sqrt(distance / 30.0) if distance < 9.0 / 30.0 else distance / 3.0 + 3.0 / 30.0
    arrived = int(np.argmax(np.abs(np.array(seen) - goal) < 1e-3)) * dt
    assert arrived <= least + 0.01, "time optimal, to some samples"


def test_silence_stops_it() -> None:
    loop = make()
    run(loop, (0.5, 0.0, 0.0), 1.0)
    loop.advance(150)
    assert loop.plant.twist[0] > 0.45, "within the time-out it goes on"
    assert loop.controller.silence == ""
    loop.advance(800)
    assert np.abs(loop.plant.twist).max() < 0.01
    assert 0.5 < loop.plant.pose[0] < 1.0
    assert loop.controller.silence == "the level above is silent: no velocity came for 960 ms"


def test_it_drives_the_nearest_twist_and_no_faster_than_its_wheels() -> None:
    loop = make("differential")
    reached = run(loop, (0.4, 0.7, 0.0), 1.0)[-1]
    np.testing.assert_allclose(reached, [0.4, 0.0, 0.0], atol=0.03)
    fast = make(speed=50.0, acceleration=100.0, jerk=1e4)
    fast.controller.follow_velocity((20.0, 10.0, 0.0))
    fast.advance(150)
    goal = np.array([fast.controller.state[0][f"shaped_{n}"] for n in ("vx", "vy")])
    rims = fast.controller.work.rows[:, :2] @ goal
    assert np.abs(rims).max() <= fast.controller.params.max_rim + 1e-9
    assert goal[0] == pytest.approx(2.0 * goal[1], rel=1e-4), "its direction stays"


@pytest.mark.parametrize("wrong", [(np.nan, 0, 0), (1, 2), "abc", (np.inf, 0, 0), None])
def test_a_bad_twist_is_refused_and_the_last_one_stays(wrong: object) -> None:
    loop = make()
    loop.controller.follow_velocity((0.2, 0.0, 0.0))
    with pytest.raises(ShapeError, match="three finite numbers"):
        loop.controller.follow_velocity(wrong)
    assert loop.controller.state["wanted_vx"][0] == 0.2


def test_it_holds_its_place() -> None:
    loop = make()
    run(loop, (0.3, 0.2, 0.5), 1.0)
    loop.controller.hold()
    loop.advance(1500)
    there = loop.plant.pose
    loop.advance(1000)
    assert np.abs(loop.plant.pose - there).max() < 2e-3
    assert np.abs(loop.plant.twist).max() < 0.02


def test_stepped_and_whole_runs_give_the_same_bits() -> None:
    path = plan_path(figure_of_eight(1.0), PathLimits(0.8, 1.5))
    reference = np.hstack([path.pose, path.twist, path.acceleration])
    loops = [make(seed=7) for _ in range(3)]
    for loop in loops:
        loop.place(reference[0, :3])
        loop.controller.follow_path(reference)
    log = loops[0].buffer(500)
    for _ in range(4):
        loops[0].advance_logged(log)
    for _ in range(200):
        loops[1].advance(10)
    loops[2].advance(2000)
    for loop in loops[1:]:
        assert loop.plant.state.tobytes() == loops[0].plant.state.tobytes()
        assert loop.controller.state.tobytes() == loops[0].controller.state.tobytes()
        assert loop.controller.states.tobytes() == loops[0].controller.states.tobytes()


def test_a_copy_goes_on_as_the_original_would() -> None:
    loop = make(seed=3)
    run(loop, (0.4, -0.2, 0.8), 0.5)
    other = copy.deepcopy(loop)
    run(loop, (0.1, 0.3, -0.5), 0.5)
    assert other.plant.time == pytest.approx(0.5)
    run(other, (0.1, 0.3, -0.5), 0.5)
    assert other.plant.state.tobytes() == loop.plant.state.tobytes()
    assert other.controller.states.tobytes() == loop.controller.states.tobytes()


def test_a_path_ends_and_is_held() -> None:
    loop = make()
    path = plan_path([[0.0, 0.0], [0.4, 0.1], [0.8, 0.0]], PathLimits(0.8, 1.5))
    loop.controller.follow_path(np.hstack([path.pose, path.twist, path.acceleration]))
    loop.advance(len(path.time) + 500)
    assert loop.controller.ending == DONE
    np.testing.assert_allclose(loop.plant.pose, [0.8, 0.0, 0.0], atol=0.01)
    assert np.abs(loop.plant.twist).max() < 0.02


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (-0.1, 0.08, 0.4)])
def test_a_differential_base_keeps_a_path_along_its_heading(offset: tuple[float, float, float]) -> None:
    path = plan_path(figure_of_eight(3.0), PathLimits(0.8, 1.0), heading="tangent")
    reference = np.hstack([path.pose, path.twist, path.acceleration])
    loop = make("differential")
    loop.place(reference[0, :3] + offset)
    loop.controller.follow_path(reference)
    log = loop.buffer(len(path.time))
    done = loop.advance_logged(log)
    error = np.hypot(log.body["x"] - log.controlled["ref_x"], log.body["y"] - log.controlled["ref_y"])[:done]
    assert error[2500:].max() < 0.05
    assert loop.controller.ending == DONE


def test_settings_are_checked() -> None:
    for name in ("speed", "jerk", "timeout"):
        with pytest.raises(OutOfLimits, match=name):
            ShapingSettings(**{name: 0.0})
    assert ShapingSettings(timeout=float("inf")).timeout == float("inf")


def test_twists_within_the_dead_band_are_rest() -> None:
    loop = make(dead_band=0.05, turn_dead_band=0.1)
    quiet = run(loop, (0.03, -0.03, 0.09), 0.3)
    assert np.abs(quiet).max() < 5e-3
    for heard in ((0.04, 0.04, 0.0), (0.0, 0.0, 0.11)):
        assert np.abs(run(make(dead_band=0.05, turn_dead_band=0.1), heard, 0.5)[-1]).max() > 0.03


def test_limits_across_are_their_own() -> None:
    loop = make(side_speed=0.2, side_acceleration=0.4, side_jerk=4.0)
    said = []
    for _ in range(1500):
        loop.controller.follow_velocity((0.6, 0.6, 0.0))
        loop.advance(1)
        said.append([loop.controller.state[f"shaped_{name}"][0] for name in ("vx", "vy")])
    v = np.array(said)
    assert v[-1] == pytest.approx([0.6, 0.2], abs=1e-3)
    a = np.diff(v, axis=0) / 1e-3
    assert a[:, 1].max() == pytest.approx(0.4, rel=1e-6)
    assert np.abs(np.diff(a[:, 1])).max() / 1e-3 <= 4.0 * (1 + 1e-6)
    assert a[:, 0].max() > 1.4


def test_nan_is_refused_and_after_the_time_out_it_stops() -> None:
    """A level above that goes on with NaN says nothing: the base stops as if it were silent."""
    loop = make()
    run(loop, (0.5, 0.0, 0.0), 0.6)
    for _ in range(100):
        with pytest.raises(ShapeError, match="three finite numbers"):
            loop.controller.follow_velocity((math.nan, 0.0, 0.0))
        loop.advance(10)
    assert np.abs(loop.plant.twist).max() < 0.01
    assert "is silent" in loop.controller.silence


@pytest.mark.parametrize("name", ARRANGEMENTS)
def test_what_is_too_fast_keeps_its_direction(name: str) -> None:
    """Of every arrangement: twice what its wheels reach is driven at what they reach, the same way."""
    base = ARRANGEMENTS[name]()
    radius, rng = base.radius, np.random.default_rng(5)
    drivable, rows = base.steerable, np.ascontiguousarray(base.rest_coupling * [1.0, 1.0, radius])
    for _ in range(50):
        asked = base.feasible(rng.normal(size=3) * [2.0, 2.0, 2.0 / radius])
        if base.steered:
            rows = np.ascontiguousarray(driven_rows(base, asked))
        found = np.array(drivable_twist(drivable, rows, Planar(*asked), 0.5))
        rims = rows @ asked
        part = min(1.0, 0.5 / max(np.abs(rims).max(), 1e-12))
        np.testing.assert_allclose(found, part * asked, atol=1e-9)
        assert np.abs(rows @ found).max() <= 0.5 * (1 + 1e-9)


def driven_rows(base: WheelBase, twist: np.ndarray) -> np.ndarray:
    """(m, 3) rims per twist, at the angles to which wheels are steered for it."""
    rows = base.rolling_matrix(base.steering(twist))
    return rows[[base.rolling_names.index(name) for name in base.driven]]


@pytest.mark.parametrize("acceleration", [20.0, 200.0])
def test_angles_are_asked_for_within_what_steering_motors_can(acceleration: float) -> None:
    """Set-points of a swerve drive that is told every way: rate and acceleration, never beyond."""
    base = ARRANGEMENTS["swerve"]()
    drive = sized_base_drive(base, 1.0, 1.0)
    motor = dataclasses.replace(drive.steering, max_rate=4.0, max_torque=1.0, inertia=1.0 / acceleration)
    drive = dataclasses.replace(drive, steering=motor)
    loop = BaseLoop(BaseController(base, drive), BasePlant(base, drive, rng=np.random.default_rng(0)))
    loop.place((0.0, 0.0, 0.0))
    rng, angles = np.random.default_rng(1), []
    for k in range(2500):
        if k % 250 == 0:
            loop.controller.follow_velocity(rng.normal(size=3) * [0.4, 0.4, 1.0])
        loop.advance(1)
        angles.append(loop.plant.signals.steering.copy())
    rates = np.diff(angles, axis=0) / 1e-3
    assert np.abs(rates).max() == pytest.approx(4.0, rel=1e-6)
    assert np.abs(np.diff(rates, axis=0)).max() / 1e-3 <= acceleration * (1 + 1e-6)


def test_what_is_too_sharp_is_driven_on_the_tightest_curve() -> None:
    base = ARRANGEMENTS["ackermann"]()
    drive = sized_base_drive(base, 1.0, 1.0)
    loop = BaseLoop(BaseController(base, drive), BasePlant(base, drive, rng=np.random.default_rng(0)))
    loop.place((0.0, 0.0, 0.0))
    reached = run(loop, (0.4, 0.0, 3.0), 2.0)[-1]
    assert reached[0] == pytest.approx(0.4, abs=0.03)
    assert reached[2] == pytest.approx(0.4 / base.turning_radius, rel=0.05)


def test_it_turns_about_a_place_of_its_own() -> None:
    """That place stays where it is, wherever on the base it lies; a place that is none is refused."""
    loop, place = make("omni 4"), np.array([0.3, -0.1])

    def there() -> np.ndarray:
        x, y, theta = loop.plant.pose
        c, s = np.cos(theta), np.sin(theta)
        return np.array([x + c * place[0] - s * place[1], y + s * place[0] + c * place[1]])

    start = there()
    for _ in range(200):
        loop.controller.follow_velocity((0.0, 0.0, 1.0), about=place)
        loop.advance(10)
    assert loop.plant.pose[2] > 1.5
    assert np.hypot(*(there() - start)) < 0.03
    with pytest.raises(ShapeError, match="about"):
        loop.controller.follow_velocity((0.0, 0.0, 1.0), about=(np.nan, 0.0))
