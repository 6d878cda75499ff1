"""What a person waits for: compiling an arm's kernels cold and from the cache, importing, the command's help."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time

from holonom.app.about.bench import Figure, Setting

KERNELS = """
import time, numba, numpy as np, scipy.spatial.transform
import holonom as hm
begin = time.perf_counter()
arm = hm.load_arm("puma560")
for q in (np.zeros(6), np.zeros((70, 6))):
    T = arm.fk(q)
    arm.jacobian(q), arm.inverse_dynamics(q, q, q), arm.forward_dynamics(q, q, q), arm.mass_matrix(q)
    arm.kernel("inverse_geometry")(T)
print(time.perf_counter() - begin)
"""


def measure(setting: Setting) -> list[Figure]:
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | ({} if setting.small else {"HOLONOM_CACHE": folder})
        cold = None if setting.small else _kernels(environment)
        _kernels(environment)
        warm = statistics.median(_kernels(environment) for _ in range(1 if setting.small else 5))
    figures = [] if cold is None else [Figure("compile 6 kernels, both forms, cold", cold, "s", goal=15.0)]
    return [
        *figures,
        Figure("the same from the cache", warm, "s", goal=0.5),
        Figure("python -c 'import holonom'", _whole(["-c", "import holonom"], setting), "s", goal=0.2),
        Figure("holonom --help", _whole(["-m", "holonom", "--help"], setting), "s", goal=0.3),
    ]


def _kernels(environment: dict[str, str]) -> float:
    command = [sys.executable, "-c", KERNELS]
    return float(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)


def _whole(arguments: list[str], setting: Setting) -> float:
    """Median time of a whole process, the interpreter's start included."""
    times = []
    for _ in range(2 if setting.small else 9):
        begin = time.perf_counter()
        subprocess.run([sys.executable, *arguments], capture_output=True, check=True)
        times.append(time.perf_counter() - begin)
    return statistics.median(times)
