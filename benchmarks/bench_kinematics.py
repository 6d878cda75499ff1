"""Forward kinematics, Jacobian and closed-form inverse in batches, one thread."""

from __future__ import annotations

import numpy as np
from peers import eaik_robot, peer, pinocchio_model

from holonom import load_arm
from holonom.app.bench import Figure, Setting, seconds

ROWS = 4096
LOOP = 256  # samples of a peer that takes one at a time


def measure(setting: Setting) -> list[Figure]:
    arm, pin = load_arm("puma560"), peer("pinocchio")
    limits = arm.limits
    q = setting.rng.uniform(limits.lower, limits.upper, (ROWS, 6))
    T, J = np.empty((ROWS, 4, 4)), np.empty((ROWS, 6, 6))
    fk = seconds(lambda: arm.fk(q, out=T), setting) / ROWS
    both = seconds(lambda: (arm.fk(q, out=T), arm.jacobian(q, out=J)), setting) / ROWS
    ik = seconds(lambda: arm.ik(T), setting) / ROWS
    return [
        Figure("forward kinematics, 4096 rows", 1e9 * fk, "ns", goal=40.0),
        Figure(
            "fk and Jacobian, 4096 rows", 1e9 * both, "ns", "Pinocchio, loop", _pinocchio(pin, arm, q, setting), 10.0
        ),
        Figure("all 8 inverse branches, 4096 poses", 1e9 * ik, "ns", goal=500.0),
        Figure("all 8 inverse branches, 4096 poses", 1e9 * ik, "ns", "EAIK, loop", _eaik(arm, T, setting), 10.0),
    ]


def _pinocchio(pin, arm, q, setting: Setting) -> float | None:
    if pin is None:
        return None
    model = pinocchio_model(pin, arm)
    data, tool = model.createData(), model.getFrameId("tool")
    frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def loop() -> None:
        for row in q[:LOOP]:
            pin.computeFrameJacobian(model, data, row, tool, frame)  # places the frame too

    return 1e9 * seconds(loop, setting) / LOOP


def _eaik(arm, T, setting: Setting) -> float | None:
    dh = peer("eaik.IK_DH")
    if dh is None:
        return None
    robot = eaik_robot(dh, arm)

    def loop() -> None:
        for pose in T[:LOOP]:
            robot.IK(pose)

    return 1e9 * seconds(loop, setting) / LOOP
