"""Checks of a log that need to know what a base can do: time, speeds, and whether wheels and truth tell one story."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from holonom.app.odometry_log.table import Table
from holonom.errors import LogError
from holonom.mobile.calibration import DriveParameters, Run, dead_reckoning
from holonom.mobile.odometry import find_gaps

__all__ = ["check_motion", "check_time"]

Array = NDArray[np.float64]

FASTEST = 20.0  # m/s, of a rim or the truth: 72 km/h
WILDEST = 30.0  # rad/s of the truth
FACTOR = 4.0  # by which way and turn of odometry and truth may differ before a unit is wrong
REACH, TURN = 0.05, 0.5  # m and rad that a run must cover before ways and turns are compared
WINDOW = 0.5  # s over which the order of the wheels is compared
ASTRAY = 0.1  # share of the motion by which wheels must miss the truth before another order is looked for
CLEARER = 0.5  # another order must miss the truth by less than this share

LENGTHS = {1000.0: "mm instead of m", 100.0: "cm instead of m"}
ANGLES = {180.0 / np.pi: "degrees instead of rad"}


def check_time(table: Table, *, allow_gaps: bool, factor: float = 2.5) -> tuple[str, ...]:
    """Refuse time that stands still or goes back, and gaps; notes on gaps that are allowed.

    A step above `factor` times the median one is a gap.

    Raises
    ------
    LogError
    """
    time = table.column("time")
    steps = np.diff(time)
    if np.any(steps <= 0.0):
        row = int(np.argmax(steps <= 0.0)) + 1
        table.fault(
            row, "time", f"{time[row]:g} s after {time[row - 1]:g} s; time must grow: sort the log or cut it there"
        )
    gaps = np.flatnonzero(find_gaps(time, factor))
    if not len(gaps):
        return ()
    first, longest = int(gaps[0]), float(np.max(steps))
    text = f"{len(gaps)} gap(s) up to {longest:g} s, samples come every {np.median(steps):g} s"
    if not allow_gaps:
        table.fault(
            first,
            "time",
            f"{text}: wheels went on unseen; cut the run at the gap, or allow gaps if the counters went on",
        )
    return (f"{table.path}:{table.lines[first]}: {text}; allowed",)


def check_motion(table: Table, run: Run, parameters: DriveParameters, wheels: Sequence[str]) -> None:
    """Refuse speeds that cannot be, wrong units and swapped columns.

    Parameters
    ----------
    table : the run as it was read, for messages.
    run : the same in SI units.
    parameters : the base's nominal ones.
    wheels : names of the columns of the run's wheels.

    Raises
    ------
    LogError
    """
    M = parameters.matrix(parameters.nominal)
    _check_steering(table, run)
    diameters = [v for n, v in zip(parameters.names, parameters.nominal, strict=True) if n.startswith("diameter")]
    _check_rims(table, run, wheels, 0.5 * max(diameters))
    if len(run.truth):
        _check_truth(table, run)
        _check_order(table, run, M, wheels)
        _check_story(table, run, M)


def _check_steering(table: Table, run: Run) -> None:
    if run.steering.size == 0 or np.abs(run.steering).max() <= np.pi:
        return
    row = int(np.argmax(np.abs(run.steering).max(axis=1)))
    raw = table.column("steering")
    wheel = "front" if "front" in table.names else table.names[-2]
    if np.all(raw == np.round(raw)) and np.abs(table.column(wheel)).max() <= np.pi:
        table.fault(row, "steering", f"{raw[row]:g} came, whole numbers beside a wheel column within half a turn: "
                                     f"columns {wheel} and steering are swapped; swap them")  # fmt: skip
    table.fault(row, "steering", f"{run.steering[row, 0]:.4g} rad came; -pi to pi is allowed: degrees instead of rad?")


def _check_rims(table: Table, run: Run, wheels: Sequence[str], radius: float) -> None:
    dt = np.diff(run.time)
    speed = np.abs(run.turns[1:]) * radius / dt[:, None]
    if speed.max() <= FASTEST:
        return
    row, wheel = np.unravel_index(int(np.argmax(speed)), speed.shape)
    table.fault(
        int(row) + 1, wheels[int(wheel)],
        f"the wheel's rim runs at {speed.max():.4g} m/s; up to {FASTEST:g} are plausible: see the unit of the column "
        "(ticks of a sample, running counts, rad), encoder, gear, and that the diameter is in m, not mm",
    )  # fmt: skip


def _check_truth(table: Table, run: Run) -> None:
    dt = np.diff(run.time)
    step = np.diff(run.truth[:, :2], axis=0)
    speed = np.hypot(step[:, 0], step[:, 1]) / dt
    if speed.max() > FASTEST:
        row = int(np.argmax(speed))
        column = "x" if abs(step[row, 0]) >= abs(step[row, 1]) else "y"
        table.fault(row + 1, column, f"the truth moves at {speed.max():.4g} m/s; up to {FASTEST:g} are plausible: "
                                     "mm instead of m, or a jump of the tracker?")  # fmt: skip
    rate = np.abs(np.diff(run.heading)) / dt
    if rate.max() > WILDEST:
        row = int(np.argmax(rate))
        table.fault(row + 1, "theta", f"the truth turns at {rate.max():.4g} rad/s; up to {WILDEST:g} are plausible: "
                                      "degrees instead of rad, or a jump of the tracker?")  # fmt: skip


def _check_order(table: Table, run: Run, M: Array, wheels: Sequence[str]) -> None:
    """Wheel columns in another order that explain the truth much better."""
    if len(wheels) < 2:
        return
    seen, features = _windows(run)
    lever = float(np.median(np.abs(M[:2]).max() / np.abs(M[2])))  # so that turns weigh as the ways that make them
    size = np.array([1.0, 1.0, lever])
    moved = np.sqrt(np.mean((seen * size) ** 2))
    orders = [list(order) for order in itertools.permutations(range(len(wheels)))]
    misses = [np.sqrt(np.mean(((features[:, order] @ M.T - seen) * size) ** 2)) for order in orders]
    best = int(np.argmin(misses))
    if misses[0] > ASTRAY * moved and misses[best] < CLEARER * misses[0]:
        names = ", ".join(wheels[k] for k in orders[best])
        wrong = [wheels[k] for k, at in enumerate(orders[best]) if at != k]
        table.fault(1, wrong[0], f"columns {', '.join(wrong)} are swapped: read in the order {names} they follow the "
                                 "truth, as they are they do not; name or order them so")  # fmt: skip


def _windows(run: Run) -> tuple[Array, Array]:
    """Increments of the truth in its own frame over windows of time, and sums of features: (K, 3), (K, f)."""
    stride = max(1, round(WINDOW / float(np.median(np.diff(run.time)))))
    at = np.arange(0, len(run.time), stride)
    total = np.cumsum(run.features, axis=0)[at]
    step, turn = np.diff(run.truth[at, :2], axis=0), np.diff(run.heading[at])
    middle = run.heading[at][:-1] + 0.5 * turn
    c, s = np.cos(middle), np.sin(middle)
    seen = np.stack([c * step[:, 0] + s * step[:, 1], -s * step[:, 0] + c * step[:, 1], turn], axis=1)
    return seen, np.diff(total, axis=0)


def _check_story(table: Table, run: Run, M: Array) -> None:
    """How far, and how much, odometry and truth moved."""
    path = dead_reckoning(run, M)
    far, seen = (float(np.max(np.hypot(*(p[:, :2] - p[0, :2]).T))) for p in (path, run.truth))
    if max(far, seen) > REACH and not 1.0 / FACTOR < (far + 1e-12) / (seen + 1e-12) < FACTOR:
        raise LogError(
            f"{table.path}: by its wheels the base gets {far:.4g} m from its start, by the truth {seen:.4g} m: "
            f"{_guess(seen, far, 'truth', 'geometry or wheels', LENGTHS)}"
        )
    turned, heading = path[:, 2] - path[:, 2].mean(), run.heading - run.heading.mean()
    if max(np.ptp(heading), np.ptp(turned)) < TURN:
        return
    slope = float(turned @ heading / max(heading @ heading, 1e-12))
    if slope < -1.0 / FACTOR:
        raise LogError(
            f"{table.path}: by its wheels the base turns the other way than by the truth: left and right wheels are "
            "swapped, or a wheel or the steering counts the other way; swap the columns or the sign"
        )
    if not 1.0 / FACTOR < slope < FACTOR:
        raise LogError(
            f"{table.path}: by its wheels the base turns {slope:.3g} times what the truth says: "
            f"{_guess(1.0, slope, 'theta', 'geometry or wheels', ANGLES)}"
        )


def _guess(seen: float, far: float, truth: str, wheels: str, units: Mapping[float, str]) -> str:
    """What may be wrong with a ratio."""
    larger, ratio = (truth, seen / max(far, 1e-12)) if seen > far else (wheels, far / max(seen, 1e-12))
    for factor, name in units.items():
        if factor / FACTOR < ratio < factor * FACTOR:
            return f"{larger} in {name}, or ticks, gear or encoder wrong?"
    return "see the units of the columns, geometry, encoder and gear"
