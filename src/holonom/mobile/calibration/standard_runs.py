"""Runs that a base can be asked to drive: twists, and what its wheels would count; for advice and for error growth."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError
from holonom.mobile import arrangements
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.calibration.runs import Run
from holonom.mobile.odometry import integrate

__all__ = ["STANDARD_RUNS", "base_of_drive", "standard_run"]


SPEED, PERIOD = 0.5, 0.05  # m/s of base and rims, s between samples
STRAIGHT, SIDE = 10.0, 2.0  # m
TURNS = 2.0  # full turns of a spin
ALIKE = 1e-9  # m/s by which a twist may miss what the base can do

STANDARD_RUNS: Mapping[str, str] = MappingProxyType(
    {
        "straight": "10 m straight on",
        "circles": "a tight circle to the left and one to the right",
        "spins": "two turns on the spot to the left and two to the right",
        "squares": "a square of 2 m to the left and one to the right",
        "sideways": "10 m sideways",
        "eight": "a figure of eight",
        "square": "a square of 2 m to the left",
        "spin": "two turns on the spot",
    }
)
"""Name -> what it is."""


def standard_run(base: WheelBase, name: str) -> Run | None:
    """Return a run of a base as it should be, with the truth that its wheels say; None where it cannot drive so.

    Parameters
    ----------
    name : a key of `STANDARD_RUNS`.

    Notes
    -----
    A base that cannot turn on the spot takes the corners of a square on its tightest arc, but none below 0.3 m.
    """
    twists = _twists(base, name)
    if twists is not None and name != "sideways":
        about = base.feasible([0.0, 0.0, 1.0])  # wheels may turn about a place that base_link swings round
        twists[:, 1] += twists[:, 2] * (about[1] / about[2] if about[2] > ALIKE else 0.0)
    if twists is None or np.abs(base.feasible(twists) - twists).max() > ALIKE:
        return None
    steering = base.steering(twists, np.zeros((len(twists), len(base.steered))))
    turns = PERIOD * base.wheel_speeds(twists, steering)
    turns[0] = 0.0
    moved = PERIOD * twists
    moved[0] = 0.0
    return Run(name, PERIOD * np.arange(len(twists), dtype=np.float64), turns, integrate(moved, rule="exact"), steering)


def _twists(base: WheelBase, name: str) -> Array | None:
    """(N, 3), the first of them before the run."""
    tightest = base.turning_radius
    if not np.isfinite(tightest) and name not in ("straight", "sideways"):
        return None
    corner = 0.0 if tightest < ALIKE or not np.isfinite(tightest) else max(1.2 * tightest, 0.3)
    round_ = max(2.0 * base.radius, 1.5 * corner)
    left = {
        "straight": [_line(STRAIGHT)],
        "sideways": [_line(STRAIGHT, sideways=True)],
        "spin": [_arc(base, 0.0, 2.0 * np.pi * TURNS)],
        "circle": [_arc(base, round_, 4.0 * np.pi)],
        "square": [_line(SIDE), _arc(base, corner, 0.5 * np.pi)] * 4,
    }
    if name == "spin" and corner > 0.0:
        return None
    if name == "eight":
        parts = [*left["circle"], *(_mirrored(part) for part in left["circle"])]
    elif name in ("circles", "spins", "squares"):
        one = left[name[:-1]]
        parts = [*one, *(_mirrored(part) for part in one)]
        if name == "spins" and corner > 0.0:
            return None
    else:
        parts = left[name]
    return np.concatenate([parts[0][:1], *parts])


def _line(way: float, *, sideways: bool = False) -> Array:
    count = round(way / (SPEED * PERIOD))
    return np.tile([0.0, way, 0.0] if sideways else [way, 0.0, 0.0], (count, 1)) / (count * PERIOD)


def _arc(base: WheelBase, radius: float, angle: float) -> Array:
    """A turn to the left; on the spot at the speed of the rims."""
    way = angle * (radius or base.radius)
    count = max(8, round(way / (SPEED * PERIOD)))
    return np.tile([radius * angle, 0.0, angle], (count, 1)) / (count * PERIOD)


def _mirrored(part: Array) -> Array:
    return part * [1.0, -1.0, -1.0]


def base_of_drive(drive: str, nominal: Mapping[str, float]) -> WheelBase:
    """Return the wheel set of a drive that is calibrated by name, by its nominal numbers.

    Raises
    ------
    CalibrationError
        Another drive.
    """
    sizes = [0.5 * value for name, value in nominal.items() if name.startswith("diameter")]
    if drive == "differential":
        return arrangements.differential(nominal["wheelbase"], sizes)
    if drive == "tricycle":
        return arrangements.tricycle(nominal["wheelbase"], nominal["wheelbase"], sizes[0])
    if drive == "mecanum":
        half = 0.5 * nominal["wheelbase_plus_track"]
        return arrangements.mecanum(half, half, float(np.mean(sizes)))
    if drive.startswith("omni"):
        axes = [value for name, value in nominal.items() if name.startswith("axis")]
        angles = axes or [-np.pi / 3.0, np.pi / 3.0, np.pi]
        return arrangements.omni(angles, radius=nominal["wheel_distance"], wheel_radius=float(np.mean(sizes)))
    raise CalibrationError(f"{drive} is no drive that is calibrated by name; give its wheel set")
