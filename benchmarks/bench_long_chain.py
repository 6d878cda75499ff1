"""A chain of 30 joints: what a person waits for before the longest of its kernels answers for the first time."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

from holonom.app.about.bench import Figure, Setting

KERNELS = (
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
    "regressor",
    "christoffel",
    "coupling_table",
    "jacobian_hessian",
)
COMPILE = """
import sys, time, numba, numpy as np, scipy.spatial.transform
import holonom as hm
from holonom.model import Body, DHRow
name, form, n = sys.argv[1], sys.argv[2], int(sys.argv[3])
rng = np.random.default_rng(0)
rows = [DHRow(*rng.uniform(-0.5, 0.5, 4), kind=kind) for kind in rng.choice(["revolute", "prismatic"], n, p=[0.7, 0.3])]
bodies = [Body(1.0, tuple(rng.uniform(-0.1, 0.1, 3)), (0.1, 0.1, 0.1, 0.01, 0.01, 0.01)) for _ in rows]
arm = hm.arm_from_dh(rows, convention="standard", name="chain", bodies=bodies)
begin = time.perf_counter()
getattr(arm.kernel(name), form)
print(time.perf_counter() - begin)
"""


def measure(setting: Setting) -> list[Figure]:
    joints, names = (3, KERNELS[:1]) if setting.small else (30, KERNELS)
    return [
        Figure(f"compile {joints} joints' {name}, {what}", _cold(name, form, joints), "s", goal=30.0)
        for name in names
        for form, what in (("made", "one sample"), ("rows", "batch"))
    ]


def _cold(name: str, form: str, joints: int) -> float:
    """Seconds to trace and compile one form of a kernel, in a process of its own."""
    command = [sys.executable, "-c", COMPILE, name, form, str(joints)]
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"HOLONOM_CACHE": folder}
        return float(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)
