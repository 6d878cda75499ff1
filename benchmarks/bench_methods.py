"""A row for every method of a kind, from its table: profiles, rules of odometry, headings along a path."""

from __future__ import annotations

import numpy as np

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.machine import PATHS, plan_path
from holonom.machine.base.paths import HEADINGS
from holonom.mechanics.motion import PROFILES, on_grid, time_law
from holonom.mobile.odometry import RULES, integrate


def measure(setting: Setting) -> list[Figure]:
    return [*_profiles(setting), *_rules(setting), *_headings(setting)]


def _profiles(setting: Setting) -> list[Figure]:
    def law(profile: str) -> object:
        return on_grid(time_law(1.0, 1.0, 2.0, profile=profile), 1e-3)

    times = {name: 1e6 * seconds(lambda name=name: law(name), setting, calls=20) for name in PROFILES}
    return [Figure(f"time law of 1.5 s at 1 kHz, {name}", time, "us") for name, time in times.items()]


def _rules(setting: Setting) -> list[Figure]:
    rows = 1_000 if setting.small else 100_000
    increments = 1e-3 * setting.rng.standard_normal((rows, 3))
    path = np.empty((rows, 3))
    times = {
        name: 1e3 * seconds(lambda name=name: integrate(increments, rule=name, out=path), setting) for name in RULES
    }
    return [Figure(f"odometry of {rows} increments, {name}", time, "ms") for name, time in times.items()]


def _headings(setting: Setting) -> list[Figure]:
    points = PATHS.make("circle", {"size": 2.0})
    times = {
        name: 1e3 * seconds(lambda name=name: plan_path(points, heading=name), setting, rounds=5) for name in HEADINGS
    }
    return [Figure(f"path of a base, heading {name}", time, "ms") for name, time in times.items()]
