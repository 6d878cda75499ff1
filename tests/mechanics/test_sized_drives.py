"""Drives sized from a joint's limits: what they reach, by laws, for every arm that states enough."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from holonom import load_arm
from holonom.errors import MissingInertia, ModelError
from holonom.machine import ArmServos, ControlSettings
from holonom.mechanics import Arm
from holonom.mechanics.arm.sized_drives import sized_drives
from holonom.model import JointLimits, preset_names

FILES = (
    "example_robot_data/ur10_robot.urdf", "example_robot_data/ur3_robot.urdf", "example_robot_data/ur5_robot.urdf",
    "pybullet/model.urdf",
)  # fmt: skip


def stated(arm: Arm) -> Arm:
    """The arm, with a limit wherever it states none, so that laws can be looked at for all."""
    joints = tuple(
        dataclasses.replace(
            joint,
            limits=dataclasses.replace(
                joint.limits,
                speed=joint.limits.speed if 0.0 < joint.limits.speed < np.inf else 2.0,
                torque=joint.limits.torque if 0.0 < joint.limits.torque < np.inf else 3e3,
            ),
        )
        for joint in arm.model.joints
    )
    return Arm(dataclasses.replace(arm.model, joints=joints))


def poses(arm: Arm, count: int = 20) -> np.ndarray:
    limits, rng = arm.limits, np.random.default_rng(0)
    low, high = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
    return rng.uniform(low, high, (count, arm.n))


@pytest.fixture(params=[*preset_names(), *FILES, "rtb_data/al5d_robot.urdf", "rtb_data/kr210l150.urdf"])
def arm(request: pytest.FixtureRequest, data_folder: Path) -> Arm:
    name = request.param
    return stated(load_arm(data_folder / "robots" / "urdf" / name if "/" in name else name))


def test_the_laws_of_a_sized_arm(arm: Arm) -> None:
    q = poses(arm, 1)[0]
    sized = sized_drives(arm, q)
    bare = Arm(
        dataclasses.replace(arm.model, joints=tuple(dataclasses.replace(j, motor=None) for j in arm.model.joints))
    )
    own = np.diagonal(bare.mass_matrix(q))
    for joint, link in zip(sized.model.joints, own, strict=True):
        motor, limits = joint.motor, joint.limits
        assert motor is not None
        assert motor.max_voltage / motor.torque_constant / motor.gear_ratio == pytest.approx(1.3 * limits.speed)
        assert motor.gear_ratio * motor.torque_constant * motor.max_current == pytest.approx(1.5 * limits.torque)
        left = motor.max_voltage - motor.torque_constant * motor.gear_ratio * limits.speed
        assert left > motor.resistance * motor.max_current  # full torque at full speed
        reflected = motor.rotor_inertia * motor.gear_ratio**2
        assert reflected >= 0.5 * link * (1 - 1e-12)
        assert reflected == pytest.approx(max(0.5 * link, 0.01 * limits.torque / limits.speed))
    np.testing.assert_allclose(np.diagonal(sized.mass_matrix(q)) - own, [
        j.motor.rotor_inertia * j.motor.gear_ratio**2 for j in sized.model.joints if j.motor
    ], rtol=1e-9)  # fmt: skip


def test_it_carries_its_weight_where_the_torque_limit_does(arm: Arm) -> None:
    q = poses(arm)
    sized, limit = sized_drives(arm, q[0]), arm.limits.torque
    weight = np.abs(sized.gravity(q))
    most = np.array([j.motor.gear_ratio * j.motor.torque_constant * j.motor.max_current for j in sized.model.joints])
    carried = weight <= limit
    assert (weight <= most)[carried].all()
    assert carried.any()


@pytest.mark.parametrize("controller", ["cascade", "computed_torque"])
def test_the_servos_take_it(arm: Arm, controller: str) -> None:
    q = poses(arm, 1)[0]
    servos = ArmServos(sized_drives(arm, q), q, ControlSettings(controller))
    assert len(servos.axes) == arm.n
    for name in ("current", "speed", "position"):
        assert all(np.isfinite(list(row)).all() for row in servos.axes[name].tolist())


def test_what_cannot_be_sized_is_named(data_folder: Path) -> None:
    with pytest.raises(ModelError, match=r"joint 'joint_a1' has no torque limit .*drives = \"ideal\""):
        sized_drives(load_arm(data_folder / "robots/urdf/rtb_data/kr210l150.urdf"), np.zeros(6))
    with pytest.raises(ModelError, match=r"has no speed limit"):
        sized_drives(load_arm(data_folder / "robots/urdf/rtb_data/al5d_robot.urdf"), np.zeros(4))
    with pytest.raises(MissingInertia, match="states no inertia"):
        sized_drives(load_arm(data_folder / "robots/urdf/rtb_data/irb140.urdf"), np.zeros(6))
    stanford = load_arm("stanford")
    joints = tuple(dataclasses.replace(j, limits=JointLimits(speed=1.0, torque=9.0)) for j in stanford.model.joints[:2])
    with pytest.raises(ModelError, match=r"'[^']*' has no speed limit \(in m/s and N\)"):
        sized_drives(
            Arm(dataclasses.replace(stanford.model, joints=(*joints, *stanford.model.joints[2:]))), np.zeros(6)
        )
