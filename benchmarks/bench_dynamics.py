"""Inverse and forward dynamics in batches, from three separate (N, n) arrays; medians over the robots.

One thread beside the peer; then two threads beside one. The latter take the best of many rounds, for a core that is
busy with something else tells nothing about ours.
"""

from __future__ import annotations

import math
import time

import numpy as np
from peers import peer, pinocchio_model
from robots import medians

from holonom import Arm
from holonom.app.bench import Figure, Setting, seconds

SIZES = (4096, 65536)


def measure(setting: Setting) -> list[Figure]:
    sizes = SIZES[:1] if setting.small else SIZES
    return [f for rows in sizes for f in _at(rows, setting)] + [f for rows in sizes for f in _threads(rows, setting)]


def _at(rows: int, setting: Setting) -> list[Figure]:
    inverse, rnea, forward, aba = medians(lambda arm: _times(arm, rows, setting))
    assert inverse is not None
    assert forward is not None
    return [
        Figure(f"inverse dynamics, {rows} rows", inverse, "ns", "Pinocchio rneaInParallel(1)", rnea, goal=20.0),
        Figure(f"forward dynamics, {rows} rows", forward, "ns", "Pinocchio abaInParallel(1)", aba, goal=20.0),
    ]


def _threads(rows: int, setting: Setting) -> list[Figure]:
    numbers = medians(lambda arm: _best(arm, rows, setting))
    figures = []
    for k, verb in enumerate(("inverse dynamics", "forward dynamics")):
        one, two = numbers[2 * k : 2 * k + 2]
        assert two is not None
        figures.append(Figure(f"{verb}, {rows} rows, two threads", two, "ns", "one thread", one, goal=1.8))
    return figures


def _best(arm: Arm, rows: int, setting: Setting) -> list[float]:
    """Nanoseconds per sample with one thread and with two, each verb; rounds of both alternate."""
    q, qd, x = setting.rng.uniform(-3.0, 3.0, (3, rows, arm.n))
    out, times = np.empty((rows, arm.n)), []
    rounds = 2 if setting.small else max(40, 2_000_000 // rows)
    for verb in (arm.inverse_dynamics, arm.forward_dynamics):
        least = {1: math.inf, 2: math.inf}
        for _ in range(rounds):
            for threads in least:
                begin = time.perf_counter()
                verb(q, qd, x, out=out, threads=threads)
                least[threads] = min(least[threads], time.perf_counter() - begin)
        times += [1e9 * least[1] / rows, 1e9 * least[2] / rows]
    return times


def _times(arm: Arm, rows: int, setting: Setting) -> list[float | None]:
    """Nanoseconds per sample: inverse dynamics, Pinocchio's, forward dynamics, Pinocchio's."""
    motion = setting.rng.uniform(-3.0, 3.0, (3, rows, arm.n))
    q, qd, x = motion
    out, pin = np.empty((rows, arm.n)), peer("pinocchio")
    inverse = seconds(lambda: arm.inverse_dynamics(q, qd, x, out=out), setting) / rows
    rnea = _pinocchio(pin, arm, "rneaInParallel", motion, setting)
    forward = seconds(lambda: arm.forward_dynamics(q, qd, x, out=out), setting) / rows
    return [1e9 * inverse, rnea, 1e9 * forward, _pinocchio(pin, arm, "abaInParallel", motion, setting)]


def _pinocchio(pin, arm, verb: str, rows, setting: Setting) -> float | None:
    """Nanoseconds per sample of Pinocchio's batch verb with one thread; its columns are our rows."""
    if pin is None:
        return None
    pool = pin.ModelPool(pinocchio_model(pin, arm), 1)
    columns = [np.asfortranarray(a.T) for a in rows]
    out = np.zeros_like(columns[0], order="F")
    return 1e9 * seconds(lambda: getattr(pin, verb)(1, pool, *columns, out), setting) / columns[0].shape[1]
