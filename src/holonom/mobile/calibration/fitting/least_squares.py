"""Calibration from any trajectory with ground truth, by nonlinear least squares over all runs together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError, OutOfLimits
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.calibration.clocks import truth_frame
from holonom.mobile.calibration.derived import known_parameters
from holonom.mobile.calibration.fitting.creep import creep_covariance
from holonom.mobile.calibration.fitting.data_sheet import informed
from holonom.mobile.calibration.fitting.limits import attainable, classical, largest_errors, within
from holonom.mobile.calibration.fitting.pieces import prepared, surest
from holonom.mobile.calibration.fitting.residuals import Problem, path_lever, solve
from holonom.mobile.calibration.fitting.uncertainty import check_excitation, noise_covariance, tightness
from holonom.mobile.calibration.identifiability import helpful_run
from holonom.mobile.calibration.parameters import Parameters, article, turned_frame, wheels_of
from holonom.mobile.calibration.runs import Motion, PathErrors, Run, dead_reckoning, need_truth, path_errors
from holonom.mobile.calibration.standard_runs import STANDARD_RUNS, base_of_drive

__all__ = ["Calibration", "calibrate", "held_out_errors"]


@dataclass(frozen=True, slots=True)
class Calibration:
    """Result of a calibration by least squares.

    Attributes
    ----------
    drive, set : what was calibrated: a drive, and "physical" or "extended" parameters.
    names : of the p parameters.
    nominal, values, deviations : (p,) before, after, and standard deviations by the runs alone; m and rad.
    covariance : (p, p) of the values, by the runs alone.
    singular_values : (p,) of the weighted Jacobian by the scaled parameters, largest first.
    motion : what `dead_reckoning` takes: motion matrix (3, f), features of a sample (see `Run.features`) to increments
        of the base; of a wheel set that steers a `Motion`.
    lever : m/rad, by which headings were weighted.
    before, after : errors of odometry along the runs.
    clocks : (runs,) s by which the truth's clock is behind that of the wheels; NaN where the motion does not tell it.
    limits : (4,) that the largest errors keep, distance and heading on the way and at the end, m and rad; infinite
        where free.
    growth : of the root mean square of the errors over that of least squares without limits, as a share.
    doubt : how many times wider than usual the tolerances of the data sheet came out (`fitting.data_sheet`); NaN where
        it was not asked.
    """

    drive: str
    set: str
    names: tuple[str, ...]
    nominal: Array
    values: Array
    deviations: Array
    covariance: Array
    singular_values: Array
    motion: Array | Motion
    lever: float
    before: PathErrors
    after: PathErrors
    clocks: Array
    limits: Array
    growth: float
    doubt: float

    @property
    def matrix(self) -> Array:
        """Motion matrix (3, f).

        Raises
        ------
        CalibrationError
            A wheel set that steers has none: `motion`.
        """
        if isinstance(self.motion, Motion):
            raise CalibrationError(f"a {self.drive} base steers and has no motion matrix; take its `motion`")
        return self.motion

    @property
    def condition(self) -> float:
        """Largest over smallest singular value."""
        return float(self.singular_values[0] / self.singular_values[-1])

    @property
    def correlation(self) -> Array:
        """(p, p) correlation of the values."""
        size = np.where(self.deviations > 0.0, self.deviations, 1.0)
        return self.covariance / np.outer(size, size)


def calibrate(
    runs: Sequence[Run],
    drive: str | WheelBase,
    nominal: Mapping[str, float] | None = None,
    *,
    set_name: str = "physical",
    rule: str = "midpoint",
    lever: float | None = None,
    final_weight: float = 1.0,
    limits: Sequence[float] | Literal["classical"] | None = None,
    data_sheet: bool = True,
) -> Calibration:
    """Calibrate a drive so that its odometry follows the truth.

    Minimises, over pieces of all runs, the mean square error of the pose along the piece plus `final_weight` squared
    times the square error at its end; headings count by `lever`. The derivatives go through the integration. Where each
    piece starts, and by how much the truth's clock is late there, is found with it; how long pieces are follows from
    how the base slips and how noisy the truth is. Nominal lengths count as measurements beside the runs, unless told
    otherwise (`fitting.data_sheet`). With `limits` of the largest errors, the pieces are whole runs, and where that
    breaks them, the smallest such sum that keeps them: no better estimate, but one within limits, by the runs alone.

    Parameters
    ----------
    runs : with the truth; any trajectories.
    drive : a key of `DRIVES`, or any wheel set, with parameters by its wheels (`derived_parameters`).
    nominal : physical parameters of a drive by name to start from, m and rad; a wheel set has its own.
    set_name : "physical", what a data sheet states, or "extended", every wheel's own direction and lever.
    rule : of integration.
    lever : m/rad; how far the truth goes from the start of a piece unless given.
    final_weight : of the end of a piece beside the way.
    limits : (4,) largest distance and heading on the way, and at the end, m and rad; "classical": for the extended set
        those of a classical calibration, physical parameters from the ends of the runs. None unless given. Below a
        millionth of the lever, and of a radian, they count as that.
    data_sheet : nominal lengths are known as well as data sheets usually are, or as badly as the runs show; False: only
        what the runs tell.

    Raises
    ------
    CalibrationError
        No runs, wheels that do not go with the drive, a motion that leaves parameters open: it names them; limits that
        no parameters keep.
    UnknownName, OutOfLimits, ShapeError

    Source: Gauss-Newton on the recursion, by Levenberg and Marquardt (`scipy.optimize.least_squares`); extended sets
    free the whole matrix of Lin, Liu & Kuo 2019 and Sousa, Petry, Costa & Moreira 2020.
    """
    parameters = known_parameters(drive, nominal, set_name)
    problem = Problem(_checked(runs, drive), parameters, rule, _lever(runs, lever), _weight(final_weight))
    base = drive if isinstance(drive, WheelBase) else base_of_drive(drive, nominal or {})

    def suggest(direction: Array) -> str:
        named = helpful_run(whole, base, direction)
        return "" if named is None else f"; {STANDARD_RUNS[named]} would tell it best"

    problem = replace(problem, tightness=tightness(problem.parts(np.zeros(len(parameters.names)))))
    whole = problem
    x = _solved(problem, suggest)
    problem = replace(problem, tightness=tightness(problem.parts(x)))
    x = solve(problem, x)
    problem = prepared(problem, x) if limits is not None else surest(problem, x, lever=lever)
    x = solve(problem, x)
    covariance = noise_covariance(problem.parts(x), None, problem.tightness) + creep_covariance(problem, x)
    values = check_excitation(problem.residuals(x)[1], parameters, _relative(problem, x, covariance), suggest)
    _check_reach(x, parameters)
    doubt = float("nan")
    if data_sheet and limits is None:
        x, doubt = informed(parameters, x, covariance)
    x, bounds, growth = _limited(problem, x, known_parameters(drive, nominal), limits)
    scale, sigma = parameters.scale, np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    motion = parameters.motion(problem.values(x))
    return Calibration(
        parameters.drive, set_name, parameters.names, parameters.nominal, problem.values(x),
        scale * sigma, covariance * np.outer(scale, scale), values, motion, problem.lever,
        _errors(runs, parameters.motion(parameters.nominal), rule), _errors(runs, motion, rule),
        np.array([part.clock for part in whole.parts(x)]), bounds, growth, doubt,
    )  # fmt: skip


def held_out_errors(
    runs: Sequence[Run], drive: str | WheelBase, nominal: Mapping[str, float] | None = None, *,
    set_name: str = "physical", rule: str = "midpoint", data_sheet: bool = True,
) -> PathErrors:  # fmt: skip
    """Errors of each run by a calibration from all the others: what a calibration is worth on a run it has not seen.

    Parameters as for `calibrate`.

    Raises
    ------
    CalibrationError
        Fewer than three runs, or others that do not tell the parameters.
    UnknownName, OutOfLimits, ShapeError
    """
    if len(runs) < 3:
        raise CalibrationError(f"{len(runs)} run(s) came; leaving one out needs three or more")
    paths = []
    for k, run in enumerate(runs):
        others = [*runs[:k], *runs[k + 1 :]]
        found = calibrate(others, drive, nominal, set_name=set_name, rule=rule, data_sheet=data_sheet)
        paths.append(dead_reckoning(run, found.motion, rule))
    return path_errors(runs, paths)


def _relative(problem: Problem, x: Array, covariance: Array) -> Array:
    """Covariance with lengths by what came out where that is less than their nominal value: 1/L runs away downwards."""
    drive = problem.drive
    found = np.where(drive.scale == drive.nominal, np.abs(problem.values(x)), drive.scale)
    stretch = np.maximum(drive.scale / np.maximum(found, 1e-12), 1.0)
    return covariance * np.outer(stretch, stretch)


def _solved(problem: Problem, suggest: Callable[[Array], str]) -> Array:
    """Solution from the nominal numbers, and the truth's frame turned as the directions of motion are."""
    drive = problem.drive
    check_excitation(problem.residuals(np.zeros(len(drive.names)))[1], drive, None, suggest)
    motion = drive.motion(drive.nominal)
    turns = np.array([truth_frame(run, motion)[2] for run in problem.runs])
    return solve(problem, turned_frame(drive, float(np.angle(np.exp(1j * turns).sum()))))


def _limited(
    problem: Problem, x: Array, physical: Parameters, limits: Sequence[float] | Literal["classical"] | None
) -> tuple[Array, Array, float]:
    """Parameters within limits, the limits, and how much the errors grew."""
    drive, free, told = problem.drive, np.full(4, np.inf), limits == "classical"
    if limits is None or (told and drive.set == "physical"):
        return x, free, 0.0
    if told:
        plain = replace(problem, drive=physical)
        bounds = largest_errors(plain, classical(plain))
    else:
        bounds = _four(limits)
    bounds = attainable(problem, bounds)
    kept = within(problem, x, bounds)
    if kept is None and not told:
        raise CalibrationError(_unkept(bounds, drive))
    if kept is None:
        return x, free, 0.0
    old, new = (float(np.linalg.norm(problem.residuals(at)[0])) for at in (x, kept))
    return kept, bounds, new / max(old, 1e-300) - 1.0


def _four(limits: object) -> Array:
    try:
        bounds = np.asarray(limits, dtype=np.float64)
    except (TypeError, ValueError):
        bounds = np.empty(0)
    if bounds.shape != (4,) or not np.all(bounds > 0.0):
        raise OutOfLimits(
            f"limits {limits} came; give four above zero: distance and heading on the way, and at the end, m and rad"
        )
    return bounds


def _unkept(bounds: Array, drive: Parameters) -> str:
    units = (
        (1.0, "m on the way"),
        (180.0 / np.pi, "degrees on the way"),
        (1.0, "m at the end"),
        (180.0 / np.pi, "degrees at the end"),
    )
    wanted = ", ".join(
        f"{bound * unit:.4g} {name}" for bound, (unit, name) in zip(bounds, units, strict=True) if np.isfinite(bound)
    )
    return (
        f"no {drive.set} parameters near the least squares keep all errors within {wanted}; give wider limits, or see "
        "what is left without"
    )


def _errors(runs: Sequence[Run], motion: Array | Motion, rule: str) -> PathErrors:
    return path_errors(runs, [dead_reckoning(run, motion, rule) for run in runs])


def _checked(runs: Sequence[Run], drive: str | WheelBase) -> tuple[Run, ...]:
    wheels, steered = (drive.driven, drive.steered) if isinstance(drive, WheelBase) else wheels_of(drive)
    name = drive.name if isinstance(drive, WheelBase) else drive
    if not runs:
        raise CalibrationError("no run came; give one or more")
    need_truth(runs)
    for run in runs:
        if run.turns.shape[1] != len(wheels) or run.steering.shape[1] != len(steered):
            raise CalibrationError(
                f"run {run.name} has {run.turns.shape[1]} wheels and {run.steering.shape[1]} steering angles; "
                f"{article(name)} has {len(wheels)} ({', '.join(wheels)}) and {len(steered)}"
            )
    return tuple(runs)


def _lever(runs: Sequence[Run], lever: float | None) -> float:
    if lever is None:
        lever = path_lever(runs)
    if not (np.isfinite(lever) and lever > 0.0):
        raise OutOfLimits(f"a lever of {lever} m came; give one above zero (runs that stay in place tell none)")
    return float(lever)


def _weight(final_weight: float) -> float:
    if not (np.isfinite(final_weight) and final_weight >= 0.0):
        raise OutOfLimits(f"a final weight of {final_weight} came; give zero or more")
    return float(final_weight)


def _check_reach(x: Array, parameters: Parameters) -> None:
    """A parameter that moved by as much as it is: the motion did not hold it, or the log is not of this robot."""
    free = [
        name.startswith(("frame_", "direction", "x_", "y_", "centre")) for name in parameters.names
    ]  # a marker may be anywhere
    far = (np.abs(x) > 0.9) & ~np.array(free)
    if far.any():
        named = ", ".join(name for name, away in zip(parameters.names, far, strict=True) if away)
        raise CalibrationError(
            f"least squares takes {named} away from the nominal value altogether; see that geometry, gear, encoder and "
            "columns are right, or record a motion with straight parts and turns to both sides"
        )
