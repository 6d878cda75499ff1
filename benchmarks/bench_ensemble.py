"""Variations of a six-joint arm under computed torque: lanes beside one compiled simulation each and Python loops."""

from __future__ import annotations

import os

import numpy as np
from peers import peer, pinocchio_model

from holonom import load_arm
from holonom.app.about.bench import Figure, Setting, seconds
from holonom.mechanics import Arm
from holonom.mechanics.simulate import ComputedTorque, simulate, simulate_ensemble

Q0, STILL, DT = np.array([0.1, 0.7, -2.8, 0.2, 0.5, 0.1]), np.zeros(6), 1e-3
GAINS = 400.0, 40.0
GOAL = Q0 + 0.3


def measure(setting: Setting) -> list[Figure]:
    """Microseconds per variation and second of motion: 1,000 steps of RK4."""
    arm, law = load_arm("puma560"), ComputedTorque(*GAINS, GOAL)
    count, time = (64, 0.01) if setting.small else (1024, 1.0)
    payload = setting.rng.uniform(0.0, 3.0, count)

    def together(threads: int) -> float:
        return seconds(
            lambda: simulate_ensemble(arm, law, Q0, STILL, time, dt=DT, payload=payload, every=10, threads=threads),
            setting,
            rounds=5,
        ) / (count * time)

    single, every = together(1), together(os.cpu_count() or 1)
    alone = seconds(lambda: simulate(arm, law, Q0, STILL, time, dt=DT, payload=payload[0], every=10), setting) / time
    python = seconds(lambda: _python_loop(arm, 0.01), setting, rounds=3) / 0.01
    pinocchio = _pinocchio_loop(arm, setting)
    rows = (
        ("ensemble, one thread", single, "one compiled simulation each", alone),
        ("ensemble, one thread", single, "a Python loop over our verbs", python),
        ("ensemble, one thread", single, "a Python loop over Pinocchio", pinocchio),
        (f"ensemble, {os.cpu_count()} threads", every, "one thread", single),
    )
    return [
        Figure(f"{what}: one arm, 1,000 steps of RK4", 1e6 * ours, "us", name, None if other is None else 1e6 * other)
        for what, ours, name, other in rows
    ]


def _runge_kutta(rate, time: float) -> None:
    y = np.concatenate([Q0, STILL])
    for _ in range(round(time / DT)):
        a = rate(y)
        b = rate(y + 0.5 * DT * a)
        c = rate(y + 0.5 * DT * b)
        y = y + DT / 6.0 * (a + 2.0 * b + 2.0 * c + rate(y + DT * c))


def _acceleration(y: np.ndarray) -> np.ndarray:
    return GAINS[0] * (GOAL - y[:6]) - GAINS[1] * y[6:]


def _python_loop(arm: Arm, time: float) -> None:
    inverse, forward = arm.inverse_dynamics, arm.forward_dynamics

    def rate(y: np.ndarray) -> np.ndarray:
        q, qd = y[:6], y[6:]
        return np.concatenate([qd, forward(q, qd, inverse(q, qd, _acceleration(y)))])

    _runge_kutta(rate, time)


def _pinocchio_loop(arm: Arm, setting: Setting) -> float | None:
    """Seconds per second of motion; Pinocchio's arm has no friction."""
    pin = peer("pinocchio")
    if pin is None:
        return None
    model = pinocchio_model(pin, arm)
    data = model.createData()

    def rate(y: np.ndarray) -> np.ndarray:
        q, qd = y[:6], y[6:]
        return np.concatenate([qd, pin.aba(model, data, q, qd, pin.rnea(model, data, q, qd, _acceleration(y)))])

    return seconds(lambda: _runge_kutta(rate, 0.01), setting, rounds=3) / 0.01
