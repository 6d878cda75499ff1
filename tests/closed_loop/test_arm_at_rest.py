"""Joint friction holds an arm: without current it stands, for as long as its load stays below breakaway."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import holonom as hm
from holonom.closed_loop.arm_loop import ArmLoop
from holonom.devices import friction_torque
from holonom.errors import DriveFault, ModelError
from holonom.machine.arm.kernels import CURRENT
from holonom.machine.arm.servos import ControlSettings, joint_friction
from holonom.mechanics import Arm
from holonom.mechanics.equations.dynamics.newton_euler import friction_torque as joint_torque
from holonom.model import Friction

ARM = hm.load_arm("puma560")
UPRIGHT = np.array([0.3, -np.pi / 2 - 0.2, np.pi / 2 + 0.1, 0.2, 0.5, -0.4])


def without_current(
    q: np.ndarray, seconds: float, push: np.ndarray, arm: Arm = ARM, part: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Joints 1 s after the motors let go, and at the end; `push` are speeds (n,), rad/s, that it starts with.

    With a `part`, motors keep that part of the current that would hold it without friction.
    """
    loop = ArmLoop(arm, q, ControlSettings(following_error=1.0))
    loop.plant.states["speed"] = push
    loop.servos.states["current_reference"] = part * loop.plant.hold
    reference = np.zeros((3, 1000, ARM.n))
    reference[0] = q
    loop._advance(CURRENT, reference)
    settled = loop.truth.position
    reference = np.repeat(reference[:, :1], int(1000 * (seconds - 1.0)), axis=1)
    loop._advance(CURRENT, reference)
    return settled, loop.truth.position


@pytest.mark.parametrize("push", [0.0, 0.05])
def test_below_breakaway_an_arm_stands_for_a_minute(push: float) -> None:
    friction = [joint.friction for joint in ARM.model.joints]
    load = np.abs(ARM.gravity(UPRIGHT))
    assert all(g < min(f.coulomb_positive, f.coulomb_negative) for g, f in zip(load, friction, strict=True) if f)
    assert load.max() > 5.0
    settled, end = without_current(UPRIGHT, 60.0, np.full(ARM.n, push))
    assert np.abs(end - settled).max() < 1e-9
    assert np.abs(settled - UPRIGHT).max() < 0.05


def test_beyond_breakaway_it_falls() -> None:
    stretched = np.zeros(ARM.n)
    assert abs(ARM.gravity(stretched)[1]) > 30.0
    with pytest.raises(DriveFault, match="shoulder"):
        without_current(stretched, 1.2, np.zeros(ARM.n))


def changed(friction: Friction | None = None, **motor: float) -> Arm:
    """The arm with other friction, the same in each joint, and other numbers of its motors."""
    joints = tuple(
        dataclasses.replace(joint, friction=friction, motor=dataclasses.replace(joint.motor, **motor))
        for joint in ARM.model.joints
        if joint.motor
    )
    return Arm(dataclasses.replace(ARM.model, joints=joints))


def test_static_friction_that_a_model_states_holds_it() -> None:
    load = float(np.abs(ARM.gravity(UPRIGHT)).max())
    sliding = Friction(0.0, load / 1.2, load / 1.2)
    _, end = without_current(UPRIGHT, 2.0, np.zeros(ARM.n), changed(sliding))
    assert np.abs(end - UPRIGHT).max() > 0.05
    sticking = dataclasses.replace(sliding, static_ratio=1.5, stribeck_speed=0.05)
    settled, end = without_current(UPRIGHT, 5.0, np.zeros(ARM.n), changed(sticking))
    assert np.abs(end - settled).max() < 1e-9
    with pytest.raises(ModelError, match="stribeck_speed 0"):
        without_current(UPRIGHT, 5.0, np.zeros(ARM.n), changed(dataclasses.replace(sticking, stribeck_speed=0.0)))


@given(
    qd=st.floats(-3.0, 3.0).filter(lambda qd: abs(qd) > 1e-3),
    ratio=st.sampled_from([-62.6, 107.8]),
    static=st.floats(1.0, 3.0),
    width=st.floats(0.01, 1.0),
)
def test_friction_at_the_motor_is_the_models(qd: float, ratio: float, static: float, width: float) -> None:
    joint = dataclasses.replace(ARM.model.joints[0], friction=Friction(0.7, 5.0, 4.0, static, width))
    at_motor = joint_friction(joint, ratio)
    assert ratio * friction_torque(at_motor.params(1e-12), ratio * qd) == pytest.approx(
        float(joint_torque(joint.friction, qd)), rel=1e-9
    )


@pytest.mark.parametrize("part", [0.75, 1.0, 1.3])
def test_efficient_gears_at_rest_hold(part: float) -> None:
    """Currents between what would lift the arm and what would let it down: nothing moves, nothing chatters."""
    arm = changed(gear_efficiency=0.7)
    settled, end = without_current(UPRIGHT, 3.0, np.zeros(ARM.n), arm, part)
    assert np.abs(settled - UPRIGHT).max() < 2e-3
    assert np.abs(end - settled)[1:5].max() < 1e-9  # waist and flange carry no load that would hold them
    with pytest.raises(ModelError, match=r"gear_efficiency is 1\.2"):
        changed(gear_efficiency=1.2)
