"""Every kind of wheel against a stiff ODE solver: the same equations, written here once more, wheel by wheel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from holonom.devices import DcMotor, Encoder, Gear, SteeringMotor
from holonom.mobile import BaseDrive, Wheel, WheelBase, ackermann, bicycle, differential, skid_steer, swerve, tricycle
from holonom.sim import BasePlant, Floor

R, L, K, RATIO, SPIN, SUPPLY = 1.2, 0.56e-3, 0.0255, 12.0, 1e-4, 14.8
STEERING = SteeringMotor(lag=0.05, max_rate=3.0, max_torque=15.0)
MOTOR = DcMotor(
    resistance=R, inductance=L, torque_constant=K, back_emf_constant=K, rotor_inertia=92.5e-7, max_voltage=SUPPLY,
    max_current=20.0,
)  # fmt: skip
DRIVE = BaseDrive(MOTOR, Gear(RATIO), Encoder(4096), wheel_inertia=SPIN, steering=STEERING)
MASS, GRAVITY = 8.0, 9.81
PEAK, SLIDING, AT = 0.8, 0.65, 0.05  # of the floor
SHAPE = 2.0 - 2.0 / math.pi * math.asin(SLIDING / PEAK)
STIFF = math.tan(0.5 * math.pi / SHAPE) / AT
Vector = NDArray[np.float64]


@dataclass
class Tyre:
    """A wheel of the test's own model."""

    x: float
    y: float
    heading: float
    radius: float
    driven: bool
    steered: bool = False
    trail: float = 0.0


def tyres(base: WheelBase) -> list[Tyre]:
    return [Tyre(w.x, w.y, w.heading, w.radius, w.driven, w.steers, w.castor_offset) for w in base.wheels]


def weights(base: WheelBase) -> Vector:
    """Loads: the smallest that balance weight and its moments; a castor carries at its pivot."""
    at = np.array([(w.x, w.y) for w in base.wheels]) - base.com
    return np.asarray(
        MASS * GRAVITY * np.linalg.lstsq(np.vstack([np.ones(len(at)), at.T]), [1.0, 0.0, 0.0], rcond=None)[0]
    )


def solved(base: WheelBase, volts: Vector, angles: Vector, seconds: float = 1.0) -> Vector:
    """Pose of base_link after a time from rest, motors on `volts` from the start, steering asked for `angles`."""
    wheels, loads, n = tyres(base), weights(base), len(base.wheels)
    inertia = float(base.inertia[2, 2])
    usual = np.mean([w.radius for w in wheels if w.driven])
    spins = [SPIN + RATIO**2 * MOTOR.rotor_inertia if w.driven else SPIN * (w.radius / usual) ** 4 for w in wheels]
    pivots = []
    for wheel in wheels:
        disc = SPIN * (wheel.radius / usual) ** 4
        about = 0.5 * disc + 2.0 * disc / wheel.radius**2 * wheel.trail**2 if wheel.trail else 0.0
        pivots.append(about + (STEERING.inertia if wheel.steered else 0.0))
    stiffness, damping = STEERING.inertia * (80.0 * math.pi) ** 2, 1.4 * 80.0 * math.pi * STEERING.inertia

    def rates(t: float, z: Vector) -> Vector:
        theta, vx, vy, w = z[2:6]
        speed, current, turned, swing, motor = z[6:].reshape(5, n)
        d = np.zeros((5, n))
        fx = fy = torque = 0.0
        for i, tyre in enumerate(wheels):
            heading = tyre.heading + turned[i]
            ux, uy = math.cos(heading), math.sin(heading)
            px, py = tyre.x - base.com[0], tyre.y - base.com[1]
            at = vx - w * py, vy + w * px
            along = tyre.radius * speed[i] - (ux * at[0] + uy * at[1])
            across = -(-uy * at[0] + ux * at[1]) - tyre.trail * (swing[i] if tyre.trail else 0.0)
            slip = math.hypot(along, across) + 1e-9
            force = loads[i] * PEAK * math.sin(SHAPE * math.atan(STIFF * slip)) / slip
            fl, fc = force * along, force * across
            drive = 0.0
            if tyre.driven:
                d[1, i] = (volts[i] - K * RATIO * speed[i] - R * current[i]) / L
                drive = RATIO * K * current[i]
            d[0, i] = (drive - tyre.radius * fl) / spins[i]
            if tyre.steered:
                rate = float(np.clip((angles[i] - motor[i]) / STEERING.lag, -STEERING.max_rate, STEERING.max_rate))
                pull = stiffness * (motor[i] - turned[i]) + damping * (rate - (swing[i] - w))
                moment = float(np.clip(pull, -STEERING.max_torque, STEERING.max_torque))
                d[4, i] = rate
            else:
                moment = -1e-3 * 2.0 * spins[i] / tyre.radius**2 * (swing[i] - w) if tyre.trail else 0.0
            if tyre.steered or tyre.trail:
                d[2, i], d[3, i] = swing[i] - w, (tyre.trail * fc + moment) / pivots[i]
            bx, by = ux * fl - uy * fc, uy * fl + ux * fc
            fx, fy, torque = fx + bx, fy + by, torque + px * by - py * bx - moment
        c, s = math.cos(theta), math.sin(theta)
        body = [c * vx - s * vy, s * vx + c * vy, w, fx / MASS + w * vy, fy / MASS - w * vx, torque / inertia]
        return np.concatenate([body, d.ravel()])

    z = np.zeros(6 + 5 * n)
    z[:2] = base.com
    done = solve_ivp(rates, (0.0, seconds), z, method="Radau", rtol=1e-6, atol=1e-8)
    x, y, theta = done.y[:3, -1]
    c, s = math.cos(theta), math.sin(theta)
    return np.array([x - c * base.com[0] + s * base.com[1], y - s * base.com[0] - c * base.com[1], theta])


CASTORS = WheelBase(
    [
        Wheel.at("castor", x, y, turn, radius=0.05, castor_offset=0.04, driven=True)
        for x, y, turn in ((0.25, 0.0, 0.3), (-0.12, 0.2, -2.0), (-0.12, -0.2, 1.0))
    ],
    mass=MASS, com=(0.02, -0.01),
)  # fmt: skip
"""Driven castors on all three corners: nothing holds it sideways."""
SWERVE = swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05, mass=MASS)
CASES = {
    "differential with castor": (differential(0.3, 0.05, mass=MASS, com=(-0.06, 0.01)), [5.0, 3.0, 0.0], [0.0] * 3),
    "castor turned over": (differential(0.3, 0.05, mass=MASS, com=(-0.06, 0.0)), [-4.0, -5.0, 0.0], [0.0] * 3),
    "car": (ackermann(0.4, 0.3, 0.05, mass=MASS, com=(0.17, 0.0)), [0.0, 0.0, 5.0, 5.5], [0.35, 0.28, 0.0, 0.0]),
    "tricycle": (tricycle(0.4, 0.3, 0.05, mass=MASS, com=(0.13, 0.0)), [6.0, 0.0, 0.0], [-0.4, 0.0, 0.0]),
    "bicycle": (bicycle(0.5, 0.06, mass=MASS, com=(0.2, 0.0)), [0.0, 8.0], [0.5, 0.0]),
    "swerve": (
        swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05, mass=MASS),
        [5.0, 6.0, 5.0, 6.0],
        [0.6, 0.5, -0.1, 0.1],
    ),
    "driven castors": (CASTORS, [4.0, -3.0, 3.0], [0.5, 0.9, -0.7]),
    "skid steer": (skid_steer(0.3, 0.3, 0.05, mass=MASS, com=(0.03, 0.0)), [-4.0, 6.0, -4.0, 6.0], [0.0] * 4),
}


@pytest.mark.parametrize("name", CASES)
def test_the_pose_after_a_second(name: str) -> None:
    base, volts, angles = CASES[name]
    plant = BasePlant(base, DRIVE, Floor())
    order = [[lane.wheel.name for lane in plant.lanes].index(wheel.name) for wheel in base.wheels]
    plant.signals.steering[order] = angles
    plant.drive_open(np.tile([volts[[w.name for w in base.wheels].index(n)] for n in base.driven], (1000, 1)))
    away = plant.pose - solved(base, np.array(volts), np.array(angles))
    assert np.hypot(*away[:2]) < 2e-3
    assert abs(away[2]) < math.radians(0.1)


def test_skid_steer_turns_about_the_centres_that_its_friction_gives() -> None:
    """Steady turn: forces and torques of sliding tyres in balance, by the test's own sums."""
    base = skid_steer(0.3, 0.4, 0.05, mass=MASS, com=(0.05, 0.0))
    plant = BasePlant(base, DRIVE, Floor())
    plant.drive_open(np.tile([-3.0, 5.0, -3.0, 5.0], (3000, 1)))
    log = plant.drive_open(np.tile([-3.0, 5.0, -3.0, 5.0], (1000, 1)))
    vx, vy, w = log.twist[-500:].mean(axis=0)
    left, right = 0.05 * log.wheel_speeds[-500:, [0, 1]].mean(axis=0)
    sides = (vx - left) / w, (vx - right) / w  # where rims stand still against the floor: y of the centres
    ahead = -vy / w

    def balance(u: Vector) -> Vector:
        """Force and torque on the body at twist (vx, vy, w) while the rims run as they were measured."""
        total = np.zeros(3)
        for wheel, load in zip(base.wheels, weights(base), strict=True):
            rim = left if "left" in wheel.name else right
            sx, sy = rim - (u[0] - u[2] * wheel.y), -(u[1] + u[2] * wheel.x)
            slip = math.hypot(sx, sy)
            f = load * PEAK * math.sin(SHAPE * math.atan(STIFF * slip)) / slip
            total += [f * sx, f * sy, (wheel.x - 0.05) * f * sy - wheel.y * f * sx]
        return total - MASS * np.array([-u[2] * (u[1] + u[2] * 0.05), u[2] * u[0], 0.0])

    u = fsolve(balance, np.array([vx, vy, w]))
    expected = (u[0] - left) / u[2], (u[0] - right) / u[2]
    assert sides == pytest.approx(expected, rel=0.05)
    assert ahead == pytest.approx(-u[1] / u[2], abs=0.05 * 0.3)
    assert sides[0] - sides[1] > 0.4  # the centres lie outside the tracks


def test_a_steered_base_that_stands_does_not_move_while_its_wheels_turn() -> None:
    base = swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05, mass=MASS)
    plant = BasePlant(base, DRIVE, Floor())
    for sign in (1.0, -1.0):
        plant.signals.steering[:] = sign * np.array([1.2, -1.2, -1.2, 1.2])
        plant.drive_open(np.zeros((1000, 4)))
        assert plant.states["turned"].ravel() == pytest.approx(plant.signals.steering, abs=1e-3)
    assert np.abs(plant.pose).max() < 1e-4


def test_driven_castors_that_nobody_drives_stand_still() -> None:
    plant = BasePlant(CASTORS, DRIVE, Floor())
    plant.drive_open(np.zeros((1000, 3)))
    assert np.abs(plant.pose).max() < 1e-12
    assert plant.kinetic_energy() < 1e-20


def test_castors_that_swing_alike_carry_the_base_across_them() -> None:
    """Wheels that hardly roll: contacts stand, and each pivot moves across its castor, by lever times rate."""
    plant = BasePlant(CASTORS, DRIVE, Floor())
    headings = np.array([wheel.heading for wheel in CASTORS.wheels])
    plant.signals.steering[:3] = -headings  # all look ahead
    plant.drive_open(np.zeros((4000, 3)))
    start = plant.pose
    for k in range(100):
        plant.signals.steering[:3] = -headings + 0.001 * k
        plant.drive_open(np.zeros((10, 3)))
    plant.drive_open(np.zeros((300, 3)))
    c, s = np.cos(start[2]), np.sin(start[2])
    moved = np.array([[c, s], [-s, c]]) @ (plant.pose - start)[:2]
    assert moved == pytest.approx([0.0, -0.04 * 0.099], abs=4e-4)
    assert abs(plant.pose[2] - start[2]) < 2e-3


def test_what_fills_up_a_four_of_wheels_does_nothing() -> None:
    base = bicycle(0.5, 0.06, mass=MASS, com=(0.2, 0.0))
    plant = BasePlant(base, DRIVE, Floor())
    plant.place([0.0, 0.0, 0.0], [0.5, 0.0, 0.4])
    plant.drive_open(np.full((100, 1), 5.0))
    spare = slice(len(plant.lanes), None)
    for name in ("swing", "turned", "moment", "load"):
        assert not plant.states[name].ravel()[spare].any()
        assert plant.states[name].ravel()[1] != 0.0


@pytest.mark.parametrize("name", CASES)
def test_energy_is_kept(name: str) -> None:
    """Supplied, less heat, friction and slip, is what the base moves with; slip and friction only take."""
    base, volts, angles = CASES[name]
    plant = BasePlant(base, DRIVE, Floor())
    order = [[lane.wheel.name for lane in plant.lanes].index(wheel.name) for wheel in base.wheels]
    plant.signals.steering[order] = angles
    log = plant.drive_open(np.tile([volts[[w.name for w in base.wheels].index(n)] for n in base.driven], (1000, 1)))
    supplied, heat, airgap, drag, ground = (
        float(plant.state[k][0]) for k in ("supplied", "heat", "airgap", "drag", "ground")
    )
    assert airgap - drag - ground - plant.kinetic_energy() == pytest.approx(0.0, abs=0.02 * supplied)
    assert np.diff(log.energy[:, 4]).min() > -1e-9
    assert heat > 0.0
