"""Inverse and forward dynamics in batches, one thread, from three separate (N, n) arrays; medians over the robots."""

from __future__ import annotations

import numpy as np
from peers import peer, pinocchio_model
from robots import medians

from holonom import Arm
from holonom.app.bench import Figure, Setting, seconds

SIZES = (4096, 65536)


def measure(setting: Setting) -> list[Figure]:
    return [f for rows in (SIZES[:1] if setting.small else SIZES) for f in _at(rows, setting)]


def _at(rows: int, setting: Setting) -> list[Figure]:
    inverse, rnea, forward, aba = medians(lambda arm: _times(arm, rows, setting))
    assert inverse is not None
    assert forward is not None
    return [
        Figure(f"inverse dynamics, {rows} rows", inverse, "ns", "Pinocchio rneaInParallel(1)", rnea, goal=20.0),
        Figure(f"forward dynamics, {rows} rows", forward, "ns", "Pinocchio abaInParallel(1)", aba, goal=20.0),
    ]


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
