"""PI forms in a compiled loop around a lag, beside the same formulas typed by hand into that loop."""

from __future__ import annotations

from typing import Any

import numpy as np

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.control.regulators import REGULATORS
from holonom.trace.code.loops import loop

SAMPLES = 100_000
DT, PART, LOW, HIGH = 1e-3, 0.01, -1.0, 1.0


def measure(setting: Setting) -> list[Figure]:
    """Closed loop of a lag that a noisy reference drives into the limits now and then."""
    r = 0.8 * np.sign(np.sin(np.arange(1000 if setting.small else SAMPLES) / 300.0)) + 0.1 * setting.rng.normal(
        size=1000 if setting.small else SAMPLES
    )
    figures = []
    for name, by_hand in (("conditional", _conditional), ("reset", _reset), ("foxboro", _foxboro)):
        regulator = REGULATORS.make(name, {"Kc": 10.0, "Ti": 1.0})
        params: Any = regulator.settings.params(DT)
        start = regulator.start(params, 0.0, 0.0, 0.0, LOW, HIGH)
        closed = _closed(regulator.step)
        np.testing.assert_allclose(closed(params, start, r), by_hand(params[0], params[1], r))
        ours, hand = [], []
        for _ in range(5):  # in turn, so that both see the same machine
            ours.append(seconds(lambda: closed(params, start, r), setting, rounds=9))  # noqa: B023
            hand.append(seconds(lambda: by_hand(params[0], params[1], r), setting, rounds=9))  # noqa: B023
        n = len(r)
        figures.append(
            Figure(f"regulator {name}, a sample", 1e9 * min(ours) / n, "ns", "typed by hand", 1e9 * min(hand) / n, 0.83)
        )
    return figures


def _closed(step: Any) -> Any:
    @loop
    def closed(params, state, r):
        y, outputs = 0.0, np.empty_like(r)
        for k in range(r.shape[0]):
            u, state = step(params, state, r[k], y, LOW, HIGH)
            y += PART * (u - y)
            outputs[k] = u
        return outputs

    return closed


@loop
def _conditional(gain: float, integral_gain: float, r: Any) -> Any:
    y, i, outputs = 0.0, 0.0, np.empty_like(r)
    for k in range(r.shape[0]):
        e = r[k] - y
        grown = i + integral_gain * e
        v = gain * e + grown
        u = min(max(v, LOW), HIGH)
        if (v - u) * e <= 0.0:
            i = grown
        y += PART * (u - y)
        outputs[k] = u
    return outputs


@loop
def _reset(gain: float, integral_gain: float, r: Any) -> Any:
    y, i, outputs = 0.0, 0.0, np.empty_like(r)
    for k in range(r.shape[0]):
        e = r[k] - y
        i += integral_gain * e
        v = gain * e + i
        u = min(max(v, LOW), HIGH)
        i += u - v
        y += PART * (u - y)
        outputs[k] = u
    return outputs


@loop
def _foxboro(gain: float, part: float, r: Any) -> Any:
    y, f, outputs = 0.0, 0.0, np.empty_like(r)
    for k in range(r.shape[0]):
        u = min(max(gain * (r[k] - y) + f, LOW), HIGH)
        f += part * (u - f)
        y += PART * (u - y)
        outputs[k] = u
    return outputs
