"""How errors of odometry grow on a base: by propagation and by simulated runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from holonom.mobile import WheelBase
from holonom.mobile.calibration import CAUSES, error_growth, standard_run

__all__ = ["RUNS", "Growth", "growths"]

RUNS = ("straight", "square", "spin")
"""10 m straight, a square of 2 m, a spin."""


@dataclass(frozen=True, slots=True)
class Growth:
    """Standard deviations at the end of a run: place (m) and heading (rad), propagated and simulated."""

    arrangement: str
    run: str
    cause: str
    place: float
    heading: float
    simulated_place: float
    simulated_heading: float


def growths(base: WheelBase, arrangement: str, *, runs: int, seed: int) -> Iterator[Growth]:
    """Yield a row for each run that a base can drive, and each cause."""
    for name in RUNS:
        run = standard_run(base, name)
        if run is None:
            continue
        for cause in CAUSES:
            told, seen = error_growth(base, run, cause, runs=runs, seed=seed)
            places = (float(np.hypot(*told[:2])), float(np.hypot(*seen[:2])))
            yield Growth(arrangement, name, cause, places[0], float(told[2]), places[1], float(seen[2]))
