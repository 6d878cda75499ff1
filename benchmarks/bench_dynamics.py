"""Inverse and forward dynamics of a six-joint arm in batches, one thread, from three separate (N, 6) arrays."""

from __future__ import annotations

import numpy as np
from peers import peer, pinocchio_model

from holonom import load_arm
from holonom.app.bench import Figure, Setting, seconds

SIZES = (4096, 65536)


def measure(setting: Setting) -> list[Figure]:
    return [f for rows in (SIZES[:1] if setting.small else SIZES) for f in _at(rows, setting)]


def _at(rows: int, setting: Setting) -> list[Figure]:
    arm, pin = load_arm("puma560"), peer("pinocchio")
    motion = setting.rng.uniform(-3.0, 3.0, (3, rows, 6))
    q, qd, x = motion
    out = np.empty((rows, 6))
    inverse = seconds(lambda: arm.inverse_dynamics(q, qd, x, out=out), setting) / rows
    forward = seconds(lambda: arm.forward_dynamics(q, qd, x, out=out), setting) / rows
    figures = []
    for name, ours, theirs in (("inverse", inverse, "rneaInParallel"), ("forward", forward, "abaInParallel")):
        reference = _pinocchio(pin, arm, theirs, motion, setting)
        what = f"{name} dynamics, {rows} rows"
        figures.append(Figure(what, 1e9 * ours, "ns", f"Pinocchio {theirs}", reference, goal=20.0))
    return figures


def _pinocchio(pin, arm, verb: str, rows, setting: Setting) -> float | None:
    """Nanoseconds per sample of Pinocchio's batch verb with one thread; its columns are our rows."""
    if pin is None:
        return None
    pool = pin.ModelPool(pinocchio_model(pin, arm), 1)
    columns = [np.asfortranarray(a.T) for a in rows]
    out = np.zeros_like(columns[0], order="F")
    return 1e9 * seconds(lambda: getattr(pin, verb)(1, pool, *columns, out), setting) / columns[0].shape[1]
