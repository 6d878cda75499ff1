"""Arms for the laws: the presets, and random chains."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from holonom.mechanics import Arm, load_arm
from holonom.model import ArmModel, Body, DHRow, JointLimits, Mimic, arm_model_from_dh, constant_transform, preset_names
from holonom.model.compound import joints_of


def random_pose(rng: np.random.Generator) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.random(rng=rng).as_matrix()
    T[:3, 3] = rng.uniform(-0.3, 0.3, 3)
    return T


def random_body(rng: np.random.Generator) -> Body:
    """A cloud of point masses: physically consistent by construction."""
    m = rng.uniform(0.1, 2.0, 8)
    r = rng.uniform(-0.3, 0.3, (8, 3))
    c = m @ r / m.sum()
    S = (m[:, None] * (r - c)).T @ (r - c)
    inertia = np.trace(S) * np.eye(3) - S
    return Body(
        float(m.sum()),
        tuple(c.tolist()),
        (*np.diagonal(inertia).tolist(), inertia[0, 1].item(), inertia[1, 2].item(), inertia[0, 2].item()),
    )


def random_model(seed: int, n: int) -> ArmModel:
    """A chain of n revolute and prismatic joints with general DH rows, base, tool and bodies."""
    import dataclasses

    rng = np.random.default_rng(seed)
    rows = [
        DHRow(*rng.uniform(-0.5, 0.5, 1), *rng.uniform(-3, 3, 1), *rng.uniform(-0.5, 0.5, 1), *rng.uniform(-3, 3, 1),
              kind="prismatic" if rng.random() < 0.3 else "revolute")
        for _ in range(n)
    ]  # fmt: skip
    model = arm_model_from_dh(
        rows,
        convention="standard" if rng.random() < 0.5 else "modified",
        name=f"random{seed}",
        limits=[JointLimits(-2.0, 2.0, 3.0, 10.0, 50.0)] * n,
        bodies=[random_body(rng) for _ in range(n)],
    )
    return dataclasses.replace(
        model,
        base=constant_transform(random_pose(rng)),
        tool=constant_transform(random_pose(rng)),
        gravity=tuple(rng.uniform(-10, 10, 3).tolist()),
    )


def random_tree(seed: int, n: int) -> ArmModel:
    """A random chain regrown into branches: one joint follows another, one is planar, the tool is on a branch.

    Fixed joints are in the bodies and in the poses between joints.
    """
    import dataclasses

    rng = np.random.default_rng(seed)
    chain = random_model(seed, n)
    joints = [dataclasses.replace(joint, parent=int(rng.integers(-1, i))) for i, joint in enumerate(chain.joints)]
    joints[-2] = dataclasses.replace(joints[-2], mimic=Mimic(0, -0.7, 0.3))
    weightless = Body(0.0, (0.0, 0.0, 0.0), (0.0,) * 6)
    table = joints_of("table", "planar", random_pose(rng), random_pose(rng), number=n, parent=int(rng.integers(n)))
    return dataclasses.replace(
        chain,
        name=f"tree{seed}",
        joints=(*joints, *table),
        bodies=(*chain.bodies, weightless, weightless, random_body(rng)),
        tip=n - 2,
    )


def presets() -> list[Arm]:
    return [load_arm(name) for name in preset_names()]
