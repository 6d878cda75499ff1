"""A law on a base along a course: how far beside it was, how long it took, what it cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holonom.closed_loop import simulate_base
from holonom.control import PATH_LAWS
from holonom.errors import MissingExtra, ModelError
from holonom.machine import BaseSettings, ReferencePath
from holonom.mobile import WheelBase
from holonom.mobile.base.drivable import moves_sideways
from holonom.mobile.drive.sized import sized_base_drive

__all__ = ["KEEPING", "Driven", "drive", "laws_for"]

KEEPING = "path keeping"
"""What the rows of bases that move sideways are called, which none of `PATH_LAWS` is for."""
SIZED = 2.0  # m/s and m/s^2 that the motors are sized for


@dataclass(frozen=True, slots=True)
class Driven:
    """A run.

    `rms` and `peak` (m) lie between where the base truly was and where it was to be then; `effort` (J) is drawn, less
    what braking gave back; `failed` says why there are none, "" where there are.
    """

    arrangement: str
    law: str
    course: str
    rms: float = 0.0
    peak: float = 0.0
    time: float = 0.0
    effort: float = 0.0
    failed: str = ""


def laws_for(base: WheelBase) -> tuple[str, ...]:
    """Names of the laws that are for a base."""
    return (KEEPING,) if moves_sideways(base) else tuple(PATH_LAWS)


def drive(base: WheelBase, arrangement: str, law: str, name: str, path: ReferencePath | None, seed: int) -> Driven:
    """Drive a course on a dry floor."""
    if path is None:
        return Driven(arrangement, law, name, failed="it cannot drive there")
    chosen = None if law == KEEPING else PATH_LAWS.make(law)
    try:
        log = simulate_base(
            base,
            sized_base_drive(base, SIZED, SIZED),
            path,
            settings=BaseSettings(law=chosen),
            rng=np.random.default_rng(seed),
        )
    except (ModelError, MissingExtra) as problem:
        return Driven(arrangement, law, name, failed=str(problem))
    error = log.path_error
    return Driven(
        arrangement, law, name, float(np.sqrt((error**2).mean())), float(error.max()), float(log.time[-1]),
        float(log.energy[-1, 0]), "" if log.ended == "done" else log.ended,
    )  # fmt: skip
