"""Bodies as they are in the simulated base and in its controller: centre of mass, rollers' angle, wheels that lift."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from simulated_bases import DRIVE, LOSSLESS, soccer

from holonom.closed_loop import BaseLoop, simulate_base
from holonom.machine import BaseController, Creep, PathLimits, plan_path
from holonom.machine.base.paths import circle
from holonom.machine.base.wheel_kernels import creep
from holonom.mobile import SlipStatus, Wheel, WheelBase, arrangements
from holonom.mobile.base.wheel_base import WheelBase as Base
from holonom.sim import CARPET, BasePlant, Floor, Material

SLICK = Floor(Material(0.0, 0.0, 0.1))
COM = (0.02, -0.01)


def test_a_body_turns_about_its_centre_of_mass() -> None:
    """Without any force that goes straight on, and base_link circles about it."""
    plant = BasePlant(soccer(com=COM), LOSSLESS, SLICK)
    plant.place((0.1, 0.2, 0.3), (0.5, -0.2, 4.0))
    np.testing.assert_allclose(plant.pose, [0.1, 0.2, 0.3], atol=1e-15)
    np.testing.assert_allclose(plant.twist, [0.5, -0.2, 4.0], atol=1e-15)
    plant.drive_open(np.zeros((1000, 4)))

    def world(theta: float, v: complex) -> complex:
        return complex(np.exp(1j * theta) * v)

    c, v = complex(*COM), complex(0.5, -0.2)
    start = complex(0.1, 0.2) + world(0.3, c)
    end = start + world(0.3, v + 4.0j * c) - world(4.3, c)
    np.testing.assert_allclose(plant.pose, [end.real, end.imag, 4.3], atol=1e-6)


def test_energy_balances_wherever_the_centre_of_mass_is() -> None:
    plant = BasePlant(soccer(com=COM), DRIVE)
    u = 6.0 * np.sin(np.outer(0.01 * np.arange(500), [1.0, 1.7, 2.3, 0.9]))
    log = plant.drive_open(u)
    _, _, airgap, drag, ground = (plant.state[0][n] for n in ("supplied", "heat", "airgap", "drag", "ground"))
    assert abs(airgap - drag - ground - plant.kinetic_energy()) < 1e-9 * airgap
    np.testing.assert_allclose(log.loads[5:].sum(axis=1), 6.35 * 9.81, rtol=1e-9)


def test_motion_is_that_of_newton_and_euler() -> None:
    """An independent simulation: slip forces by the magic formula, the body about its centre of mass, by SciPy."""
    base = soccer(com=COM, com_height=0.0)
    plant = BasePlant(base, LOSSLESS, substeps=20)
    speeds = np.array([12.0, -9.0, 7.0, 5.0])  # wheels that are held at these speeds
    mass, inertia = 6.35, 0.5 * 6.35 * 0.0789**2
    c = np.array(COM)
    at = np.array([(w.x, w.y) for w in plant.base.wheels if w.driven]) - c
    along = np.array([(np.cos(w.heading), np.sin(w.heading)) for w in plant.base.wheels if w.driven])
    A = np.vstack([np.ones(4), at.T])
    loads = np.linalg.pinv(A) @ [mass * 9.81, 0.0, 0.0]
    rim = 0.02711 * speeds

    def rate(_: float, s: np.ndarray) -> np.ndarray:
        vx, vy, w = s
        ground = along[:, 0] * (vx - w * at[:, 1]) + along[:, 1] * (vy + w * at[:, 0])
        f = loads * [CARPET.friction(x) for x in rim - ground]
        fx, fy = f @ along
        torque = f @ (at[:, 0] * along[:, 1] - at[:, 1] * along[:, 0])
        return np.array([fx / mass + w * vy, fy / mass - w * vx, torque / inertia])

    plant.states["jam"][0][:4] = 1e12
    plant.states["speed"][0][:4] = speeds
    plant.params.body["dt"] = 1e-3 / 20
    twist = [plant.twist]
    for _ in range(120):
        plant.drive_open(np.zeros((1, 4)))
        twist.append(plant.twist)
    found = solve_ivp(rate, (0.0, 0.12), np.zeros(3), t_eval=np.linspace(0.0, 0.12, 121), rtol=1e-9, atol=1e-11).y.T
    found[:, 0] += found[:, 2] * c[1]  # of base_link
    found[:, 1] -= found[:, 2] * c[0]
    np.testing.assert_allclose(np.array(twist), found, atol=0.02 * np.abs(found).max())


@pytest.mark.parametrize("com", [(0.0, 0.0), (0.01, -0.008)])
def test_a_path_is_kept_with_the_centre_of_mass_aside(com: tuple[float, float]) -> None:
    path = plan_path(circle(1.0), PathLimits(0.8, 1.0))
    log = simulate_base(soccer(com=com), DRIVE, path, rng=np.random.default_rng(1))
    assert log.ended == "done"
    assert log.path_error.max() < 0.01
    assert np.degrees(np.abs(log.heading_error).max()) < 2.0
    assert (log.status == SlipStatus.NO_SLIP).all()


def _creep_of(base: Base, used: float) -> float:
    """Slip of the first wheel's rim as the controller believes it, where a part of the grip is used."""
    params = BaseController(base, DRIVE, creep=Creep(CARPET.creep, CARPET.peak)).params
    return float(creep(params.creep[0], used))


@pytest.mark.parametrize("used", [0.3, 0.6, 0.8])
def test_a_gripping_wheel_creeps_along_its_rollers(used: float) -> None:
    """By the magic formula: the contact slips where mu(s) is what is used; the rim of a mecanum wheel over cos 45."""
    s = brentq(lambda slip: CARPET.friction(slip) - used * CARPET.peak, 0.0, 0.05)
    omni, mecanum = soccer(), arrangements.mecanum(0.2, 0.16, 0.03, mass=6.35)
    assert _creep_of(omni, used) == pytest.approx(s, rel=0.12)
    assert _creep_of(mecanum, used) == pytest.approx(s / np.cos(np.pi / 4), rel=0.12)
    assert _creep_of(mecanum, used) / _creep_of(omni, used) == pytest.approx(np.sqrt(2.0))


def test_a_mecanum_controller_asks_for_what_its_rollers_push() -> None:
    """mu N cos 45 of each wheel at its rim, and its current tells of a part of that."""
    base = arrangements.mecanum(0.2, 0.16, 0.03, mass=20.0)
    params = BaseController(base, DRIVE, creep=Creep(CARPET.creep, 0.8)).params
    np.testing.assert_allclose(params.max_force, np.minimum(params.max_force, 0.6 * 49.05 * np.sqrt(0.5)))
    force = DRIVE.motor.torque_constant * DRIVE.gear.ratio * DRIVE.gear.efficiency / 0.03
    np.testing.assert_allclose(params.grip_per_ampere, force / (0.8 * 49.05 * np.sqrt(0.5)))


def test_six_wheels_that_lift_carry_the_weight() -> None:
    """Two rows of six wheels leave the floor while it brakes; no load is below zero, all carry 100 kg."""
    places = [(x, y) for x in (0.5, 0.0, -0.5) for y in (0.3, -0.3)]
    wheels = [
        Wheel.at("swedish", x, y, a, radius=0.05, driven=True, name=f"{k}")
        for k, ((x, y), a) in enumerate(zip(places, np.radians([45, 135, 0, 90, 135, 45]), strict=True))
    ]
    plant = BasePlant(WheelBase(wheels, mass=100.0, com_height=0.5), LOSSLESS)
    plant.state["ax"] = -8.0
    plant.drive_open(np.zeros((1, 6)))
    plant.state["ax"] = -8.0
    log = plant.drive_open(np.zeros((2, 6)))
    assert (log.loads >= 0.0).all()
    np.testing.assert_allclose(log.loads.sum(axis=1), 981.0, rtol=1e-9)
    assert plant.tipped is None


def test_a_base_that_falls_over_ends_its_run() -> None:
    base = soccer(com_height=0.5)
    path = plan_path(circle(1.0), PathLimits(1.5, 3.0))
    log = simulate_base(base, DRIVE, path, rng=np.random.default_rng(1))
    assert log.ended == "tipped"
    assert log.driven < 0.5
    assert "tipped over after" in log.events[-1].text


def test_what_is_not_detectable_is_said_so() -> None:
    path = plan_path(circle(1.0), PathLimits(0.8, 1.0))
    three = arrangements.omni(n=3, radius=0.0789, wheel_radius=0.02711, mass=6.35)
    log = simulate_base(three, DRIVE, path, floor=Floor(Material(0.12, 0.08, 0.05)), rng=np.random.default_rng(1))
    assert (np.abs(log.slip) > 0.05).any()
    assert (log.status == SlipStatus.UNDETECTABLE).all()
    assert not log.named.any()
    four = BaseController(arrangements.skid_steer(0.2, 0.2, 0.03, mass=5.0), DRIVE)  # whose wheels slip to turn
    assert four.state["status"][0] == SlipStatus.UNDETECTABLE
    assert BaseLoop(four, BasePlant(four.base, DRIVE)).plant.tipped is None
