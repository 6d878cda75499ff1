"""Contact forces by the currents of simulated arms that stand on something, or swing freely: within what is stated."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import holonom as hm
from holonom.closed_loop.arm_loop import ArmLoop
from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError
from holonom.machine import ContactErrors, contact_by_currents
from holonom.machine.arm.kernels import CASCADE
from holonom.machine.arm.servos import ControlSettings
from holonom.mechanics import Arm
from holonom.sim import Ground

PUMA = hm.load_arm("puma560")
Q = np.array([0.3, -0.6, -2.6, 0.2, -0.9, 0.4])
EXACT = ContactErrors(current=0.01, model=0.0, friction=0.0)


def changed(friction: float, efficiency: float = 1.0) -> Arm:
    joints = tuple(
        dataclasses.replace(
            joint,
            friction=joint.friction
            and dataclasses.replace(
                joint.friction,
                coulomb_positive=friction * joint.friction.coulomb_positive,
                coulomb_negative=friction * joint.friction.coulomb_negative,
            ),
            motor=joint.motor and dataclasses.replace(joint.motor, gear_efficiency=efficiency),
        )
        for joint in PUMA.model.joints
    )
    return Arm(dataclasses.replace(PUMA.model, joints=joints))


def pressed(arm: Arm, depth: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Joints, currents and contact force (N), means over 0.3 s, of an arm that stands on a surface under its tool.

    It is commanded `depth` (m) into it. Without friction it hunts by a count of its encoders, hence the means.
    """
    stiffness, height = 2e4, float(arm.fk(Q)[2, 3])
    ground = Ground(height + depth, stiffness, 200.0) if depth > 0.0 else Ground()
    loop = ArmLoop(arm, Q, ControlSettings(following_error=1.0), ground)
    reference = np.zeros((3, 1500, arm.n))
    reference[0] = Q
    loop._advance(CASCADE, reference)
    joints, currents, forces = [], [], []
    for _ in range(300):
        loop._advance(CASCADE, reference[:, :1])
        joints.append(loop.truth.position)
        currents.append(loop.measured.current)
        forces.append(stiffness * max(ground.height - float(arm.fk(joints[-1])[2, 3]), 0.0))
    return np.mean(joints, axis=0), np.mean(currents, axis=0), float(np.mean(forces))


@pytest.mark.parametrize("friction", [0.0, 1.0])
@pytest.mark.parametrize("efficiency", [1.0, 0.8])
@pytest.mark.parametrize("depth", [0.0, 2e-3])
def test_a_resting_contact_is_told_within_its_error(friction: float, efficiency: float, depth: float) -> None:
    arm = changed(friction, efficiency)
    q, currents, force = pressed(arm, depth)
    assert (force > 5.0) == (depth > 0.0)
    zero = np.zeros(arm.n)
    found = contact_by_currents(arm, q, zero, zero, currents, frame="world", errors=EXACT)
    assert (np.abs(found.wrench - [0.0, 0.0, -force, 0.0, 0.0, 0.0]) <= found.error).all()
    if friction == 0.0 and efficiency == 1.0:
        assert found.error[2] < 5.0
    else:
        assert found.error[2] > 5.0  # which is honest: joints that stand hide their friction
    tool = contact_by_currents(arm, q, zero, zero, currents, frame="tool", errors=EXACT)
    R = arm.fk(q)[:3, :3]
    np.testing.assert_allclose(R @ tool.wrench[:3], found.wrench[:3], atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_a_free_motion_has_no_contact(seed: int) -> None:
    """Currents of the model's own motion leave nothing; with half of its friction, still no more than is stated."""
    rng = np.random.default_rng(seed)
    q, qd, qdd = Q + 0.1 * rng.normal(size=6), rng.uniform(0.2, 1.0, 6), rng.normal(size=6)
    constants = np.array([j.motor.gear_ratio * j.motor.torque_constant for j in PUMA.model.joints if j.motor])
    tau, smooth = PUMA.inverse_dynamics(q, qd, qdd), PUMA.inverse_dynamics(q, qd, qdd, friction=False)
    found = contact_by_currents(PUMA, q, qd, qdd, tau / constants, frame="world", errors=EXACT)
    np.testing.assert_allclose(found.wrench, 0.0, atol=1e-6)
    half = contact_by_currents(
        PUMA, q, qd, qdd, (0.5 * (tau + smooth)) / constants, frame="world", errors=ContactErrors(friction=0.5)
    )
    assert (np.abs(half.wrench) <= half.error).all()
    assert np.abs(half.wrench).max() > 1.0


def test_bad_input_is_named() -> None:
    z = np.zeros(6)
    with pytest.raises(InputError, match="frame is 'base'"):
        contact_by_currents(PUMA, Q, z, z, z, frame="base")
    with pytest.raises(ShapeError, match="currents"):
        contact_by_currents(PUMA, Q, z, z, np.zeros(5), frame="world")
    with pytest.raises(OutOfLimits, match="singular"):
        contact_by_currents(PUMA, [0.3, -0.6, -2.6, 0.2, 0.0, 0.4], z, z, z, frame="world")
    with pytest.raises(ModelError, match="friction is -1"):
        ContactErrors(friction=-1.0)
    with pytest.raises(ModelError, match="current is nan"):
        ContactErrors(current=math.nan)
    bare = Arm(
        dataclasses.replace(PUMA.model, joints=tuple(dataclasses.replace(j, motor=None) for j in PUMA.model.joints))
    )
    with pytest.raises(ModelError, match="no motor"):
        contact_by_currents(bare, Q, z, z, z, frame="world")
