"""The drive-level simulation of six axes against real time, and the demo's memory."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from holonom import load_arm
from holonom.app.about.bench import Figure, Setting, seconds
from holonom.closed_loop import ArmLoop
from holonom.machine import ControlSettings
from holonom.mechanics.motion import plan_joint

CELL = Path(__file__).parents[1] / "examples" / "01_sort_coins" / "cell.toml"


def measure(setting: Setting) -> list[Figure]:
    figures = [against_real_time(controller, setting) for controller in ("cascade", "computed_torque")]
    return figures if setting.small else [*figures, *_demo()]


def against_real_time(controller: str, setting: Setting) -> Figure:
    """Current loop at 10 kHz, speed loop at 2 kHz, position loop at 1 kHz, called in ticks of 10 ms as by a program."""
    arm = load_arm("puma560")
    q0, q1 = np.array([0.0, 0.7, -2.8, 0.0, 0.5, 0.0]), np.array([0.8, 0.3, -2.2, 0.6, 0.9, -0.8])
    there = plan_joint(q0, q1, arm.limits, speed=0.8, acceleration=0.8)
    back = plan_joint(q1, q0, arm.limits, speed=0.8, acceleration=0.8)
    samples = np.concatenate([np.stack([t.q, t.qd, t.qdd]) for t in (there, back)], axis=1)
    ticks = [np.ascontiguousarray(samples[:, k : k + 10]) for k in range(0, samples.shape[1] - 9, 10)]
    loop = ArmLoop(arm, q0, ControlSettings(controller))

    def run() -> None:
        for tick in ticks:
            loop.advance(tick)

    elapsed = seconds(run, setting, rounds=9)
    return Figure(
        f"six axes with drives, {controller}",
        0.01 * len(ticks) / elapsed,
        "x real time",
        goal=100.0,
        more_is_better=True,
    )


def _demo() -> list[Figure]:
    """The whole demo in a process of its own: simulated over wall time, and the largest resident set."""
    script = (
        "import resource, sys, time; from pathlib import Path; from holonom.app.run import run_cell;"
        "begin = time.perf_counter(); answer = run_cell(Path(sys.argv[1]), Path(sys.argv[2]));"
        "print(answer.data['simulated_time_s'] / (time.perf_counter() - begin),"
        "resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)"
    )
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", script, str(CELL), folder]
        found = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    return [
        Figure("the whole demo, recording and report too", float(found[0]), "x real time"),
        Figure("peak memory of the demo", float(found[1]), "MiB", goal=1024.0),
    ]
