"""Laws of paths in the closed loop: limits of every command, cusps, plans between compiled steps, skidding wheels."""

from __future__ import annotations

import copy
import dataclasses
import math

import numpy as np
import pytest

from holonom.app.about.drive_bench.bases import BASES
from holonom.app.about.drive_bench.courses import course
from holonom.closed_loop import BaseLoop, simulate_base
from holonom.control import PATH_LAWS
from holonom.errors import ModelError
from holonom.machine import BaseController, BaseSettings, Creep, ReferencePath
from holonom.mobile import WheelBase, bicycle, skid_steer
from holonom.mobile.drive.sized import sized_base_drive
from holonom.sim import BasePlant, Floor

ROLLING = ("differential", "tricycle", "bicycle", "ackermann", "dual_ackermann", "skid_steer", "rocker6")
TIGHT = {"max_speed": 0.8, "max_acceleration": 1.5, "max_turn_rate": 1.2, "max_turn_acceleration": 6.0}
DRIVES = {name: sized_base_drive(BASES[name](), 2.0, 2.0) for name in ROLLING}


def path_of(base: WheelBase, name: str = "chicane", **limits: float) -> ReferencePath:
    path = course(name, base, **limits)
    assert path is not None
    return path


def make(name: str, law: str | None, path: ReferencePath, given: dict[str, float] | None = None) -> BaseLoop:
    base, floor = BASES[name](), Floor()
    settings = BaseSettings(law=None if law is None else PATH_LAWS.make(law, given or {}))
    creep = Creep(floor.material.creep, floor.material.peak)
    controller = BaseController(base, DRIVES[name], settings, creep=creep)
    loop = BaseLoop(controller, BasePlant(base, DRIVES[name], floor, rng=np.random.default_rng(1)))
    loop.place(path.pose[0] + [0.0, 0.15, -0.2])
    controller.follow_path(np.hstack([path.pose, path.twist, path.acceleration]))
    return loop


@pytest.mark.parametrize("name", ROLLING)
def test_no_law_leaves_its_limits(name: str) -> None:
    """Beside its path, faster than the law may: speed, turning rate, their changes, and the base's turning radius."""
    base = BASES[name]()
    path, radius = path_of(base), base.turning_radius
    for law in PATH_LAWS:
        loop, commands = make(name, law, path, TIGHT), []
        state = loop.controller.state
        for _ in range(1200):
            loop.advance(1)
            commands.append((state["command_vx"][0], state["command_w"][0]))
        v, w = np.array(commands).T
        assert np.abs(v).max() > 0.3
        assert np.abs(v).max() <= TIGHT["max_speed"] * (1 + 1e-9), law
        assert np.abs(w).max() <= TIGHT["max_turn_rate"] * (1 + 1e-9), law
        assert np.abs(np.diff(v)).max() <= 1e-3 * TIGHT["max_acceleration"] * (1 + 1e-6), law
        assert np.abs(np.diff(w)).max() <= 1e-3 * TIGHT["max_turn_acceleration"] * (1 + 1e-6), law
        assert (radius * np.abs(w) <= np.abs(v) * (1 + 1e-6) + 1e-9).all(), law


@pytest.mark.parametrize("name", [*ROLLING, "swerve"])
def test_parking_with_cusps_at_its_speed(name: str) -> None:
    """Reeds-Shepp: forwards, backwards, wheels steered where it stands; driven to the end within 20 mm RMS."""
    base = BASES[name]()
    path = path_of(base, "parking")
    assert (path.twist[:, 0] < -0.3).any()
    log = simulate_base(base, sized_base_drive(base, 2.0, 2.0), path, rng=np.random.default_rng(2))
    assert log.ended == "done"
    assert np.sqrt((log.path_error**2).mean()) < 0.02
    assert log.time[-1] < path.time[-1] + 0.5, "it waits no longer than its wheels take"
    assert abs(log.heading_error[-1]) < math.radians(2.0)


@pytest.mark.parametrize("name", [name for name in BASES if name != "segway"])
def test_an_eight_at_a_metre_per_second(name: str) -> None:
    """On a dry floor every arrangement keeps circle and eight within 20 mm RMS, by its own odometry and gyro."""
    base = BASES[name]()
    for where in ("circle", "eight"):
        path = path_of(base, where)
        log = simulate_base(base, sized_base_drive(base, 2.0, 2.0), path, rng=np.random.default_rng(4))
        assert log.ended == "done"
        assert np.sqrt((log.path_error**2).mean()) < 0.02, where


def test_large_wheels_of_a_light_base_weigh_no_more_than_it() -> None:
    """A solid wheel of 0.3 m would weigh 127 kg: sized drives take no more than half of the base for all wheels."""
    base = bicycle(1.0, 0.3, mass=10.0, com=(0.5, 0.0))
    drive = sized_base_drive(base, 2.0, 2.0)
    assert drive.wheel_inertia <= 0.5 * (0.5 * 10.0 / 2) * 0.3**2
    path = path_of(base, "circle", speed=0.7, acceleration=0.6)
    log = simulate_base(base, drive, path, rng=np.random.default_rng(1))
    assert log.ended == "done"
    assert np.sqrt(np.mean(log.path_error**2)) < 0.02
    assert not log.events


def test_it_waits_for_slow_steering() -> None:
    """Wheels that take a second to turn: the path waits at cusps, and is kept all the same."""
    base = BASES["ackermann"]()
    drive = DRIVES["ackermann"]
    slow = dataclasses.replace(drive, steering=dataclasses.replace(drive.steering, max_rate=1.2))
    path = path_of(base, "parking", speed=0.5, acceleration=0.3)
    log = simulate_base(base, slow, path, rng=np.random.default_rng(2))
    assert log.ended == "done"
    assert path.time[-1] + 0.5 < log.time[-1] < path.time[-1] + 8.0
    assert np.sqrt((log.path_error**2).mean()) < 0.02


def test_plans_between_compiled_steps() -> None:
    """MPC: stepped and whole runs plan at the same moments, and give the same bits; a copy drives on by itself."""
    pytest.importorskip("osqp", reason="OSQP is not installed; pip install -e '.[mpc]'")
    path = path_of(BASES["ackermann"]())
    loops = [make("ackermann", "mpc", path) for _ in range(2)]
    loops[0].advance_logged(loops[0].buffer(730))
    for _ in range(73):
        loops[1].advance(10)
    assert loops[0].controller.state.tobytes() == loops[1].controller.state.tobytes()
    assert loops[0].plant.state.tobytes() == loops[1].plant.state.tobytes()
    other = copy.deepcopy(loops[0])
    other.advance(500)
    assert other.plant.time == pytest.approx(1.23)
    assert np.abs(other.plant.pose[:2] - path.pose[1230, :2]).max() < 0.1


def test_a_law_for_a_base_that_moves_sideways() -> None:
    base = BASES["omni"]()
    with pytest.raises(ModelError, match="moves sideways at once"):
        BaseController(base, sized_base_drive(base, 1.0, 1.0), BaseSettings(law=PATH_LAWS.make("stanley")))


def test_the_leading_axle_is_the_bases_own() -> None:
    for name, lead in (("ackermann", 0.4), ("differential", 0.3), ("dual_ackermann", 0.25)):
        controller = BaseController(BASES[name](), DRIVES[name], BaseSettings(law=PATH_LAWS.make("stanley")))
        assert controller.law is not None
        assert controller.law.settings.lead == pytest.approx(lead)  # type: ignore[union-attr]


def test_a_skid_steer_turns_as_much_as_it_is_asked_to() -> None:
    """Its effective track is wrong by a fifth; the gyro sees what is missing. Its place is known to 2 % of the way."""
    base = BASES["skid_steer"]()
    loop = make("skid_steer", None, path_of(base, "straight"))
    loop.place((0.0, 0.0, 0.0))
    way = 0.0
    for _ in range(400):
        loop.controller.follow_velocity((0.5, 0.0, math.radians(30.0)))
        loop.advance(10)
        way += 0.01 * abs(loop.plant.twist[0])
    assert math.degrees(loop.plant.twist[2]) == pytest.approx(30.0, abs=2.5)
    for _ in range(100):
        loop.controller.follow_velocity((0.0, 0.0, 0.0))
        loop.advance(10)
    begins = math.radians(30.0) * 0.5 * 0.5  # less what coming to speed takes
    assert loop.plant.pose[2] == pytest.approx(math.radians(120.0), abs=begins)
    assert np.hypot(*(loop.plant.pose - loop.controller.pose)[:2]) < 0.02 * way


@pytest.mark.parametrize("effective_track", [0.35, 0.6, 0.8])
def test_what_a_skid_steer_takes_for_its_track_hardly_counts(effective_track: float) -> None:
    base = skid_steer(0.2, 0.4, 0.05, effective_track=effective_track, mass=8.0, com_height=0.05)
    for where in ("eight", "parking"):
        path = path_of(base, where)
        log = simulate_base(base, sized_base_drive(base, 2.0, 2.0), path, rng=np.random.default_rng(6))
        assert np.sqrt((log.path_error**2).mean()) < 0.02, where
