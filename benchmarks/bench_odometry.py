"""Odometry of a million ticks, and calibrations of six runs, one thread."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path

import numpy as np

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.app.odometry_log import read_log
from holonom.mobile.calibration import Run, calibrate, drive_parameters, umbmark
from holonom.mobile.odometry import integrate

TICKS = 1_000_000
NOMINAL = {"wheelbase": 0.2, "diameter_left": 0.084, "diameter_right": 0.084}


def measure(setting: Setting) -> list[Figure]:
    rows = 20_000 if setting.small else TICKS
    ticks = setting.rng.integers(-3, 12, (rows, 2)).astype(np.float64)
    p = drive_parameters("differential", NOMINAL)
    M = p.matrix(p.nominal) * (2.0 * math.pi / 2796.8)
    path = np.empty((rows, 3))
    ours = 1e3 * seconds(lambda: integrate(ticks, matrix=M, out=path), setting)
    sums = 1e3 * seconds(lambda: _cumulative(ticks, M), setting)
    loop = 1e3 * _loop_seconds(ticks[: rows // 20], M) * 20
    exact = 1e3 * seconds(lambda: integrate(ticks, matrix=M, rule="exact", out=path), setting)
    what = f"odometry of {rows} ticks"
    return [
        Figure(what, ours, "ms", goal=50.0),
        Figure(what, ours, "ms", "NumPy, cumulative sums", sums),
        Figure(what, ours, "ms", "a loop in Python", loop, goal=10.0),
        Figure(f"{what}, exact arcs", exact, "ms", goal=50.0),
        *_calibrations(setting),
    ]


def _cumulative(ticks: np.ndarray, M: np.ndarray) -> np.ndarray:
    step = ticks @ M.T
    angle = np.cumsum(step[:, 2]) - 0.5 * step[:, 2]
    c, s = np.cos(angle), np.sin(angle)
    x = np.cumsum(c * step[:, 0] - s * step[:, 1])
    return np.stack([x, np.cumsum(s * step[:, 0] + c * step[:, 1]), np.cumsum(step[:, 2])], axis=1)


def _loop_seconds(ticks: np.ndarray, M: np.ndarray) -> float:
    rows, (a, b), (c, d) = ticks.tolist(), M[0].tolist(), M[2].tolist()
    begin = time.perf_counter()
    x = y = theta = 0.0
    path = []
    for left, right in rows:
        way, turn = a * left + b * right, c * left + d * right
        x += way * math.cos(theta + 0.5 * turn)
        y += way * math.sin(theta + 0.5 * turn)
        theta += turn
        path.append((x, y, theta))
    return time.perf_counter() - begin


def _calibrations(setting: Setting) -> list[Figure]:
    """Six squares of OptiOdom where they are, otherwise six made up."""
    folder = Path(os.environ.get("HOLONOM_DATA", "../shared/data")) / "odometry/optiodom/diff/square/230620202042"
    runs = read_log([folder]).runs if folder.is_dir() else tuple(_square(k, setting) for k in range(6))
    plain = seconds(lambda: calibrate(runs, "differential", NOMINAL), setting, rounds=5)
    wide = seconds(lambda: calibrate(runs, "differential", NOMINAL, set_name="extended"), setting, rounds=5)
    square = seconds(lambda: umbmark(runs, NOMINAL, 0.75), setting, rounds=5)
    return [
        Figure("calibration of six runs, least squares", plain, "s", goal=1.0),
        Figure("calibration of six runs, extended set", wide, "s", goal=1.0),
        Figure("calibration of six runs, UMBmark", square, "s", goal=1.0),
    ]


def _square(number: int, setting: Setting) -> Run:
    sense = 1.0 if number % 2 else -1.0
    straight = np.full((350, 2), 0.75 / 350 / 0.042)
    corner = np.tile(0.25 * np.pi * 0.2 / 0.042 / 100 * np.array([-sense, sense]), (100, 1))
    turns = np.concatenate([[[0.0, 0.0]], *([straight, corner] * 4)])
    M = drive_parameters("differential", NOMINAL).matrix(np.array([0.2008, 0.08404, 0.08396]))
    slip = 1e-4 * setting.rng.normal(size=(len(turns), 3))
    truth = integrate(turns @ M.T + slip)
    return Run(f"square {number + 1}", 0.05 * np.arange(len(turns)), turns, truth, np.empty((len(turns), 0)))
