"""Slip detection per sample and force envelopes per direction, beside NumPy's least squares and SciPy's programs."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.mobile.drive.coupling import Coupling, omni_coupling, rim_speeds
from holonom.mobile.drive.envelopes import effective_motors
from holonom.mobile.drive.slip import SlipSettings, slip_params
from holonom.mobile.drive.slip_kernels import slip_samples, slip_start

SAMPLES = 100_000
DIRECTIONS = 3600
LOOP = 64  # samples or directions of a peer that takes one at a time


def measure(setting: Setting) -> list[Figure]:
    figures = []
    for n in (4, 6):
        base = omni_coupling(np.deg2rad(np.array([33, 147, 225, 315, 90, 270])[:n]), radius=0.09, alpha=0.6)
        figures += [*_slip(base, setting), _envelope(base, setting)]
    return figures


def _slip(base: Coupling, setting: Setting) -> list[Figure]:
    """`slip_step` while nothing slips and while a wheel does; the peer fits all wheels, then leaves out each."""
    rows, n = 1000 if setting.small else SAMPLES, base.wheels
    quiet = rim_speeds(base, setting.rng.normal(size=(rows, 3))) + 0.02 * setting.rng.standard_normal((rows, n))
    loose = quiet + np.eye(n)[1]
    fit = seconds(lambda: [np.linalg.lstsq(base.velocity, row, rcond=None) for row in quiet[:LOOP]], setting) / LOOP

    def leave_one_out() -> None:
        for row in loose[:LOOP]:
            for i in range(n):
                np.linalg.lstsq(np.delete(base.velocity, i, 0), np.delete(row, i), rcond=None)

    each = seconds(leave_one_out, setting) / LOOP
    figures = []
    for name, m, peer in (("nothing slips", quiet, fit), ("a wheel slips", loose, fit + each)):
        ours = _steps(base, m, setting)
        what = f"slip detection, {n} wheels, {name}"
        figures.append(Figure(what, 1e9 * ours, "ns", "NumPy lstsq, loop", 1e9 * peer, goal=20.0))
    return figures


def _steps(base: Coupling, m: np.ndarray, setting: Setting) -> float:
    rows = len(m)
    params, rate, push = slip_params(base, SlipSettings()), np.zeros(rows), np.full((rows, 3), np.nan)
    status, wheels, twist = np.empty(rows, np.int64), np.empty((rows, 2), np.int64), np.empty((rows, 3))
    statistic = np.empty(rows)
    start = slip_start()
    return seconds(lambda: slip_samples(params, start, m, rate, push, status, wheels, twist, statistic), setting) / rows


def _envelope(base: Coupling, setting: Setting) -> Figure:
    phi = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS)
    ours = seconds(lambda: effective_motors(base, phi), setting) / DIRECTIONS
    n = base.wheels
    cost, bounds = np.append(np.zeros(n), -1.0), [(-1.0, 1.0)] * n + [(0.0, None)]

    def loop() -> None:
        for angle in phi[:LOOP]:
            A = np.column_stack([base.velocity.T, [-np.cos(angle), -np.sin(angle), 0.0]])
            linprog(cost, A_eq=A, b_eq=np.zeros(3), bounds=bounds)

    peer = seconds(loop, setting, rounds=5) / LOOP
    return Figure(f"effective motors, {n} wheels", 1e9 * ours, "ns", "SciPy linprog", 1e9 * peer, goal=100.0)
