"""Which numbers the runs at hand tell, which only together with others, and which run would help."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from holonom.arrays import Array
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.calibration.derived import DerivedParameters, known_parameters
from holonom.mobile.calibration.fitting.noise import noise_of
from holonom.mobile.calibration.fitting.residuals import Problem, path_lever
from holonom.mobile.calibration.fitting.uncertainty import NAMED, UNSEEN, noise_covariance, tightness
from holonom.mobile.calibration.parameters import Parameters
from holonom.mobile.calibration.runs import Run, need_truth
from holonom.mobile.calibration.standard_runs import STANDARD_RUNS, base_of_drive, standard_run

__all__ = ["Combination", "Identifiability", "helpful_run", "identifiability"]


FAINT = 1e-3  # share of the best told combination below which one is weak
CLEAR = 0.8  # of the variance that is left: a longer run must leave less to be named before a simpler one
FEWEST = 0.9  # of the variance that a run must leave at most to be named at all
OFFERED = ("straight", "spins", "circles", "sideways", "squares", "eight")  # simple ones first


@dataclass(frozen=True, slots=True)
class Combination:
    """A direction of the parameters that runs tell little or nothing of.

    Attributes
    ----------
    shares : name -> part of the combination, by the parameters' scales; the largest is one.
    told : singular value over the largest; zero where the runs say nothing of it.
    run : a key of `STANDARD_RUNS` that would tell the most of it; None where the base can drive none that does.
    """

    shares: Mapping[str, float]
    told: float
    run: str | None

    def text(self) -> str:
        """In words."""
        named = ", ".join(f"{part:+.2g} {name}" for name, part in self.shares.items())
        how = "nothing" if self.told <= UNSEEN else "little"
        if self.run is None:
            return f"the runs tell {how} of {named}; no run of this base does"
        return f"the runs tell {how} of {named}; {STANDARD_RUNS[self.run]} would"


@dataclass(frozen=True, slots=True)
class Identifiability:
    """What runs tell of each parameter.

    Attributes
    ----------
    names : of the p parameters.
    deviations : (p,) standard deviations at the nominal numbers by the noise that the runs show, in the parameters' own
        units; infinite where open.
    weak : combinations that they tell little or nothing of, the worst first.
    gauge : numbers that no run of this base tells from others -> these.
    """

    names: tuple[str, ...]
    deviations: Array
    weak: tuple[Combination, ...]
    gauge: Mapping[str, tuple[str, ...]]


def identifiability(
    runs: Sequence[Run],
    drive: str | WheelBase,
    nominal: Mapping[str, float] | None = None,
    *,
    set_name: str = "physical",
    rule: str = "midpoint",
) -> Identifiability:
    """Return which parameters runs tell, by the singular values of the weighted, scaled Jacobian.

    Parameters
    ----------
    runs : with the truth.
    drive, nominal, set_name, rule : as for `calibrate`.

    Raises
    ------
    As `calibrate`, but for parameters that are open.
    """
    parameters = known_parameters(drive, nominal, set_name)
    need_truth(runs)
    problem = Problem(tuple(runs), parameters, rule, max(path_lever(runs), 1e-3), 1.0)
    at = np.zeros(len(parameters.names))
    problem = replace(problem, tightness=tightness(problem.parts(at)))
    J = problem.residuals(at)[1]
    _, s, Vt = np.linalg.svd(J, full_matrices=False)
    parts = problem.parts(at)
    covariance = noise_covariance(parts, noise_of(parts), problem.tightness)
    lost = (s <= UNSEEN * s[0]) @ (np.abs(Vt) > NAMED)
    deviations = np.where(lost, np.inf, parameters.scale * np.sqrt(np.maximum(np.diagonal(covariance), 0.0)))
    base = drive if isinstance(drive, WheelBase) else base_of_drive(drive, nominal or {})
    weak = [
        Combination(_shares(parameters, v), float(value / s[0]), helpful_run(problem, base, v))
        for value, v in zip(s[::-1], Vt[::-1], strict=True)
        if value <= FAINT * s[0]
    ]
    gauge = parameters.gauge if isinstance(parameters, DerivedParameters) else {}
    return Identifiability(parameters.names, deviations, tuple(weak), gauge)


def _shares(parameters: Parameters, v: Array) -> dict[str, float]:
    v = v / v[np.argmax(np.abs(v))]
    return {name: float(part) for name, part in zip(parameters.names, v, strict=True) if abs(part) > NAMED}


def helpful_run(problem: Problem, base: WheelBase, direction: Array) -> str | None:
    """Which of `STANDARD_RUNS` would tell the most of a combination, beside the runs at hand; None where none does.

    The variance along it, after such a run as sure as those at hand, is what counts: `v^T (H + H_run)^-1 v`.

    Parameters
    ----------
    problem : of the runs at hand.
    base : what drives.
    direction : (p,) unit vector of scaled parameters.
    """
    x = np.zeros(len(direction))
    J = problem.residuals(x)[1]
    H = J.T @ J
    size = float(np.trace(H)) or 1.0
    soft = 1e-12 * size * np.eye(len(x))
    best, least = None, FEWEST * float(direction @ np.linalg.solve(H + soft, direction)) / CLEAR
    for name in OFFERED:
        run = standard_run(base, name)
        if run is None:
            continue
        own = replace(problem, runs=(run,), sureness=None, lever=max(path_lever([run]), base.radius)).residuals(x)[1]
        seen = own.T @ own
        along = float(direction @ seen @ direction)
        if along <= (UNSEEN**2) * float(np.trace(seen)):
            continue
        left = float(direction @ np.linalg.solve(H + seen + soft, direction))
        if left < CLEAR * least:
            best, least = name, left
    return best
