"""A base on a slope, and weight on rockers and bogies: laws of statics and of free rolling."""

from __future__ import annotations

import math

import numpy as np
import pytest

from holonom.devices import DcMotor, Encoder, Gear
from holonom.errors import ModelError
from holonom.mobile import BaseDrive, Wheel, WheelBase, bicycle, differential, omni, rocker6, segway
from holonom.mobile.drive.base_drive import BaseSensors, load_shares, supports
from holonom.sim import BaseFault, BasePlant, Floor

MOTOR = DcMotor(
    resistance=1.0, inductance=1e-3, torque_constant=0.03, back_emf_constant=0.03, rotor_inertia=1e-5,
    max_voltage=12.0, max_current=10.0,
)  # fmt: skip
DRIVE = BaseDrive(MOTOR, Gear(10.0), Encoder(4096), wheel_inertia=2e-4, roller_drag=0.0)
QUIET = BaseSensors(0.0, 0.0, 0.0, 0.0, 0.0)
SLOPE = 0.1


@pytest.mark.parametrize("uphill", [0.0, 1.1, math.pi])
def test_a_free_base_rolls_down_as_its_inertia_lets_it(uphill: float) -> None:
    """`a = g sin(slope) M/(M + sum I/r^2)` for omni wheels without drag, whose rims run at cosines of the way."""
    base = omni(n=4, radius=0.2, wheel_radius=0.05, mass=10.0)
    dead = [BaseFault(0.0, k, "dead") for k in range(4)]
    plant = BasePlant(base, DRIVE, Floor(slope=SLOPE, uphill=uphill), faults=dead, substeps=8)
    plant.drive_open(np.zeros((500, 4)))
    away = np.array([math.cos(uphill), math.sin(uphill)])
    heavier = 10.0 + 2.0 * DRIVE.inertia / 0.05**2  # the squares of the cosines of four wheels add up to 2
    expected = -0.5 * 9.81 * math.sin(SLOPE) * 10.0 / heavier
    assert plant.twist[:2] @ away == pytest.approx(expected, rel=0.01)
    assert abs(plant.twist[2]) < 1e-6
    s = plant.state[0]
    lost = 10.0 * 9.81 * math.sin(SLOPE) * -(plant.pose[:2] @ away)
    assert plant.kinetic_energy() + s["drag"] + s["ground"] == pytest.approx(lost, rel=0.01)


def test_a_braked_base_stands_on_a_slope_and_its_accelerometer_shows_it() -> None:
    base = differential(0.4, 0.05, mass=10.0, com=(-0.1, 0.0), com_height=0.1)
    jammed = [BaseFault(0.0, k, "blocked") for k in range(2)]
    plant = BasePlant(base, DRIVE, Floor(slope=SLOPE), sensors=QUIET, faults=jammed)
    log = plant.drive_open(np.zeros((2000, 2)))
    held = Floor().material.friction(-plant.twist[0]) * log.loads[-1].sum()  # tyres creep as their slip curve has it
    assert held == pytest.approx(10.0 * 9.81 * math.sin(SLOPE), rel=0.01)
    assert plant.signals.inertial[1] == pytest.approx(9.81 * math.sin(SLOPE), rel=0.01)  # pushed up the slope
    leaning = 0.3 * math.cos(SLOPE) - 0.1 * math.sin(SLOPE)  # about the castor, 0.4 m behind: it gets what is left
    assert log.loads[-1].sum() == pytest.approx(10.0 * 9.81 * leaning / 0.4, rel=1e-3)


def test_rockers_and_bogies_balance() -> None:
    """Forces and moments about the middle; a bogie's wheels alike; both rockers equally loaded about their pivots."""
    base = rocker6(0.9, 0.6, 0.1, mass=20.0, com=(0.05, 0.03))
    at, shares = supports(base), load_shares(base)
    for moment in np.eye(3):
        loads = shares @ moment
        assert [loads.sum(), loads @ at[:, 0], loads @ at[:, 1]] == pytest.approx(moment.tolist(), abs=1e-12)
        front, middle, rear = loads[[0, 1]], loads[[2, 3]], loads[[4, 5]]
        assert middle == pytest.approx(rear)
        rockers = 0.45 * front - 0.225 * (middle + rear)
        assert rockers[0] == pytest.approx(rockers[1])
    with pytest.raises(ModelError, match="three on each side"):
        load_shares(WheelBase(base.wheels[:5], mass=1.0, suspension="rocker_bogie"))


def test_steered_wheels_beside_rollers_are_not_simulated() -> None:
    wheels = [
        Wheel.at("steered", 0.3, 0.0, radius=0.05, driven=True, name="front"),
        Wheel.at("swedish", -0.2, 0.2, radius=0.05, driven=True, name="left"),
        Wheel.at("swedish", -0.2, -0.2, radius=0.05, driven=True, name="right"),
    ]
    with pytest.raises(ModelError, match="steered wheels beside 'left'"):
        BasePlant(WheelBase(wheels, mass=5.0), DRIVE)


@pytest.mark.parametrize("com", [(0.5, 0.2), (0.3, -0.1)])
def test_wheels_on_one_line_carry_all_of_the_weight(com: tuple[float, float]) -> None:
    """Also where the centre of mass lies beside it: what holds the base upright carries the moment across."""
    rear, front = 1.0 - com[0], com[0]
    for base, expected in (
        (bicycle(1.0, 0.3, mass=10.0, com=com), (rear, front)),
        (segway(0.4, 0.1, mass=10.0, com=(com[1], 0.0)), (0.5, 0.5)),
    ):
        np.testing.assert_allclose(load_shares(base)[:, 0], expected, atol=1e-12)
