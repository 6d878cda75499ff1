"""Derivatives of inverse and forward dynamics in batches, one thread; medians over the robots."""

from __future__ import annotations

import numpy as np
from peers import peer, pinocchio_model
from robots import medians

from holonom import Arm
from holonom.app.about.bench import Figure, Setting, seconds
from holonom.mechanics.dynamics import forward_dynamics_derivatives, inverse_dynamics_derivatives

SIZES = (4096, 65536)


def measure(setting: Setting) -> list[Figure]:
    return [f for rows in (SIZES[:1] if setting.small else SIZES) for f in _at(rows, setting)]


def _at(rows: int, setting: Setting) -> list[Figure]:
    inverse, rnea, forward, aba = medians(lambda arm: _times(arm, rows, setting))
    assert inverse is not None
    assert forward is not None
    what = "dynamics derivatives"
    return [
        Figure(f"inverse {what}, {rows} rows", inverse, "ns", "Pinocchio computeRNEADerivatives", rnea, goal=10.0),
        Figure(f"forward {what}, {rows} rows", forward, "ns", "Pinocchio computeABADerivatives", aba),
    ]


def _times(arm: Arm, rows: int, setting: Setting) -> list[float | None]:
    """Nanoseconds per sample: inverse dynamics' derivatives, Pinocchio's, forward dynamics', Pinocchio's."""
    q, qd, x = setting.rng.uniform(-3.0, 3.0, (3, rows, arm.n))
    shape = (rows, arm.n, arm.n)
    out = (np.empty(shape), np.empty(shape), np.empty(shape))
    inverse = seconds(lambda: inverse_dynamics_derivatives(arm, q, qd, x, out=out), setting) / rows
    forward = seconds(lambda: forward_dynamics_derivatives(arm, q, qd, x, out=out), setting) / rows
    some = (q[:4096], qd[:4096], x[:4096])
    rnea, aba = (_loop(arm, verb, some, setting) for verb in ("computeRNEADerivatives", "computeABADerivatives"))
    return [1e9 * inverse, rnea, 1e9 * forward, aba]


def _loop(arm: Arm, verb: str, motion, setting: Setting) -> float | None:
    """Nanoseconds per call of Pinocchio's verb in a loop over rows; its cost does not depend on how many there are."""
    pin = peer("pinocchio")
    if pin is None:
        return None
    model = pinocchio_model(pin, arm)
    data, derivatives = model.createData(), getattr(pin, verb)
    samples = list(zip(*motion, strict=True))

    def run() -> None:
        for sample in samples:
            derivatives(model, data, *sample)

    return 1e9 * seconds(run, setting, rounds=9) / len(samples)
