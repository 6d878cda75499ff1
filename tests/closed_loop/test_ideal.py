"""Ideal drives: joints and wheels do what they are told within limits; laws that are not compiled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from demo_cell import ARM, HOME, motion
from simulated_bases import BASES, DRIVE, soccer

from holonom.closed_loop import ArmLoop, BaseLoop, IdealArm
from holonom.control.methods import CONTROLLERS
from holonom.errors import DriveFault, LevelFault, ModelError
from holonom.machine import BaseController, BaseSettings, ControlSettings, LineSettings, PathLimits, plan_path
from holonom.machine.arm.queue import MotionQueue
from holonom.machine.base.paths import figure_of_eight
from holonom.registry import OWN, Method, parameter
from holonom.sim import BasePlant

IDEAL = BaseSettings().without_motors()


def follow(loop: ArmLoop | IdealArm, goal: np.ndarray) -> np.ndarray:
    """Make a motion; the largest error of each joint on the way."""
    queue = MotionQueue(ARM, HOME, LineSettings())
    queue.move(motion(goal), idle=True)
    worst = np.zeros(6)
    while not queue.empty:
        reference = queue.take(10)
        loop.advance(reference)
        worst = np.maximum(worst, np.abs(reference[0, -1] - loop.truth.position))
    return worst


def test_ideal_joints_are_where_they_are_told() -> None:
    arm = IdealArm(ARM, HOME, ControlSettings())
    assert (follow(arm, HOME + 0.3) < 1e-12).all()
    assert (arm.worst["speed"] <= ARM.limits.speed * (1 + 1e-9)).all()
    assert arm.worst["speed"].max() > 0.3
    arm.brake(10)
    assert (arm.speed == 0.0).all()


@pytest.mark.parametrize("wrong", [np.nan, 10.0])
def test_an_ideal_joint_refuses_what_it_cannot_do(wrong: float) -> None:
    arm, target = IdealArm(ARM, HOME, ControlSettings()), HOME.copy()
    target[1] = wrong
    with pytest.raises((DriveFault, LevelFault), match="shoulder"):
        arm.advance(np.stack([target[None], np.zeros((1, 6)), np.zeros((1, 6))]))
    np.testing.assert_array_equal(arm.position, HOME)


@pytest.mark.parametrize("name", ["omni 4", "mecanum", "differential"])
def test_ideal_wheels_turn_as_told_and_never_slip(name: str) -> None:
    path = plan_path(figure_of_eight(2.0), PathLimits(1.0, 1.5), heading="tangent")
    reference = np.hstack([path.pose, path.twist, path.acceleration])
    loop = BaseLoop(BaseController(BASES[name], DRIVE, IDEAL), BasePlant(BASES[name], DRIVE, ideal=True))
    loop.place(reference[0, :3])
    loop.controller.follow_path(reference)
    log = loop.buffer(len(path.time))
    done = loop.advance_logged(log)
    error = np.hypot(log.body["x"] - log.controlled["ref_x"], log.body["y"] - log.controlled["ref_y"])[:done]
    assert error.max() < 0.01
    assert np.abs(log.wheels["slip"]).max() == 0.0
    speeds = log.wheels["speed"].reshape(done if done == len(log.body) else len(log.body), -1)[:done]
    rims = speeds[:, : len(loop.plant.radii)] * loop.plant.radii
    twist = np.column_stack([log.body[n][:done] for n in ("vx", "vy", "w")])
    np.testing.assert_allclose(rims, twist @ loop.plant.rows.T, atol=1e-9)


@dataclass(frozen=True)
class Gain:
    """A spring and a damper, with the weight carried."""

    stiffness: float = parameter(400.0, meaning="stiffness over inertia", unit="1/s2", above=0.0, most=1e4)

    def torques(self, arm, reference, position, speed, dt):
        k = self.stiffness
        u = reference[2] + k * (reference[0] - position) + 2 * np.sqrt(k) * (reference[1] - speed)
        return arm.inverse_dynamics(position, reference[1], u)


METHOD = Method("computed torque, in Python", lambda params: params, OWN, Gain)


def test_a_law_in_python_moves_the_arm(monkeypatch: pytest.MonkeyPatch) -> None:
    """Written anew here it follows as the compiled one does."""
    monkeypatch.setattr(CONTROLLERS, "_own", {**CONTROLLERS._own, "spring": METHOD})
    loop = ArmLoop(ARM, HOME, ControlSettings("spring", following_error=0.2))
    worst = follow(loop, HOME + 0.2)
    compiled = follow(ArmLoop(ARM, HOME, ControlSettings("computed_torque")), HOME + 0.2)
    assert worst.max() < 0.02
    assert worst.max() < 20 * compiled.max()


def test_a_law_that_gives_nonsense_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclass(frozen=True)
    class Nothing(Gain):
        def torques(self, arm, reference, position, speed, dt):
            return np.full(6, np.nan)

    nothing, text = (Method("?", make, OWN, Nothing) for make in (lambda params: params, lambda params: "text"))
    monkeypatch.setattr(CONTROLLERS, "_own", {"nothing": nothing, "text": text})
    with pytest.raises(LevelFault, match="'nothing' gave torques"):
        follow(ArmLoop(ARM, HOME, ControlSettings("nothing")), HOME + 0.2)
    with pytest.raises(ModelError, match="a JointLaw is needed"):
        ArmLoop(ARM, HOME, ControlSettings("text"))


def test_an_ideal_base_keeps_velocities() -> None:
    loop = BaseLoop(BaseController(soccer(), DRIVE, IDEAL), BasePlant(soccer(), DRIVE, ideal=True))
    loop.place((0.0, 0.0, 0.0))
    for _ in range(100):
        loop.controller.follow_velocity((0.4, 0.2, 0.5))
        loop.advance(10)
    np.testing.assert_allclose(loop.plant.twist, [0.4, 0.2, 0.5], atol=1e-6)
