"""Forward kinematics, Jacobian and closed-form inverse in batches, one thread; medians over the robots."""

from __future__ import annotations

import numpy as np
from peers import eaik_robot, peer, pinocchio_model
from robots import medians

from holonom import Arm
from holonom.app.about.bench import Figure, Setting, seconds

SIZES = (4096, 65536)
LOOP = 256  # samples of a peer that takes one at a time


def measure(setting: Setting) -> list[Figure]:
    return [f for rows in (SIZES[:1] if setting.small else SIZES) for f in _at(rows, setting)]


def _at(rows: int, setting: Setting) -> list[Figure]:
    fk, both, frame = medians(lambda arm: _forward(arm, rows, setting))
    ik, eaik = medians(lambda arm: _inverse(arm, rows, setting), ("puma560", "ur5e"))
    assert fk is not None
    assert both is not None
    assert ik is not None
    return [
        Figure(f"forward kinematics, {rows} rows", fk, "ns", goal=40.0),
        Figure(f"fk and Jacobian, {rows} rows", both, "ns", "Pinocchio computeFrameJacobian, loop", frame, goal=10.0),
        Figure(f"all inverse branches, {rows} poses", ik, "ns", goal=500.0),
        Figure(f"all inverse branches, {rows} poses", ik, "ns", "EAIK, loop", eaik, goal=10.0),
    ]


def _configurations(arm: Arm, rows: int, setting: Setting) -> np.ndarray:
    limits = arm.limits
    return setting.rng.uniform(np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi), (rows, arm.n))


def _forward(arm: Arm, rows: int, setting: Setting) -> list[float | None]:
    """Nanoseconds per sample: fk, fk with Jacobian, Pinocchio's (its frame Jacobian places the frame too)."""
    q = _configurations(arm, rows, setting)
    T, J = np.empty((rows, 4, 4)), np.empty((rows, 6, arm.n))
    fk = seconds(lambda: arm.fk(q, out=T), setting) / rows
    both = seconds(lambda: (arm.fk(q, out=T), arm.jacobian(q, out=J)), setting) / rows
    pin = peer("pinocchio")
    if pin is None:
        return [1e9 * fk, 1e9 * both, None]
    model = pinocchio_model(pin, arm)
    data, tool = model.createData(), model.getFrameId("tool")
    frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def loop() -> None:
        for row in q[:LOOP]:
            pin.computeFrameJacobian(model, data, row, tool, frame)

    return [1e9 * fk, 1e9 * both, 1e9 * seconds(loop, setting) / LOOP]


def _inverse(arm: Arm, rows: int, setting: Setting) -> list[float | None]:
    """Nanoseconds per pose: ours with every branch proved by forward kinematics, EAIK's."""
    T = arm.fk(_configurations(arm, rows, setting))
    ours = seconds(lambda: arm.ik(T), setting) / rows
    eaik = peer("eaik.IK_HP")
    if eaik is None:
        return [1e9 * ours, None]
    robot, R_home = eaik_robot(eaik, arm.model)
    asked = T[:LOOP].copy()
    asked[:, :3, :3] = asked[:, :3, :3] @ R_home.T

    def loop() -> None:
        for pose in asked:
            robot.IK(pose)

    return [1e9 * ours, 1e9 * seconds(loop, setting) / LOOP]
