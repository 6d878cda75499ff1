"""Steps across the floor: energy of climbing, wheels that come up one by one, edges that stop a base."""

from __future__ import annotations

import math

import numpy as np
import pytest

from holonom.devices import DcMotor, Encoder, Gear
from holonom.errors import OutOfLimits
from holonom.mobile import BaseDrive, WheelBase, differential, omni, segway, swerve
from holonom.sim import BaseFault, BasePlant, Floor, Step

MOTOR = DcMotor(
    resistance=1.0, inductance=1e-3, torque_constant=0.03, back_emf_constant=0.03, rotor_inertia=1e-5,
    max_voltage=24.0, max_current=20.0,
)  # fmt: skip
DRIVE = BaseDrive(MOTOR, Gear(10.0), Encoder(4096), wheel_inertia=2e-4, roller_drag=0.0)
MASS, GRAVITY, RADIUS, HEIGHT = 10.0, 9.81, 0.05, 0.015
TROLLEY = differential(0.4, RADIUS, mass=MASS, com=(-0.05, 0.0))
OMNI = omni(n=4, radius=0.2, wheel_radius=RADIUS, mass=MASS)
SWERVE = swerve(wheelbase=0.4, track=0.3, wheel_radius=RADIUS, mass=MASS)


def free(base: WheelBase, floor: Floor, speed: float, way: float = 0.0, substeps: int = 20) -> BasePlant:
    """A base without motors that rolls, its wheels steered and rolling."""
    dead = [BaseFault(0.0, k, "dead") for k in range(len(base.driven))]
    plant = BasePlant(base, DRIVE, floor, faults=dead, substeps=substeps)
    plant.place((0.0, 0.0, 0.0), (speed * math.cos(way), speed * math.sin(way), 0.0))
    return plant


@pytest.mark.parametrize("base", [OMNI, SWERVE])
@pytest.mark.parametrize("way", [0.0, 0.4])
def test_climbing_costs_weight_times_height_and_gives_it_back(base: WheelBase, way: float) -> None:
    """All wheels up, then all down: kinetic energy and what slips away add up to the way up, then to nothing."""
    there = (math.cos(way), math.sin(way))
    up = Step((0.5 * there[0], 0.5 * there[1]), HEIGHT, way)
    down = Step((1.4 * there[0], 1.4 * there[1]), HEIGHT, way + math.pi)
    plant = free(base, Floor(steps=(up, down)), 1.5, way)
    start = plant.kinetic_energy()
    while plant.pose[:2] @ there < 0.95:
        plant.drive_open(np.zeros((10, len(base.driven))))
    s = plant.state[0]
    lost = MASS * GRAVITY * HEIGHT
    assert s["lifted"] == pytest.approx(lost, rel=0.02)
    assert start - plant.kinetic_energy() - s["ground"] - s["drag"] == pytest.approx(lost, rel=0.02)
    while plant.pose[:2] @ there < 1.9:
        plant.drive_open(np.zeros((10, len(base.driven))))
    assert abs(s["lifted"]) < 0.02 * lost
    assert start - plant.kinetic_energy() - s["ground"] - s["drag"] == pytest.approx(0.0, abs=0.02 * lost)
    assert plant.pose[2] == pytest.approx(0.0, abs=0.05)


def test_too_slow_it_rolls_back_with_its_speed() -> None:
    """No more comes back than came, and little less."""
    plant = free(OMNI, Floor(steps=(Step((0.3, 0.0), HEIGHT),)), 0.2)
    before = plant.kinetic_energy()
    most = 0.0
    for _ in range(100):
        plant.drive_open(np.zeros((10, 4)))
        most = max(most, float(plant.pose[0]))
    assert most < 0.3
    assert plant.twist[0] < 0.0
    assert 0.9 * before < plant.kinetic_energy() <= before * 1.001


@pytest.mark.parametrize("height", [RADIUS, 0.08, 1.0])
@pytest.mark.parametrize("speed", [0.3, 2.0])
def test_a_high_edge_stops_it(height: float, speed: float) -> None:
    """It hardly bounces: what it came with is lost there; motors that go on pushing get no further."""
    plant = BasePlant(TROLLEY, DRIVE, Floor(steps=(Step((1.0, 0.0), height),)))
    plant.place((0.0, 0.0, 0.0), (speed, 0.0, 0.0))
    log = plant.drive_open(np.full((4000, 2), 8.0))
    assert np.isfinite(log.pose).all()
    assert np.isfinite(log.energy).all()
    assert plant.pose[0] == pytest.approx(1.0 - RADIUS, abs=0.01)
    assert abs(plant.twist[0]) < 0.01
    assert log.twist[:, 0].min() > -0.1 * log.twist[:, 0].max()


def test_without_force_enough_it_stands_at_the_edge() -> None:
    """The slope is steepest at first touch: less than its tangent times the load does not climb."""
    steep = math.sqrt(2.0 * RADIUS * 0.04 - 0.04**2) / (RADIUS - 0.04)
    touch = math.sqrt(2.0 * RADIUS * 0.04 - 0.04**2)
    assert steep > 0.8  # more than the floor's friction
    plant = BasePlant(OMNI, DRIVE, Floor(steps=(Step((0.6, 0.0), 0.04),)))
    volts = 1.0 * OMNI.wheel_speeds([1.0, 0.0, 0.0]) / np.abs(OMNI.wheel_speeds([1.0, 0.0, 0.0])).max()
    log = plant.drive_open(np.tile(volts, (4000, 1)))
    front = max(w.x for w in OMNI.wheels)
    assert plant.pose[0] + front == pytest.approx(0.6 - touch, abs=5e-3)
    assert np.isfinite(log.pose).all()


def test_an_edge_that_lies_askew_turns_the_base() -> None:
    """It pushes first at the wheel that comes to it first, and holds that one back."""
    for rise in (-0.3, 0.3):
        plant = free(TROLLEY, Floor(steps=(Step((0.3, 0.0), HEIGHT, rise),)), 1.0)
        while plant.pose[0] < 0.25:
            plant.drive_open(np.zeros((5, 2)))
        assert plant.twist[2] * rise > 0.02


def test_a_pendulum_pays_for_its_climb_too() -> None:
    base = segway(0.4, 0.1, mass=MASS, com_height=0.08, inertia=(0.3, 0.25, 0.1))  # hanging, so that it stays up
    plant = free(base, Floor(steps=(Step((0.4, 0.0), 0.02),)), 1.5)
    start, low = plant.kinetic_energy(), MASS * GRAVITY * -0.02
    plant.drive_open(np.zeros((600, 2)))
    s = plant.state[0]
    assert plant.pose[0] > 0.5
    swung = MASS * GRAVITY * -0.02 * math.cos(float(plant.pitch[0])) - low
    gone = start - plant.kinetic_energy() - swung - s["ground"] - s["drag"]
    assert gone == pytest.approx(s["lifted"], abs=0.02 * s["lifted"])
    assert s["lifted"] == pytest.approx(MASS * GRAVITY * 0.02, rel=0.1)  # its load is not steady while it swings


def test_bad_input() -> None:
    with pytest.raises(OutOfLimits, match="height is 0"):
        Step((0.0, 0.0), 0.0)
    with pytest.raises(OutOfLimits, match="finite numbers are needed"):
        Step((math.nan, 0.0), 0.01)
    with pytest.raises(OutOfLimits, match="finite numbers are needed"):
        Step((0.0, 0.0), 0.01, math.inf)
