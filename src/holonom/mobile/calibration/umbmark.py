"""UMBmark: wheelbase and unequal diameters of a differential drive from squares driven both ways round."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError, OutOfLimits, UnknownName
from holonom.mobile.calibration.parameters import drive_parameters
from holonom.mobile.calibration.runs import PathErrors, Run, dead_reckoning, need_truth, path_errors

__all__ = ["FORMS", "UMBmark", "umbmark"]


FORMS = {"x": (1.0, 0.0), "y": (0.0, 1.0), "mean": (0.5, 0.5)}
"""Forms of the method: the weights of the angles by the errors along x and along y."""
FEW = 5  # runs each way that Borenstein & Feng ask for


@dataclass(frozen=True, slots=True)
class UMBmark:
    """Result of UMBmark.

    Attributes
    ----------
    side : of the square, m.
    clockwise, counterclockwise : (2,) mean of truth minus odometry at the end of the runs each way, m.
    spread : (2, 2) their standard deviations (a row each), NaN with one run.
    alpha : error of each corner by the wheelbase (type A), rad; as used, by the form.
    beta : turn on each side by unequal diameters (type B), rad.
    E_b, E_d : true over nominal wheelbase; right over left diameter.
    nominal, calibrated : wheelbase, diameter_left, diameter_right, m.
    deviations : standard deviations of the calibrated ones and of E_b, E_d by the spread of the runs; NaN with one run.
    E_max : Borenstein's measure of systematic error, the larger distance of the two means, m, before and after.
    before, after : errors of odometry along the runs.
    notes : what weakens the result.
    """

    side: float
    clockwise: Array
    counterclockwise: Array
    spread: Array
    alpha: float
    beta: float
    E_b: float
    E_d: float
    nominal: Mapping[str, float]
    calibrated: Mapping[str, float]
    deviations: Mapping[str, float]
    E_max: tuple[float, float]
    before: PathErrors
    after: PathErrors
    notes: tuple[str, ...]


def umbmark(
    runs: Sequence[Run], nominal: Mapping[str, float], side: float, *, form: str = "x", rule: str = "midpoint"
) -> UMBmark:
    """Calibrate a differential drive by squares driven clockwise and counter-clockwise.

    With the mean end errors `(x, y)` of each way, of a square that starts along x,

        alpha = (x_cw + x_ccw)/(-4 L),  beta = (x_cw - x_ccw)/(-4 L)      form "x"
        alpha = (y_cw - y_ccw)/(-4 L),  beta = (y_cw + y_ccw)/(-4 L)      form "y"
        E_b = (pi/2)/(pi/2 - alpha),    R = (L/2)/sin(beta/2),  E_d = (R + b/2)/(R - b/2)

    with the corrected wheelbase b; diameters keep their mean.

    Parameters
    ----------
    runs : squares, at least one each way.
    nominal : wheelbase, diameter_left, diameter_right, m; equal diameters.
    side : L, m.
    form : "x" (Borenstein's and the usual one), "y", or "mean" of the two.
    rule : of integration.

    Raises
    ------
    CalibrationError
        Runs one way only, a run that is no square, or diameters that are not equal to begin with.
    UnknownName, OutOfLimits

    Source: Borenstein & Feng, IEEE Trans. Robotics and Automation 12(6), 1996, equations 3, 8 to 13 and 18.
    """
    if form not in FORMS:
        raise UnknownName("form of UMBmark", form, FORMS)
    if not (np.isfinite(side) and side > 0.0):
        raise OutOfLimits(f"a square of side {side} m came; give a length above zero")
    drive = drive_parameters("differential", nominal)
    if abs(drive.nominal[1] - drive.nominal[2]) > 1e-9 * drive.nominal[1]:
        raise CalibrationError("UMBmark starts from equal diameters; give their mean as both")
    if not runs:
        raise CalibrationError(f"no run came; UMBmark needs squares both ways round, {FEW} each way are usual")
    need_truth(runs)
    ways = _ways(runs, side)
    paths = [dead_reckoning(run, drive.matrix(drive.nominal), rule) for run in runs]
    ends = np.stack([run.truth[-1, :2] - path[-1, :2] for run, path in zip(runs, paths, strict=True)])
    ends = _in_square(runs, ends)
    means = np.stack([ends[ways < 0].mean(0), ends[ways > 0].mean(0)])
    alpha, beta = _angles(means, side, form)
    result = _corrected(means, side, form, drive.nominal)
    after = [dead_reckoning(run, drive.matrix(result[:3]), rule) for run in runs]
    late = _in_square(runs, np.stack([run.truth[-1, :2] - path[-1, :2] for run, path in zip(runs, after, strict=True)]))
    spread = _spread(ends, ways)
    names = (*drive.names, "E_b", "E_d")
    deviations = dict(zip(names, _deviations(means, spread, ways, side, form, drive.nominal).tolist(), strict=True))
    return UMBmark(
        side, means[0], means[1], spread, alpha, beta, float(result[3]), float(result[4]),
        dict(zip(drive.names, drive.nominal.tolist(), strict=True)),
        dict(zip(drive.names, result[:3].tolist(), strict=True)), deviations,
        (_systematic(ends, ways), _systematic(late, ways)),
        path_errors(runs, paths), path_errors(runs, after), _notes(ways),
    )  # fmt: skip


def _ways(runs: Sequence[Run], side: float) -> Array:
    """+1 for each run that turned to the left altogether, -1 to the right."""
    turns = np.array([run.heading[-1] - run.heading[0] for run in runs])
    for run, turn in zip(runs, turns, strict=True):
        gap = float(np.hypot(*(run.truth[-1, :2] - run.truth[0, :2])))
        if abs(abs(turn) - 2.0 * np.pi) > 0.5 * np.pi or gap > 0.5 * side:
            raise CalibrationError(
                f"run {run.name} turned by {abs(np.degrees(turn)):.0f} degrees and ended {gap:.3g} m from its start: "
                f"UMBmark needs closed squares of side {side:g} m, turning by 360 degrees; leave it out, or use "
                "least squares"
            )
    ways = np.sign(turns)
    for sign, name, other in ((-1, "clockwise", "counter-clockwise"), (1, "counter-clockwise", "clockwise")):
        if not np.any(ways == sign):
            raise CalibrationError(
                f"{len(ways)} run(s), all {other}: UMBmark needs squares both ways round to tell the wheelbase from "
                f"unequal diameters; drive some {name}, {FEW} are usual"
            )
    return np.asarray(ways)


def _in_square(runs: Sequence[Run], ends: Array) -> Array:
    """End errors (n, 2) turned so that each run's first heading is x."""
    angle = np.array([run.heading[0] for run in runs])
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * ends[:, 0] + s * ends[:, 1], -s * ends[:, 0] + c * ends[:, 1]], axis=1)


def _angles(means: Array, side: float, form: str) -> tuple[float, float]:
    (x_cw, y_cw), (x_ccw, y_ccw) = means
    by_x = np.array([x_cw + x_ccw, x_cw - x_ccw]) / (-4.0 * side)
    by_y = np.array([y_cw - y_ccw, y_cw + y_ccw]) / (-4.0 * side)
    of_x, of_y = FORMS[form]
    alpha, beta = of_x * by_x + of_y * by_y
    return float(alpha), float(beta)


def _corrected(means: Array, side: float, form: str, nominal: Array) -> Array:
    """(5,) wheelbase, left and right diameter, E_b, E_d."""
    alpha, beta = _angles(means, side, form)
    if not (abs(alpha) < 0.25 * np.pi and abs(beta) < 0.25 * np.pi):
        raise CalibrationError(
            f"end errors ask for corners {np.degrees(alpha):.0f} and sides {np.degrees(beta):.0f} degrees off: too "
            "much for UMBmark; see that columns, geometry and the side of the square are right, or use least squares"
        )
    E_b = 0.5 * np.pi / (0.5 * np.pi - alpha)
    b = E_b * nominal[0]
    bend = 2.0 * np.sin(0.5 * beta) / side  # 1/R: zero where the diameters are equal
    E_d = (1.0 + 0.5 * b * bend) / (1.0 - 0.5 * b * bend)
    D = 0.5 * (nominal[1] + nominal[2])
    return np.array([b, 2.0 * D / (E_d + 1.0), 2.0 * D / (1.0 / E_d + 1.0), E_b, E_d])


def _spread(ends: Array, ways: Array) -> Array:
    rows = [ends[ways == sign] for sign in (-1, 1)]
    return np.stack([row.std(0, ddof=1) if len(row) > 1 else np.full(2, np.nan) for row in rows])


def _deviations(means: Array, spread: Array, ways: Array, side: float, form: str, nominal: Array) -> Array:
    """To first order, by differences; the scatter of each mean is that of its runs."""
    of_mean = spread / np.sqrt([[np.sum(ways < 0)], [np.sum(ways > 0)]])
    total, h = np.zeros(5), 1e-6 * side
    for at in np.ndindex(2, 2):
        step = np.zeros((2, 2))
        step[at] = h
        slope = (_corrected(means + step, side, form, nominal) - _corrected(means - step, side, form, nominal)) / (
            2 * h
        )
        total += np.where(slope == 0.0, 0.0, (slope * of_mean[at]) ** 2)
    return np.sqrt(total)


def _systematic(ends: Array, ways: Array) -> float:
    """Return `E_max,syst`, the larger distance of the two centres of gravity (Borenstein & Feng, equation 3)."""
    return max(float(np.hypot(*ends[ways == sign].mean(0))) for sign in (-1, 1))


def _notes(ways: Array) -> tuple[str, ...]:
    cw, ccw = int(np.sum(ways < 0)), int(np.sum(ways > 0))
    if min(cw, ccw) >= FEW:
        return ()
    text = f"{cw} clockwise, {ccw} counter-clockwise; {FEW} each way are usual, fewer leave chance in the means"
    return (f"squares: {text}",)
