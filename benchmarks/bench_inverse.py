"""Numerical inverse of random reachable poses of a seven-joint arm, limits on, no starts given, one thread.

The peers get the same poses and tolerance: the Robotics Toolbox' compiled `ik_LM` (its `tol` is half the square of the
error), and the usual damped loop over Pinocchio with random restarts.
"""

from __future__ import annotations

import numpy as np
from peers import peer, pinocchio_model

from holonom import load_arm
from holonom.app.about.bench import Figure, Setting, seconds
from holonom.mechanics import Arm
from holonom.mechanics.numerical_inverse import InverseStatus, inverse_solver

ROWS, LOOP = 4096, 200  # poses in a batch; poses of a peer that takes one at a time
TOLERANCE, STEPS, RESTARTS = 1e-6, 30, 100
NAME = "numerical inverse, panda"


def measure(setting: Setting) -> list[Figure]:
    arm = load_arm("panda")
    rows, loop = (64, 4) if setting.small else (ROWS, LOOP)
    T = arm.fk(setting.rng.uniform(arm.limits.lower, arm.limits.upper, (rows, arm.n)))
    solve = inverse_solver(arm)
    found = solve(T)
    whole = seconds(lambda: solve(T), setting, rounds=7) / rows
    median = whole * np.median(found.iterations) / np.mean(found.iterations)
    share = 100.0 * float(np.mean(found.status == InverseStatus.OK))
    single = seconds(lambda: solve(T[0], found.q[0] * 0.999), setting, calls=100)
    figures = [
        Figure(f"{NAME}, solved to 1e-6", share, "%", goal=99.9, more_is_better=True),
        Figure(f"{NAME}, median pose of a batch (by steps)", 1e6 * median, "us", goal=30.0),
        Figure(f"{NAME}, mean of a batch", 1e6 * whole, "us", goal=30.0),
        Figure(f"{NAME}, one call from a near start", 1e6 * single, "us"),
    ]
    for name, theirs in (
        ("Robotics Toolbox ik_LM, loop", _toolbox(arm, T[:loop], setting)),
        ("Pinocchio, damped loop", _pinocchio(arm, T[:loop], setting)),
    ):
        time, solved = (None, None) if theirs is None else theirs
        figures.append(Figure(f"{NAME}, mean", 1e6 * whole, "us", name, time))
        figures.append(Figure(f"{NAME}, solved", share, "%", name, solved, more_is_better=True))
    return figures


def _toolbox(arm: Arm, T: np.ndarray, setting: Setting) -> tuple[float, float] | None:
    """Microseconds per pose and share solved (%)."""
    toolbox = peer("roboticstoolbox")
    if toolbox is None:
        return None
    robot = _chain_of_transforms(toolbox, arm)
    solve = lambda pose: robot.ik_LM(pose, ilimit=STEPS, slimit=RESTARTS, tol=0.5 * TOLERANCE**2)  # noqa: E731
    time = seconds(lambda: [solve(pose) for pose in T], setting, rounds=2) / len(T)
    return 1e6 * time, 100.0 * float(np.mean([bool(solve(pose).success) for pose in T]))


def _chain_of_transforms(toolbox, arm: Arm):
    """The arm as the toolbox' elementary transforms, with its joint limits."""
    ET, chain = toolbox.ET, toolbox.ETS([toolbox.ET.SE3(np.array(arm.model.base))])
    for joint in arm.model.joints:
        limits = np.array([joint.limits.lower, joint.limits.upper])
        chain = chain * ET.SE3(np.array(joint.before)) * ET.Rz(qlim=limits) * ET.SE3(np.array(joint.after))
    return chain * ET.SE3(np.array(arm.model.tool))


def _pinocchio(arm: Arm, T: np.ndarray, setting: Setting) -> tuple[float, float] | None:
    """Microseconds per pose and share solved (%) of Pinocchio's own example of an inverse, limits by clipping."""
    pin = peer("pinocchio")
    if pin is None:
        return None
    model = pinocchio_model(pin, arm)
    data, tool = model.createData(), model.getFrameId("tool")
    lower, upper = arm.limits.lower, arm.limits.upper

    def solve(pose: np.ndarray) -> bool:
        rng, goal = np.random.default_rng(0), pin.SE3(pose)
        for _ in range(RESTARTS):
            q = rng.uniform(lower, upper)
            for _ in range(STEPS):
                pin.framesForwardKinematics(model, data, q)
                error = pin.log6(data.oMf[tool].actInv(goal)).vector
                if np.linalg.norm(error) < TOLERANCE:
                    return True
                J = pin.computeFrameJacobian(model, data, q, tool)
                damping = (0.01 * error @ error + 1e-12) * np.eye(6)
                q = np.clip(q + J.T @ np.linalg.solve(J @ J.T + damping, error), lower, upper)
        return False

    time = seconds(lambda: [solve(pose) for pose in T], setting, rounds=2) / len(T)
    return 1e6 * time, 100.0 * float(np.mean([solve(pose) for pose in T]))
