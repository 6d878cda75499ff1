"""A payload that changes while a base drives: loads, acceleration, turning and pitch as by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from holonom.devices import DcMotor, Encoder, Gear
from holonom.errors import ModelError, OutOfLimits
from holonom.mobile import BaseDrive, differential, omni, segway, swerve
from holonom.mobile.base.payload import Payload, loaded
from holonom.sim import BaseFault, BasePlant, Floor, Material

MOTOR = DcMotor(
    resistance=1.0, inductance=1e-3, torque_constant=0.03, back_emf_constant=0.03, rotor_inertia=1e-5,
    max_voltage=24.0, max_current=20.0,
)  # fmt: skip
DRIVE = BaseDrive(MOTOR, Gear(10.0), Encoder(4096), wheel_inertia=2e-4, roller_drag=0.0)
GRAVITY, SLOPE = 9.81, 0.1
OMNI = omni(n=4, radius=0.2, wheel_radius=0.05, mass=10.0, com_height=0.1)


def test_a_loaded_base_has_the_moments_of_all_its_points() -> None:
    """Random points make the base, one more is the payload: sums over all of them."""
    rng = np.random.default_rng(5)
    m, r = rng.uniform(0.1, 2.0, 12), rng.normal([0.05, 0.02, 0.3], 0.1, (12, 3))

    def moments(m: np.ndarray, r: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        c = m @ r / m.sum()
        d = r - c
        spread = np.einsum("k,ki,kj->ij", m, d, d)
        return m.sum(), c, np.trace(spread) * np.eye(3) - spread

    mass, c, inertia = moments(m, r)
    base = swerve(wheelbase=0.6, track=0.5, wheel_radius=0.05, mass=mass, com=c[:2], com_height=c[2], inertia=inertia)
    found = loaded(base, Payload(3.0, (0.1, -0.05), 0.4))
    mass, c, inertia = moments(np.append(m, 3.0), np.vstack([r, [0.1, -0.05, 0.4]]))
    assert found.mass == pytest.approx(mass)
    assert [*found.com, found.com_height] == pytest.approx(c)
    assert found.inertia == pytest.approx(inertia)
    assert (found.driven, found.steered) == (base.driven, base.steered)


def test_loads_are_those_of_both() -> None:
    """Moments about the castor 0.4 m behind the axle."""
    base = differential(0.4, 0.05, mass=10.0, com=(-0.1, 0.0))
    plant = BasePlant(base, DRIVE, Floor())
    plant.carry(Payload(6.0, (-0.2, 0.1)))
    log = plant.drive_open(np.zeros((10, 2)))
    lever = 0.4 if base.wheels[-1].x == -0.4 else -base.wheels[-1].x
    front = GRAVITY * (10.0 * (lever - 0.1) + 6.0 * (lever - 0.2)) / lever
    assert log.loads[-1].sum() == pytest.approx(front)
    tilt = 6.0 * GRAVITY * 0.1  # about the way ahead: wheels at +-0.2 m
    assert (log.loads[-1, 0] - log.loads[-1, 1]) * 0.2 == pytest.approx(tilt)


def test_a_heavier_base_rolls_down_otherwise() -> None:
    """`a = g sin(slope) M/(M + sum I/r^2)` before and after; it goes on as it moved."""
    dead = [BaseFault(0.0, k, "dead") for k in range(4)]
    plant = BasePlant(OMNI, DRIVE, Floor(slope=SLOPE), faults=dead, substeps=8)
    rims = 2.0 * DRIVE.inertia / 0.05**2
    speed = 0.0
    for mass in (10.0, 25.0):
        if mass > 10.0:
            before = plant.pose, plant.twist
            plant.carry(Payload(15.0, (0.05, 0.0), 0.1))
            assert plant.pose == pytest.approx(before[0])
            assert plant.twist == pytest.approx(before[1])
        plant.drive_open(np.zeros((400, 4)))
        gained, speed = -plant.twist[0] - speed, -plant.twist[0]
        assert gained == pytest.approx(0.4 * GRAVITY * math.sin(SLOPE) * mass / (mass + rims), rel=0.01)


def test_off_its_middle_a_payload_swings_it() -> None:
    """On no friction a body turns about its centre of mass: base_link goes round that of both."""
    plant = BasePlant(OMNI, DRIVE, Floor(Material(0.0, 0.0, 0.1)))
    plant.carry(Payload(10.0, (0.2, 0.0)))
    plant.place((0.0, 0.0, 0.0), (0.0, -0.1, 1.0))  # its centre of mass, 0.1 m ahead, stands
    plant.drive_open(np.zeros((1000, 4)))
    assert plant.pose == pytest.approx([0.1 - 0.1 * math.cos(1.0), -0.1 * math.sin(1.0), 1.0], abs=1e-3)


def test_a_pendulum_takes_it_too() -> None:
    """A load ahead of the axle moves the rest back: where the centre of both is over the axle."""
    base = segway(0.4, 0.1, mass=10.0, com_height=0.5)
    plant = BasePlant(base, DRIVE, Floor())
    plant.carry(Payload(5.0, (0.06, 0.0), 0.7))
    rest = -math.atan2(5.0 * 0.06, 10.0 * 0.4 + 5.0 * 0.6)
    plant.lean(rest)
    plant.drive_open(np.zeros((300, 2)))
    assert plant.pitch[0] == pytest.approx(rest, abs=1e-9)
    plant.carry(Payload(0.0))
    assert plant.params.body["mass"][0] == 10.0
    with pytest.raises(ModelError, match="products of inertia"):
        plant.carry(Payload(5.0, (0.0, 0.1), 0.7))


BAD = [{"mass": -1.0}, {"mass": math.nan}, {"mass": 1.0, "com": (math.inf, 0.0)}, {"mass": 1.0, "com_height": -0.1}]


@pytest.mark.parametrize("given", BAD)
def test_bad_input(given: dict[str, object]) -> None:
    with pytest.raises(OutOfLimits, match="not below zero"):
        Payload(**given)


def test_a_base_without_mass_carries_nothing() -> None:
    with pytest.raises(ModelError, match="carries nothing"):
        loaded(omni(n=3, radius=0.2, wheel_radius=0.05), Payload(1.0))
