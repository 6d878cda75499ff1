"""Drives: one axis under its three loops beside MuJoCo's motor, a synchronous one beside gym-electric-motor, at 10 kHz.

The PI forms and the six-axis arm are here, too: one table of what the drives cost.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import bench_axis
import bench_regulators
import bench_simulation
import numpy as np
from peers import peer

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.devices import Dq, Pmsm, PmsmParams, pmsm_step, pmsm_torque, run_pmsm
from holonom.trace.code.loops import loop

MOTOR = Pmsm(18e-3, 0.37e-3, 1.2e-3, 66e-3, 3, 0.03883, 300.0, 400.0)
"""The peer's own example."""
STEP = 1e-4
LOAD = 1.0
"""Inertia at the shaft, kg m2: heavy, so that the speed stays where the motor is not weakened."""


@loop
def plant(params: PmsmParams, steps: int) -> float:
    """Motor and shaft alone, at held voltages; returns the last speed."""
    current, speed = Dq(0.0, 0.0), 0.0
    for _ in range(steps):
        before = pmsm_torque(params, current)
        current = pmsm_step(params, current, Dq(-1.0, 2.0), speed, 1e-4)
        speed += 1e-4 * 0.5 * (before + pmsm_torque(params, current)) / 1.03883
    return speed


def measure(setting: Setting) -> list[Figure]:
    arm = bench_simulation.against_real_time("cascade", setting)
    return [*bench_axis.measure(setting), *bench_regulators.measure(setting), *_synchronous(setting), arm]


def _synchronous(setting: Setting) -> list[Figure]:
    steps = 1000 if setting.small else 100_000
    levels = setting.rng.uniform(-60.0, 60.0, steps // 5)
    torque = np.repeat(levels, 5)  # of a speed loop at 2 kHz
    drive = seconds(lambda: run_pmsm(MOTOR, torque, load_inertia=LOAD), setting, rounds=9) / steps
    alone = seconds(lambda: plant(MOTOR.params(), steps), setting, rounds=9) / steps
    whole, physics = _peer(setting)
    return [
        _figure("PMSM drive at 10 kHz: motor, shaft, field orientation", drive, "gym-electric-motor step", whole),
        _figure("PMSM and shaft alone at 10 kHz", alone, "gym-electric-motor physics", physics),
    ]


def _figure(what: str, ours: float, name: str, peer_time: float | None, goal: float = 1000.0) -> Figure:
    pace = None if peer_time is None else STEP / peer_time
    return Figure(what, STEP / ours, "x real time", name, pace, goal, more_is_better=True)


def _peer(setting: Setting) -> tuple[float | None, float | None]:
    """Seconds of a step of the peer's environment, without a regulator, and of its physics alone."""
    gem = peer("gym_electric_motor")
    if gem is None:
        return None, None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        environment = gem.make("Cont-TC-PMSM-v0").unwrapped
        action, count = np.array([0.02, -0.01, -0.01]), 20 if setting.small else 500
        environment.reset()

        def step() -> None:
            (_, _), _, ended, cut, _ = environment.step(action)
            if ended or cut:
                environment.reset()

        whole = _mean(step, setting, count)
        physics = environment.physical_system
        physics.reset()
        return whole, _mean(lambda: physics.simulate(action), setting, count)


def _mean(step: Callable[[], object], setting: Setting, count: int) -> float:
    return seconds(step, setting, calls=count, rounds=9)
