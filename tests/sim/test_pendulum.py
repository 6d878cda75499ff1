"""The inverted pendulum: against a stiff solver with equations of its own, by energy, rest and falls."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from holonom.devices import DcMotor, Encoder, Gear
from holonom.errors import ModelError, OutOfLimits
from holonom.mobile import BaseDrive, Wheel, WheelBase, differential, segway
from holonom.mobile.drive.base_drive import BaseSensors
from holonom.sim import BaseFault, BasePlant, Floor, Material

R, L, K, RATIO, ROTOR, SPIN, SUPPLY = 1.2, 0.56e-3, 0.0255, 12.0, 92.5e-7, 1e-3, 14.8
MOTOR = DcMotor(
    resistance=R, inductance=L, torque_constant=K, back_emf_constant=K, rotor_inertia=ROTOR, max_voltage=SUPPLY,
    max_current=20.0,
)  # fmt: skip
DRIVE = BaseDrive(MOTOR, Gear(RATIO), Encoder(4096), wheel_inertia=SPIN)
MASS, GRAVITY, RADIUS, TRACK = 8.0, 9.81, 0.1, 0.4
INERTIA = np.diag([0.30, 0.25, 0.10]) + np.array([[0.0, 0.0, 0.02], [0.0, 0.0, 0.0], [0.02, 0.0, 0.0]])
PEAK, SLIDING, AT = 0.8, 0.65, 0.05  # of the floor
SHAPE = 2.0 - 2.0 / math.pi * math.asin(SLIDING / PEAK)
STIFF = math.tan(0.5 * math.pi / SHAPE) / AT
Vector = NDArray[np.float64]
TALL = segway(TRACK, RADIUS, mass=MASS, com=(0.02, 0.03), com_height=0.9, inertia=INERTIA)
HANGING = segway(TRACK, RADIUS, mass=MASS, com=(0.0, 0.0), com_height=0.04, inertia=INERTIA)


def points(base: WheelBase) -> tuple[Vector, Vector]:
    """Point masses (6,) at places (6, 3) about the axle's middle that have the body's mass, centre and inertia."""
    own = INERTIA - 2.0 * ROTOR * np.diag([0.0, 1.0, 0.0])  # rotors turn by themselves
    spread = 0.5 * np.trace(own) * np.eye(3) - own  # sum m r r^T
    values, axes = np.linalg.eigh(spread)
    arms = axes * np.sqrt(3.0 * values / MASS)
    middle = np.array([*base.com, base.com_height - RADIUS])
    return np.full(6, MASS / 6.0), np.vstack([middle + sign * arms[:, k] for k in range(3) for sign in (1.0, -1.0)])


def solved(base: WheelBase, volts: Vector, lean: float, seconds: float = 1.0) -> Vector:
    """Pose of the axle's middle and pitch after a time, from rest at a lean.

    D'Alembert in the world, point by point: coordinates X, Y, theta, phi and the wheels' angles against the floor; each
    point moves by `J qd`, `J = [ex, ey, ez x r, ey' x r]`, and is accelerated by `J qdd` and what turning gives.
    """
    masses, places = points(base)
    sides = np.array([w.y for w in base.wheels])

    def mechanics(z: Vector, forces: Vector) -> tuple[Vector, Vector]:
        """Accelerations, and loads of the wheels, under (along, across, motor) of each."""
        (c, s), (d, e) = ((math.cos(angle), math.sin(angle)) for angle in z[2:4])
        rate = z[6:12]
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        r = places @ (turn @ np.array([[d, 0.0, e], [0.0, 1.0, 0.0], [-e, 0.0, d]])).T
        wx, wy, wz = np.array([-s * rate[3], c * rate[3], rate[2]])
        spin = np.array([[0.0, -wz, wy], [wz, 0.0, -wx], [-wy, wx, 0.0]])
        turned = rate[2] * rate[3] * np.array([-c, -s, 0.0])  # ez x ey': how the pitch's axis turns
        twist = np.array([[0.0, 0.0, turned[1]], [0.0, 0.0, -turned[0]], [-turned[1], turned[0], 0.0]])
        extra = r @ (twist + spin @ spin).T
        J = np.zeros((len(r), 3, 6))
        J[:, 0, 0] = J[:, 1, 1] = 1.0
        J[:, 0, 2], J[:, 1, 2] = -r[:, 1], r[:, 0]
        J[:, 0, 3], J[:, 1, 3] = c * r[:, 2], s * r[:, 2]
        J[:, 2, 3] = -s * r[:, 1] - c * r[:, 0]
        rows = J.reshape(-1, 6)
        heavy = np.repeat(masses, 3)[:, None] * rows
        inertia = heavy.T @ rows
        push = -heavy.T @ (extra + np.array([0.0, 0.0, GRAVITY])).ravel()
        for k in range(2):
            rotor = np.zeros(6)
            rotor[3], rotor[4 + k] = 1.0 - RATIO, RATIO
            inertia += ROTOR * np.outer(rotor, rotor)
            inertia[4 + k, 4 + k] += SPIN
            along, across, motor = forces[k]
            way = np.array([c * along - s * across, s * along + c * across])
            push[:2] += way
            push[2] += sides[k] * (-s * way[1] - c * way[0])
            push[3] -= motor
            push[4 + k] += motor - RADIUS * along
        rates = np.linalg.solve(inertia, push)
        a = (rows @ rates).reshape(-1, 3) + extra
        total = masses @ (a[:, 2] + GRAVITY)  # what carries the body, and its moment about the way ahead
        moment = -masses @ ((r[:, 2] + RADIUS) * (a @ [-s, c, 0.0]))
        return rates, (total * (base.com[1] - sides[::-1]) + moment) / (sides - sides[::-1])

    def rates(t: float, z: Vector) -> Vector:
        theta, rate, current = z[2], z[6:12], z[12:14]
        c, s = math.cos(theta), math.sin(theta)
        vx, vy = c * rate[0] + s * rate[1], -s * rate[0] + c * rate[1]
        loads = np.array([0.5, 0.5]) * MASS * GRAVITY
        found = np.zeros(6)
        for _ in range(3):  # loads follow from accelerations, and those from loads
            forces = np.zeros((2, 3))
            for k in range(2):
                along, across = RADIUS * rate[4 + k] - (vx - rate[2] * sides[k]), -vy
                slip = math.hypot(along, across) + 1e-9
                grip = loads[k] * PEAK * math.sin(SHAPE * math.atan(STIFF * slip)) / slip
                forces[k] = grip * along, grip * across, RATIO * K * current[k]
            found, loads = mechanics(z, forces)
        change = (volts - K * RATIO * (rate[4:] - rate[3]) - R * current) / L
        return np.concatenate([rate, found, change])

    z = np.zeros(14)
    z[3] = lean
    done = solve_ivp(rates, (0.0, seconds), z, method="Radau", rtol=1e-6, atol=1e-8)
    return np.asarray(done.y[:4, -1])


CASES = {
    "it speeds up, leaning forwards": (TALL, [3.0, 3.4], 0.145),
    "it falls": (TALL, [0.3, -0.3], -0.015),
    "it turns and falls": (TALL, [2.0, -1.5], 0.0),
    "it hangs and swings": (HANGING, [5.0, 6.0], 0.4),
}


@pytest.mark.parametrize("name", CASES)
def test_pose_and_pitch_after_a_second(name: str) -> None:
    base, volts, lean = CASES[name]
    plant = BasePlant(base, DRIVE, Floor())
    plant.lean(lean)
    plant.drive_open(np.tile(volts, (1000, 1)))
    expected = solved(base, np.array(volts), lean)
    assert plant.tipped is None
    assert np.hypot(*(plant.pose - expected[:3])[:2]) < 2e-3
    assert abs(plant.pose[2] - expected[2]) < math.radians(0.1)
    assert abs(plant.pitch[0] - expected[3]) < math.radians(0.1)


def height(base: WheelBase, pitch: float) -> float:
    """Height of the centre of mass over the axle, m."""
    return (base.com_height - RADIUS) * math.cos(pitch) - base.com[0] * math.sin(pitch)


@pytest.mark.parametrize("base", [TALL, HANGING])
@pytest.mark.parametrize("floor", [Floor(), Floor(Material(0.0, 0.0, 0.1))])
def test_energy_is_kept(base: WheelBase, floor: Floor) -> None:
    """Without motors a body that turns and falls only changes its energies into each other, and into slip."""
    dead = [BaseFault(0.0, k, "dead") for k in range(2)]
    plant = BasePlant(base, DRIVE, floor, faults=dead, substeps=40)
    plant.place((0.0, 0.0, 0.0), (0.4, 0.0, 1.5))
    plant.lean(0.2, 0.5)

    def energy() -> float:
        lifted = MASS * GRAVITY * height(base, float(plant.pitch[0]))
        return plant.kinetic_energy() + lifted + float(plant.state["ground"][0])

    before, moved = energy(), plant.kinetic_energy()
    plant.drive_open(np.zeros((400, 2)))
    moved = abs(plant.kinetic_energy() - moved)
    assert moved > 0.05
    assert energy() == pytest.approx(before, abs=1e-3 * moved + 1e-4)


def test_upright_is_a_rest_that_nothing_holds() -> None:
    """Its growth is the root of `(P - M^2 l^2/M') lambda^2 = M g l` where wheels roll, their inertia taken in."""
    base = segway(TRACK, RADIUS, mass=MASS, com_height=0.9, inertia=INERTIA)
    dead = [BaseFault(0.0, k, "dead") for k in range(2)]
    plant = BasePlant(base, DRIVE, Floor(), faults=dead, substeps=20)
    plant.drive_open(np.zeros((500, 2)))
    assert np.abs(plant.pose).max() == 0.0
    assert plant.pitch[0] == 0.0
    rise, N = 0.8, RATIO
    both = MASS * rise + 2.0 * ROTOR * N * (1 - N) / RADIUS
    rolling = MASS + 2.0 * (SPIN + N * N * ROTOR) / RADIUS**2
    inertia = np.array([[rolling, both], [both, INERTIA[1, 1] + MASS * rise**2 + 2.0 * ROTOR * (N * N - 2.0 * N)]])
    growth = math.sqrt(np.linalg.eigvals(np.linalg.solve(inertia, np.diag([0.0, MASS * GRAVITY * rise]))).real.max())
    plant.lean(1e-4, 1e-4 * growth)
    plant.drive_open(np.zeros((400, 2)))
    assert plant.pitch[0] == pytest.approx(1e-4 * math.exp(0.4 * growth), rel=0.01)


def test_a_fall_has_its_time() -> None:
    plant = BasePlant(TALL, DRIVE, Floor())
    plant.lean(0.5)
    log = plant.drive_open(np.zeros((1000, 2)))
    fallen = int(np.argmax(np.abs(log.pitch) >= math.pi / 3.0))
    assert plant.tipped == pytest.approx(1e-3 * fallen)
    assert np.isfinite(log.pitch).all()


def test_an_imu_pitches_with_the_body() -> None:
    """At rest it shows gravity along its own axes; leaning forwards it hangs from its front."""
    plant = BasePlant(TALL, DRIVE, Floor(Material(0.0, 0.0, 0.1)), sensors=BaseSensors(0.0, 0.0, 0.0, 0.0, 0.0))
    plant.lean(0.3, 0.7)
    _, ahead, _, rate, up = plant.signals.inertial
    assert [ahead, up] == pytest.approx([-GRAVITY * math.sin(0.3), GRAVITY * math.cos(0.3)])
    assert rate == pytest.approx(0.7)


def test_what_does_not_balance() -> None:
    wheels = [
        Wheel.at("fixed", x, y, radius=0.1, driven=True, name=name)
        for x, y, name in ((0, 0.2, "left"), (0.1, -0.2, "right"))
    ]
    with pytest.raises(ModelError, match="alike on one axle"):
        BasePlant(WheelBase(wheels, mass=5.0, balances=True), DRIVE)
    skewed = np.diag([0.3, 0.25, 0.1]) + 0.01 * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])
    with pytest.raises(ModelError, match="products of inertia xy and yz must be 0"):
        BasePlant(segway(TRACK, RADIUS, mass=MASS, com_height=0.9, inertia=skewed), DRIVE)
    with pytest.raises(ModelError, match="only a segway leans"):
        BasePlant(differential(0.3, 0.05, mass=5.0, com=(-0.05, 0.0)), DRIVE).lean(0.1)
    with pytest.raises(OutOfLimits, match="must be below"):
        BasePlant(TALL, DRIVE).lean(1.2)
