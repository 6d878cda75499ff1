"""The loop: what statics and its own data sheets say of an arm that stands, lifts, hits a limit or the table."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from demo_cell import ARM, HOME, make_loop, stand

from holonom.closed_loop import ArmLoop
from holonom.errors import DriveFault, UnknownName
from holonom.machine import CONTROLLERS, ControlSettings
from holonom.machine.arm.servos import ArmServos
from holonom.mechanics import Arm
from holonom.sim import Ground

JOINTS = ARM.model.joints
PER_AMPERE = np.array([joint.motor.gear_ratio * joint.motor.torque_constant for joint in JOINTS])
COUNT = np.array([2 * np.pi / abs(j.motor.gear_ratio * j.motor.encoder_counts) for j in JOINTS])
FRICTION = np.array([max(joint.friction.coulomb_positive, joint.friction.coulomb_negative) for joint in JOINTS])
"""Torque per ampere (N m/A, with the gear's sign), one encoder count (rad), Coulomb friction (N m), at the joints."""


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_a_standing_arm_stands(controller: str) -> None:
    """Within two encoder counts, with the currents that carry its weight, up to what friction carries."""
    loop = make_loop(controller)
    stand(loop, HOME, 1.0)
    currents = []
    for _ in range(10):
        stand(loop, HOME, 0.1)
        assert (np.abs(loop.plant.q - HOME) <= 2.0 * COUNT).all(), (loop.plant.q - HOME) / COUNT
        assert np.abs(loop.plant.qd).max() < 0.02
        currents.append(loop.plant.states["current"].copy())
    gravity = ARM.gravity(HOME)
    assert np.abs(gravity).max() > 5.0
    assert (np.abs(PER_AMPERE * np.mean(currents, axis=0) - gravity) <= FRICTION).all()
    assert loop.time == pytest.approx(2.0)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_it_starts_in_balance(controller: str) -> None:
    """The first steps of the motors, before any loop has seen an error, leave it at rest."""
    loop = make_loop(controller)
    np.testing.assert_allclose(PER_AMPERE * loop.plant.states["current"], ARM.gravity(HOME), atol=1e-12)
    stand(loop, HOME, 0.1)
    assert (loop.plant.states["peak_error"] <= 2.0 * COUNT).all()


def creep(payload: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean drive torques and joints while all joints creep forth and back, in which Coulomb friction cancels."""
    loop = make_loop()
    loop.plant.payload = payload
    stand(loop, HOME, 0.5)
    n, rate = 1000, 0.1
    course = rate * 1e-3 * np.concatenate([np.arange(n), np.arange(n, 0, -1)])
    speed = rate * np.repeat([1.0, -1.0], n)
    torques, joints = [], []
    for k in range(0, 2 * n, 10):
        rows = slice(k, k + 10)
        q, qd = HOME + course[rows, None], np.tile(speed[rows, None], (1, 6))
        loop.advance(np.stack([q, qd, np.zeros((10, 6))]))
        if k % n >= 300:
            torques.append(PER_AMPERE * loop.plant.states["current"])
            joints.append(loop.plant.q)
    return np.mean(torques, axis=0), np.mean(joints, axis=0)


def test_a_payload_takes_current() -> None:
    """The motors' currents grow by J^T f / (G kt): the payload's weight at its centre of mass, in the tool frame."""
    mass, at = 1.5, np.array([0.0, 0.05, 0.02])
    loaded, q = creep(np.array([mass, *at]))
    empty, _ = creep(np.zeros(4))
    J = ARM.jacobian(q)
    at_world = ARM.fk(q)[:3, :3] @ at
    velocity = J[:3] + np.cross(J[3:].T, at_world).T
    wanted = velocity.T @ [0.0, 0.0, mass * 9.81]
    assert np.abs(wanted).max() > 5.0
    np.testing.assert_allclose((loaded - empty) / PER_AMPERE, wanted / PER_AMPERE, atol=0.04)  # A


@pytest.mark.parametrize("axis", [0, 2, 4])
def test_a_following_error_trips_the_axis(axis: int) -> None:
    loop = make_loop()
    target = HOME.copy()
    target[axis] += 0.5
    with pytest.raises(DriveFault, match=f"{JOINTS[axis].name}.*following error"):
        stand(loop, target, 1.0)
    assert loop.time < 0.05
    loop.brake(500)
    assert np.abs(loop.plant.qd).max() < 1e-2
    assert np.abs(loop.plant.q - HOME).max() < 0.05


def test_the_same_inputs_give_the_same_bits() -> None:
    a, b = make_loop(), make_loop()
    rng = np.random.default_rng(5)
    for amplitude in 0.01 * rng.standard_normal((20, 6)):
        s = np.linspace(0.0, np.pi, 50)[:, None]
        reference = np.stack([HOME + amplitude * (1 - np.cos(2 * s)) / 2, 0 * s + 0 * HOME, 0 * s + 0 * HOME])
        a.advance(reference)
        b.advance(reference)
    assert a.plant.states.tobytes() == b.plant.states.tobytes()
    assert np.abs(a.plant.states["peak_speed"]).min() > 0.0


def test_time_in_one_piece_or_in_many() -> None:
    a, b = make_loop(), make_loop()
    s = np.linspace(0.0, 1.0, 200)[:, None] ** 2 * (1 - np.linspace(0.0, 1.0, 200)[:, None]) ** 2
    reference = np.stack([HOME + 0.5 * s * np.ones(6), 0 * s * HOME, 0 * s * HOME])
    a.advance(reference)
    for k in range(0, 200, 10):
        b.advance(reference[:, k : k + 10])
    assert a.plant.states.tobytes() == b.plant.states.tobytes()


def press(ground: Ground) -> ArmLoop:
    """Send the tool straight down by 3 mm, slowly, and keep it there."""
    loop = make_loop("cascade", ground=ground)
    down = np.linalg.solve(ARM.jacobian(HOME), [0.0, 0.0, -3e-3, 0.0, 0.0, 0.0])
    for part in np.linspace(0.0, 1.0, 60):
        stand(loop, HOME + part * down, 0.1)
    stand(loop, HOME + down, 1.0)
    return loop


def test_a_tool_pressed_on_the_table() -> None:
    """At rest the motors push with the force that the table's spring returns at the depth of the tool."""
    ground = Ground(height=float(ARM.fk(HOME)[2, 3]) - 1e-3)
    pressed, free = press(ground), press(Ground())
    sunk = ground.height - float(ARM.fk(pressed.plant.q)[2, 3])
    assert sunk == pytest.approx(2e-3, abs=1e-4)
    force = ground.stiffness * sunk
    assert pressed.plant.touch == pytest.approx(force, rel=0.05)
    assert free.plant.touch == 0.0
    torque = PER_AMPERE * (pressed.plant.states["current"] - free.plant.states["current"])
    wanted = ARM.jacobian(HOME)[2] * -force
    assert wanted[1] < -1.5 * FRICTION[1]
    assert (np.abs(torque - wanted) <= FRICTION)[1:3].all(), "friction may carry the rest"


def test_settings_name_the_controllers() -> None:
    with pytest.raises(UnknownName, match="did you mean 'cascade'"):
        ControlSettings("cascde")


def test_peaks_are_those_of_the_run() -> None:
    loop = ArmLoop(ARM, HOME, ControlSettings())
    s = np.arange(500)[:, None] / 500
    way = 0.2 * np.array([1.0, 0, 0, 0, 0, 0])
    reference = np.stack(
        [
            HOME + way * (s - np.sin(2 * np.pi * s) / (2 * np.pi)),
            way / 0.5 * (1 - np.cos(2 * np.pi * s)),
            way / 0.25 * 2 * np.pi * np.sin(2 * np.pi * s),
        ]
    )
    loop.advance(reference)
    assert loop.plant.states["peak_speed"][0] == pytest.approx(0.8, rel=0.02)
    assert loop.plant.q[0] == pytest.approx(HOME[0] + 0.2, abs=2e-3)
    assert loop.plant.states["peak_voltage"][0] <= JOINTS[0].motor.max_voltage


def test_what_the_design_of_the_servos_does_not_reach_is_said() -> None:
    assert make_loop().warnings == []
    motor = dataclasses.replace(JOINTS[2].motor, inductance=1e-4)
    joints = [*JOINTS[:2], dataclasses.replace(JOINTS[2], motor=motor), *JOINTS[3:]]
    arm = Arm(dataclasses.replace(ARM.model, joints=tuple(joints)))
    (warning,) = ArmServos(arm, HOME).warnings
    assert warning.startswith(f"joint {JOINTS[2].name!r}: the current loop samples every 0.0001 s")
    assert "L/R is only 4.76e-05 s" in warning
