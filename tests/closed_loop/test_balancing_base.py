"""Bases that balance: up from a lean and after a push, back in their place, along paths and by velocities; falls."""

from __future__ import annotations

import math

import numpy as np
import pytest

from holonom.closed_loop import BaseLoop, simulate_base
from holonom.control import BALANCE_LAWS
from holonom.devices import DcMotor, Encoder, Gear
from holonom.errors import ModelError
from holonom.machine import PATHS, BaseController, BaseSettings, PathLimits, plan_path
from holonom.machine.base.balancing import leaning_path, pendulum_of
from holonom.mobile import BaseDrive, segway
from holonom.mobile.base.payload import Payload
from holonom.mobile.drive.base_drive import BaseSensors
from holonom.sim import BasePlant, Floor, Material, Step

MOTOR = DcMotor(
    resistance=0.6, inductance=0.3e-3, torque_constant=0.03, back_emf_constant=0.03, rotor_inertia=2e-5,
    max_voltage=24.0, max_current=20.0,
)  # fmt: skip
DRIVE = BaseDrive(MOTOR, Gear(12.0, 0.9), Encoder(4096), wheel_inertia=2e-3)
BASE = segway(0.4, 0.1, mass=10.0, com_height=0.45, inertia=(0.3, 0.25, 0.12))
AHEAD = segway(0.4, 0.1, mass=10.0, com=(0.03, 0.0), com_height=0.45, inertia=(0.3, 0.25, 0.12))
LAWS = list(BALANCE_LAWS)


def standing(law: str, lean: float = 0.0, base: object = BASE, floor: Floor = Floor()) -> BaseLoop:
    rng = np.random.default_rng(1)
    plant = BasePlant(base, DRIVE, floor, sensors=BaseSensors(), rng=rng)
    loop = BaseLoop(BaseController(base, DRIVE, BaseSettings(balance=BALANCE_LAWS.make(law))), plant)
    loop.place((0.0, 0.0, 0.0), lean=lean)
    return loop


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("lean", [8.0, -8.0])
def test_it_stands_up_and_comes_back(law: str, lean: float) -> None:
    loop = standing(law, math.radians(lean))
    loop.advance(8000)
    assert loop.plant.tipped is None
    assert np.hypot(*loop.plant.pose[:2]) < 0.02
    assert abs(loop.plant.pitch[0]) < math.radians(0.5)
    assert abs(loop.plant.pose[2]) < math.radians(0.5)


@pytest.mark.parametrize("law", LAWS)
def test_a_push(law: str) -> None:
    """A blow that turns the body at 45 deg/s."""
    loop = standing(law)
    loop.advance(1000)
    loop.plant.state["pitch_rate"] += math.radians(45.0)
    most = 0.0
    for _ in range(700):
        loop.advance(10)
        most = max(most, abs(float(loop.plant.pitch[0])))
    assert math.radians(2.0) < most < math.radians(15.0)
    assert np.hypot(*loop.plant.pose[:2]) < 0.03


@pytest.mark.parametrize("law", LAWS)
def test_a_figure_of_eight_at_a_metre_a_second(law: str) -> None:
    path = plan_path(PATHS.make("figure_of_eight", {"size": 5.0}), PathLimits(1.0, 1.0), heading="tangent")
    settings = BaseSettings(balance=BALANCE_LAWS.make(law))
    log = simulate_base(BASE, DRIVE, path, settings=settings, rng=np.random.default_rng(1))
    assert log.ended == "done"
    assert math.sqrt(np.mean(log.path_error**2)) < 0.02


@pytest.mark.parametrize("law", LAWS)
def test_velocities(law: str) -> None:
    """It runs the other way first, then as it is told; its centre of mass off the middle."""
    loop = standing(law, base=AHEAD)
    loop.advance(2000)
    least = 0.0
    for _ in range(500):
        loop.controller.follow_velocity((0.6, 0.0, 0.5))
        loop.advance(10)
        least = min(least, float(loop.plant.twist[0]))
    assert -0.3 < least < -0.01
    assert loop.plant.twist[[0, 2]] == pytest.approx([0.6, 0.5], abs=0.05)
    assert loop.plant.pitch[0] == pytest.approx(-math.atan2(0.03, 0.35), abs=math.radians(1.5))


def test_a_fall_ends_the_run() -> None:
    """From 35 degrees with motors that are too weak, under either law."""
    weak = DcMotor(0.6, 0.3e-3, 0.03, 0.03, 2e-5, 24.0, 6.0)
    for law in LAWS:
        drive = BaseDrive(weak, Gear(12.0, 0.9), Encoder(4096), wheel_inertia=2e-3)
        plant = BasePlant(BASE, drive)
        loop = BaseLoop(BaseController(BASE, drive, BaseSettings(balance=BALANCE_LAWS.make(law))), plant)
        loop.place((0.0, 0.0, 0.0), lean=math.radians(35.0))
        log = loop.buffer(2000)
        done = loop.advance_logged(log)
        assert plant.tipped is not None
        assert done == round(plant.tipped * 1e3)
        assert abs(plant.pitch[0]) > math.pi / 3.0
        assert not loop.going_on


def test_a_path_that_is_too_hard_for_it() -> None:
    """A floor without the grip that 4 m/s2 take."""
    path = plan_path(np.array([[0.0, 0.0], [8.0, 0.0]]), PathLimits(3.0, 4.0), heading="tangent")
    slick = Floor(Material(0.2, 0.15, 0.05))
    log = simulate_base(BASE, DRIVE, path, floor=slick, rng=np.random.default_rng(1))
    assert log.ended == "fell"
    assert "fell after" in log.events[-1].text


def test_how_it_leans_for_a_path() -> None:
    """`t^2 phi'' = phi - k a`, and nothing long before and after; a steady acceleration takes k a."""
    body = pendulum_of(BASE, DRIVE, 100.0)
    t = 1e-3 * np.arange(8000)
    a = np.exp(-(((t - 4.0) / 0.5) ** 2)) * np.sin(5.0 * t)
    lean = leaning_path(body, a, 1e-3)
    second = np.gradient(np.gradient(lean[:, 0], 1e-3), 1e-3)
    assert body.time**2 * second == pytest.approx(lean[:, 0] - body.lean * a, abs=1e-4)
    assert np.abs(lean[[0, -1]]).max() < 1e-4
    assert lean[:, 2] == pytest.approx(body.rolling * a + body.coupling * second, abs=0.05)
    steady = leaning_path(body, np.ones(8000), 1e-3)[4000]
    assert steady == pytest.approx([body.lean, 0.0, body.rolling], abs=1e-6)


def test_a_body_that_hangs_is_refused() -> None:
    with pytest.raises(ModelError, match="has it above its axle"):
        BaseController(segway(0.4, 0.1, mass=10.0, com_height=0.05), DRIVE)


def test_ideal_drives_hold_it_upright() -> None:
    plant = BasePlant(BASE, DRIVE, ideal=True)
    loop = BaseLoop(BaseController(BASE, DRIVE, BaseSettings().without_motors()), plant)
    loop.place((0.0, 0.0, 0.0))
    for _ in range(100):
        loop.controller.follow_velocity((0.5, 0.0, 0.0))
        loop.advance(10)
    assert plant.twist[0] == pytest.approx(0.5, abs=1e-3)
    assert plant.pitch[0] == 0.0


@pytest.mark.parametrize("law", LAWS)
def test_over_a_step_of_twenty_millimetres(law: str) -> None:
    """Up and down again at 0.7 m/s; nobody tells its controller."""
    floor = Floor(steps=(Step((1.5, 0.0), 0.02), Step((3.0, 0.0), 0.02, math.pi)))
    path = plan_path(np.array([[0.0, 0.0], [4.5, 0.0]]), PathLimits(0.7, 0.5), heading="tangent")
    settings = BaseSettings(balance=BALANCE_LAWS.make(law))
    log = simulate_base(BASE, DRIVE, path, floor=floor, settings=settings, rng=np.random.default_rng(1))
    assert log.ended == "done"
    assert log.path_error.max() < 0.15
    assert log.path_error[-1] < 0.04


def test_at_an_edge_too_steep_for_its_motors_no_motor_is_given_up() -> None:
    """It comes too slowly to roll over: what stands there is not jammed."""
    floor = Floor(steps=(Step((0.6, 0.0), 0.03),))
    loop = standing("lqr", floor=floor)
    for _ in range(400):
        loop.controller.follow_velocity((0.15, 0.0, 0.0))
        loop.advance(10)
        if loop.plant.tipped is not None:
            break
    assert loop.controller.state["dead"] == 0


@pytest.mark.parametrize("law", LAWS)
def test_it_stands_on_a_slope(law: str) -> None:
    """It learns the slope of 3 degrees, and comes back to its place."""
    loop = standing(law, floor=Floor(slope=math.radians(3.0)))
    loop.advance(40_000)
    assert loop.plant.tipped is None
    assert abs(loop.plant.twist[0]) < 0.03  # motors that stick let it rock a little
    assert abs(loop.plant.pose[0]) < 0.08


@pytest.mark.parametrize("law", LAWS)
def test_a_payload_that_nobody_told_of(law: str) -> None:
    """3 kg, 50 mm ahead of the axle: it leans back, and comes back to its place."""
    loop = standing(law)
    loop.advance(1000)
    loop.plant.carry(Payload(3.0, (0.05, 0.0), 0.3))
    most = 0.0
    for _ in range(400):
        loop.advance(100)
        most = max(most, abs(float(loop.plant.pose[0])))
    rest = -math.atan2(3.0 * 0.05, 10.0 * 0.35 + 3.0 * 0.2)
    assert loop.plant.pitch[0] == pytest.approx(rest, abs=math.radians(0.5))
    assert 0.02 < most < 0.4
    assert abs(loop.plant.pose[0]) < 0.04
