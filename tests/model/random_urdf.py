"""URDF text at random: a tree of fixed, revolute, continuous, prismatic and mimic joints, its elements shuffled."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

KINDS = ("revolute", "continuous", "prismatic", "fixed")


def words(values) -> str:
    return " ".join(repr(float(x)) for x in values)


def origin(rng) -> str:
    return f'<origin xyz="{words(rng.uniform(-0.4, 0.4, 3))}" rpy="{words(rng.uniform(-3, 3, 3))}"/>'


def inertial(rng) -> str:
    """Principal moments of a box, turned."""
    a, b, c = np.square(rng.uniform(0.05, 0.4, 3))
    R = Rotation.random(rng=rng).as_matrix()
    m = rng.uniform(0.2, 3.0)
    I = R @ np.diag([b + c, a + c, a + b]) @ R.T * m / 12
    moments = " ".join(f'i{"xyz"[i]}{"xyz"[j]}="{float(I[i, j])!r}"' for i in range(3) for j in range(i, 3))
    return f'<inertial>{origin(rng)}<mass value="{m!r}"/><inertia {moments}/></inertial>'


def random_urdf(seed: int, links: int) -> str:
    """Link 0 is the root; every third link hangs on any earlier one, the others on the one before."""
    rng = np.random.default_rng(seed)
    elements = [f'<link name="body{k}">{inertial(rng) if rng.random() < 0.8 else ""}</link>' for k in range(links)]
    free = []
    for k in range(1, links):
        kind = "revolute" if k == 1 else KINDS[int(rng.integers(4))]
        parent = int(rng.integers(k)) if k % 3 == 0 else k - 1
        axis = np.eye(3)[rng.integers(3)] * rng.choice([-1, 1]) if rng.random() < 0.5 else rng.normal(size=3)
        limit = '<limit lower="-2" upper="2" velocity="3" effort="40"/>' if kind in ("revolute", "prismatic") else ""
        mimic = ""
        if kind in ("revolute", "prismatic") and free and k % 4 == 0:
            mimic = f'<mimic joint="{free[0]}" multiplier="-0.6" offset="0.2"/>'
        elif kind in ("revolute", "prismatic"):
            free.append(f"joint{k}")
        elements.append(
            f'<joint name="joint{k}" type="{kind}">{origin(rng)}<parent link="body{parent}"/><child link="body{k}"/>'
            f'<axis xyz="{words(axis)}"/>{limit}{mimic}</joint>'
        )
    rng.shuffle(elements)
    return f'<robot name="random{seed}">\n' + "\n".join(elements) + "\n</robot>\n"
