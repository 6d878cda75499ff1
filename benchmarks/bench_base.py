"""Inverse and forward model of mobile bases in batches, one thread, beside NumPy's product with the same matrix."""

from __future__ import annotations

import numpy as np

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.mobile.arrangements import ackermann, differential, mecanum, omni, swerve, synchro, tricycle
from holonom.mobile.base import WheelBase

SIZES = (4096, 65536)


def measure(setting: Setting) -> list[Figure]:
    return [f for rows in (SIZES[:1] if setting.small else SIZES) for f in _at(rows, setting)]


def _at(rows: int, setting: Setting) -> list[Figure]:
    figures = []
    for base in (differential(0.3, 0.05), omni(n=4, radius=0.2, wheel_radius=0.05), mecanum(0.4, 0.3, 0.05)):
        figures += _constant(base, rows, setting)
    swerving = swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05)
    for base in (ackermann(2.5, 1.5, 0.3), tricycle(1.2, 0.8, 0.15), synchro(0.25, 0.06), swerving):
        figures += _steered(base, rows, setting)
    return figures


def _twists(base: WheelBase, rows: int, setting: Setting) -> np.ndarray:
    return base.feasible(setting.rng.uniform(-1.0, 1.0, (rows, 3)))


def _constant(base: WheelBase, rows: int, setting: Setting) -> list[Figure]:
    twists, m = _twists(base, rows, setting), len(base.driven)
    speeds, back = np.empty((rows, m)), np.empty((rows, 3))
    B = base.wheel_speeds(np.eye(3), tolerance=np.inf)
    F = base.twist(np.eye(m))
    inverse = seconds(lambda: base.wheel_speeds(twists, out=speeds), setting) / rows
    forward = seconds(lambda: base.twist(speeds, out=back), setting) / rows
    np_inverse = seconds(lambda: np.matmul(twists, B, out=speeds), setting) / rows
    np_forward = seconds(lambda: np.matmul(speeds, F, out=back), setting) / rows
    what = f"{base.name} base, {rows} rows"
    return [
        Figure(f"inverse model, {what}", 1e9 * inverse, "ns", goal=20.0),
        Figure(f"inverse model, {what}", 1e9 * inverse, "ns", "NumPy @, unchecked", 1e9 * np_inverse),
        Figure(f"forward model, {what}", 1e9 * forward, "ns", goal=20.0),
        Figure(f"forward model, {what}", 1e9 * forward, "ns", "NumPy @, unchecked", 1e9 * np_forward),
    ]


def _steered(base: WheelBase, rows: int, setting: Setting) -> list[Figure]:
    twists = _twists(base, rows, setting)
    speeds, angles, back = np.empty((rows, len(base.driven))), np.empty((rows, len(base.steered))), np.empty((rows, 3))
    base.steering(twists, out=angles)
    turned, now = np.empty_like(angles), angles + 0.1
    verbs = {
        "steering angles": lambda: base.steering(twists, out=turned),
        "steering angles, nearest": lambda: base.steering(twists, now, out=turned),
        "inverse model": lambda: base.wheel_speeds(twists, out=speeds),
        "inverse model, steering given": lambda: base.wheel_speeds(twists, angles, out=speeds),
        "forward model": lambda: base.twist(speeds, angles, out=back),
    }
    what = f"{base.name} base, {rows} rows"
    return [
        Figure(f"{verb}, {what}", 1e9 * seconds(call, setting) / rows, "ns", goal=20.0) for verb, call in verbs.items()
    ]
