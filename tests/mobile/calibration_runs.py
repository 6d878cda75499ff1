"""Runs of a base whose true numbers are known: features from a path, the truth by its own motion matrix, with noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from holonom.mobile.calibration import Run, drive_parameters, wheels_of
from holonom.mobile.odometry import integrate

NOMINAL = {
    "differential": {"wheelbase": 0.2, "diameter_left": 0.084, "diameter_right": 0.084},
    "tricycle": {"wheelbase": 0.15, "diameter": 0.065, "steering_offset": 0.0},
    "omni3": {"wheel_distance": 0.195, "diameter_wheel_1": 0.1, "diameter_wheel_2": 0.1, "diameter_wheel_3": 0.1},
    "mecanum": {
        "wheelbase_plus_track": 0.4,
        **dict.fromkeys(
            ["diameter_front_left", "diameter_front_right", "diameter_rear_left", "diameter_rear_right"], 0.06
        ),
    },
    **{
        f"omni{len(axes)}_any": {
            "wheel_distance": 0.08,
            **{f"diameter_wheel_{k + 1}": 0.054 for k in range(len(axes))},
            **{f"axis_wheel_{k + 1}": axis for k, axis in enumerate(axes)},
        }
        for axes in ([0.5, 2.0, 4.5], [1.0, 2.4, 3.9, 5.3], [0.1, 1.3, 2.6, 3.8, 5.1], [0.3, 1.2, 2.4, 3.5, 4.4, 5.6])
    },
}


def wandering(drive: str, truth: np.ndarray, set_name: str, *, seed: int, way: float = 1.0, noise: float = 0.0) -> Run:
    """A run that goes everywhere: wheels turn in slow waves; the base slips like a random walk of `noise`."""
    rng = np.random.default_rng(seed)
    parameters = drive_parameters(drive, NOMINAL[drive], set_name)
    wheels, steered = wheels_of(drive)
    time = 0.05 * np.arange(600)
    turns = np.full((600, len(wheels)), 0.08 * rng.choice([-1.0, 1.0]))
    for _ in range(4):
        turns += (
            0.15 * np.sin(rng.uniform(0.2, 1.5) * time + rng.uniform(0.0, 6.0))[:, None] * rng.normal(size=len(wheels))
        )
    if drive == "mecanum":  # rollers hold the wheels together: no pattern that pushes against itself
        idle = np.array([1.0, 1.0, -1.0, -1.0]) / 2.0
        turns -= np.outer(turns @ idle, idle)
    steering = 0.8 * np.sin(np.outer(time, np.full(len(steered), 0.4)) + rng.uniform(0.0, 6.0))
    turns *= way
    turns[0] = 0.0
    run = Run(f"run-{seed}", time, turns, np.empty((0, 3)), steering)
    increments = run.features @ parameters.matrix(truth).T
    slip = noise * rng.normal(size=(600, 3)) * np.sqrt(np.abs(turns).mean(1))[:, None]
    return Run(run.name, time, turns, integrate(increments + slip), steering)


def square(side: float, sense: int, truth: np.ndarray, *, name: str = "square") -> Run:
    """A square that a differential drive with nominal numbers believes to drive, as one with the true ones does it."""
    nominal = NOMINAL["differential"]
    straight = np.full((400, 2), side / 400 / (0.5 * nominal["diameter_left"]))
    corner = 0.25 * np.pi * nominal["wheelbase"] / (0.5 * nominal["diameter_left"]) / 200 * np.array([-sense, sense])
    turns = np.concatenate([[[0.0, 0.0]], *([straight, np.tile(corner, (200, 1))] * 4)])
    matrix = drive_parameters("differential", nominal).matrix(truth)
    return Run(name, 0.05 * np.arange(len(turns)), turns, integrate(turns @ matrix.T), np.empty((len(turns), 0)))


def values(nominal: Mapping[str, float]) -> np.ndarray:
    """Numbers of a dictionary, in its order."""
    return np.array(list(nominal.values()))
