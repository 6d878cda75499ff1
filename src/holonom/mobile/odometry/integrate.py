"""Ticks to wheel angles to increments of the base to poses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.odometry.kernels import all_finite, integrate_into
from holonom.registry import Method, Table

__all__ = [
    "RULES",
    "Rule",
    "angle_per_tick",
    "count_differences",
    "integrate",
    "metres_per_tick",
    "rule_named",
]


class Rule(NamedTuple):
    """How a step is laid out: the share of the turn that comes before its straight part; arcs, or not."""

    share: float
    exact: bool


_BOOK = "Siegwart, Nourbakhsh, Introduction to Autonomous Mobile Robots, 5.2.4; specification 6.3"

RULES = Table(
    "odometry_rules",
    "integration rule",
    "its `Rule`",
    {
        "turn_then_drive": Method("the whole turn of a step first, then its way", lambda _: Rule(1.0, False), _BOOK),
        "midpoint": Method("half the turn, the way, the other half: second order", lambda _: Rule(0.5, False), _BOOK),
        "exact": Method("the arc of a constant twist", lambda _: Rule(0.5, True), _BOOK),
    },
)
"""Integration rules by name. With an increment (dx, dy, dtheta) and the heading theta before it, the base moves along

- `turn_then_drive`: (dx, dy) turned by theta + dtheta;
- `midpoint`: (dx, dy) turned by theta + dtheta/2, half the turn (second order);
- `exact`: the same, shortened to the chord of the arc, `sin(dtheta/2) / (dtheta/2)`: exact where the twist is constant.
"""


def rule_named(name: str) -> Rule:
    """Return the integration rule of a name.

    Raises
    ------
    UnknownName
    """
    found: Rule = RULES.make(name)
    return found


def metres_per_tick(diameter: float, ticks: float, gear: float = 1.0) -> float:
    """Way of a wheel's rim per encoder tick, m: `k = pi D / (N C)` (specification 6.3).

    Parameters
    ----------
    diameter : D, of the wheel, m.
    ticks : C, of the encoder per turn of its shaft.
    gear : N, turns of the encoder's shaft per turn of the wheel.

    Raises
    ------
    OutOfLimits
        One of them is not above zero.
    """
    return 0.5 * _positive("diameter", diameter) * angle_per_tick(ticks, gear)


def angle_per_tick(ticks: float, gear: float = 1.0) -> float:
    """Angle of a wheel per encoder tick, rad; `ticks` and `gear` as for `metres_per_tick`.

    Raises
    ------
    OutOfLimits
    """
    return 2.0 * np.pi / (_positive("ticks", ticks) * _positive("gear", gear))


def count_differences(counts: ArrayLike, bits: int | None = None) -> Array:
    """Ticks of each sample (N, m) from counts that go on (N, m); the first row is zero.

    Parameters
    ----------
    counts : readings of the counters.
    bits : width of counters that run over: a step of more than half their range is one the other way.

    Raises
    ------
    ShapeError, OutOfLimits
        No (N, m) array of numbers; bits not from 1 to 52; a count beyond the counter's range.
    """
    values = np.asarray(counts, dtype=np.float64)
    if values.ndim != 2 or not np.all(np.isfinite(values)):
        raise ShapeError(f"counts have shape {values.shape}; give one finite row per sample, one column per wheel")
    steps = np.diff(values, axis=0, prepend=values[:1])
    if bits is None:
        return steps
    if not 1 <= bits <= 52:
        raise OutOfLimits(f"counters of {bits} bits came; 1 to 52 are allowed")
    span = float(2**bits)
    if np.ptp(values) >= span:
        raise OutOfLimits(
            f"counts reach over {np.ptp(values):g} ticks; counters of {bits} bits hold {span:g}: give more"
        )
    return (steps + 0.5 * span) % span - 0.5 * span


def integrate(
    increments: ArrayLike,
    *,
    matrix: ArrayLike | None = None,
    start: ArrayLike = (0.0, 0.0, 0.0),
    rule: str = "midpoint",
    out: Array | None = None,
) -> Array:
    """Add increments up to poses.

    Parameters
    ----------
    increments : (N, 3)
        dx, dy (m) and dtheta (rad) of each sample in the robot frame: `base.twist(wheel angles of the sample)`.
    matrix : (3, m)
        Turns rows of another width m, ticks or wheel angles, into increments on the way; none unless given.
    start : (3,)
        Pose before the first one, in the world.
    rule
        A key of `RULES`.
    out : (N, 3)
        Array to write to.

    Returns
    -------
    (N, 3) : x, y, theta in the world behind each increment; theta is not wrapped.

    Raises
    ------
    ShapeError, UnknownName

    Source: Siegwart & Nourbakhsh 5.2.4 (midpoint); specification 6.3.
    """
    share, exact = rule_named(rule)
    M = np.eye(3) if matrix is None else np.ascontiguousarray(matrix, dtype=np.float64)
    if M.ndim != 2 or len(M) != 3 or not np.all(np.isfinite(M)):
        raise ShapeError(f"the matrix has shape {M.shape}; give finite rows of x, y and theta, a column per wheel")
    rows = increments_of(increments, M.shape[1])
    poses = np.empty((len(rows), 3)) if out is None else out
    if poses.shape != (len(rows), 3) or poses.dtype != np.float64:
        raise ShapeError(f"out has shape {poses.shape} and type {poses.dtype}; give ({len(rows)}, 3), float64")
    integrate_into(rows, M, pose_of(start), share, exact, poses)
    return poses


def increments_of(increments: ArrayLike, width: int = 3) -> Array:
    """(N, width) finite, contiguous."""
    wanted = "dx, dy (m), dtheta (rad)" if width == 3 else f"{width} numbers"
    try:
        rows = np.ascontiguousarray(increments, dtype=np.float64)
    except (TypeError, ValueError):
        raise ShapeError(f"increments are no numbers, or rows of several lengths; give rows of {wanted}") from None
    if rows.ndim != 2 or rows.shape[1] != width:
        raise ShapeError(f"increments have shape {rows.shape}; give finite rows of {wanted}")
    if not all_finite(rows):
        row, column = np.argwhere(~np.isfinite(rows))[0]
        raise ShapeError(
            f"increments: row {row}, column {column} holds {rows[row, column]}; give finite rows of {wanted}"
        )
    return rows


def pose_of(start: ArrayLike) -> Array:
    """(3,) finite."""
    pose = np.ascontiguousarray(start, dtype=np.float64)
    if pose.shape != (3,) or not np.all(np.isfinite(pose)):
        raise ShapeError(f"the start has shape {pose.shape}; give x, y (m), theta (rad)")
    return pose


def _positive(name: str, value: float) -> float:
    if not (np.isfinite(value) and value > 0.0):
        raise OutOfLimits(f"{name} {value} came; a number above zero is allowed")
    return float(value)
