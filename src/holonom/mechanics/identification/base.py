"""Base parameters: the smallest set of numbers that the torque depends on (Gautier & Khalil 1990; Gautier 1991)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from holonom.arrays import Array
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.identification.columns import column_names, regressor_of_rows, stated_columns
from holonom.model import ArmModel

__all__ = ["BaseParameters", "base_parameters", "motion_ranges", "random_motion"]

Mask = NDArray[np.bool_]

RANK_TOLERANCE = 1e-8  # of unit columns; kinematics given to fewer digits than this groups less than it should
CLEAR = 0.01  # part of a unit column that others do not explain; less makes groups of large factors
SAMPLES_PER_PARAMETER = 4
PREFERENCE = (7, 5, 6, 9, 0, 1, 8, 2, 3, 4)  # place of m, hx, hy, hz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz within a link


@dataclass(frozen=True, slots=True)
class BaseParameters:
    """What a motion can tell about an arm: beta = grouping @ pi, and Y pi = Y[:, columns] beta for every motion.

    Attributes
    ----------
    names : the p columns of the regressor.
    columns : (b,) the columns that stand for the base parameters.
    grouping : (b, p), with a unit matrix in `columns`.
    condition : of the base regressor, its columns scaled to 1, on a random motion within the limits.
    scale : (b,) root mean square of the base regressor's columns on that motion.
    without_effect : names of the parameters that no torque depends on.
    """

    names: tuple[str, ...]
    columns: NDArray[np.intp]
    grouping: Array
    condition: float
    scale: Array
    without_effect: tuple[str, ...]

    @property
    def number(self) -> int:
        """How many there are."""
        return len(self.columns)

    def formulas(self) -> tuple[str, ...]:
        """Each base parameter as a sum of the arm's parameters, such as "Izz1 + 0.25 m2"."""
        return tuple(self._sum(k, row) for k, row in zip(self.columns, self.grouping, strict=True))

    def _sum(self, first: int, row: Array) -> str:
        text = self.names[first]
        for k in np.flatnonzero(row):
            factor = "" if abs(abs(row[k]) - 1) < 1e-9 else f"{abs(row[k]):.6g} "
            text += "" if k == first else f" {'-' if row[k] < 0 else '+'} {factor}{self.names[k]}"
        return text


def base_parameters(arm: Arm, *, friction: bool = True, seed: int = 0) -> BaseParameters:
    """Find the base parameters from the rank of the regressor of a random motion within the joint limits.

    Parameters
    ----------
    friction : whether friction is among the parameters; rotor inertias are where the model states motors.
    seed : of the random motion. The result depends on it only through `condition` and `scale`.

    Notes
    -----
    Columns are taken from the base to the tip, within a link Ixx, Ixy, Ixz, Iyz, Izz, hx, hy, Iyy, hz, m; one that
    depends on those before it is grouped into them, as in Gautier and Khalil's closed form. Where a joint states no
    limits, positions of half a turn (1 m) to either side, 2 rad/s and 10 rad/s2 are taken.
    """
    used = stated_columns(arm.model, friction=friction)
    count = max(100, SAMPLES_PER_PARAMETER * int(used.sum()) // arm.n)
    motion = random_motion(arm.model, count, np.random.default_rng(seed))
    Y = regressor_of_rows(arm.model)(*motion)
    return _grouped(Y.reshape(-1, Y.shape[-1]), used, _order(len(arm.model.joints)), column_names(arm.model))


def _order(joints: int) -> NDArray[np.intp]:
    """The columns in the order in which they are preferred as base parameters."""
    within = np.argsort(PREFERENCE)
    bodies = (10 * np.arange(joints)[:, None] + within).ravel()
    return np.concatenate([bodies, np.arange(10 * joints, 14 * joints)])


def motion_ranges(model: ArmModel) -> tuple[Array, Array, Array]:
    """Position (2, n), speed (n,) and acceleration (n,) limits, finite ones in place of those that are not stated."""
    joints = [model.joints[i] for i in model.independent]
    reach = np.array([np.pi if joint.turns else 1.0 for joint in joints])
    limits = [model.limits(i) for i in model.independent]
    lower, upper = np.array([b.lower for b in limits]), np.array([b.upper for b in limits])
    lower = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2 * reach, -reach))
    upper = np.where(np.isfinite(upper), upper, lower + 2 * reach)
    speed, acceleration = np.array([b.speed for b in limits]), np.array([b.acceleration for b in limits])
    speed = np.where(np.isfinite(speed), speed, 2.0)
    return np.array([lower, upper]), speed, np.where(np.isfinite(acceleration), acceleration, 10.0)


def random_motion(model: ArmModel, count: int, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Independent random q, qd, qdd (count, n) within the ranges."""
    (lower, upper), speed, acceleration = motion_ranges(model)
    shape = (count, len(lower))
    return (
        rng.uniform(lower, upper, shape),
        rng.uniform(-speed, speed, shape),
        rng.uniform(-acceleration, acceleration, shape),
    )


def _grouped(Y: Array, used: Mask, order: NDArray[np.intp], names: tuple[str, ...]) -> BaseParameters:
    size = np.linalg.norm(Y, axis=0)
    effective = used & (size > RANK_TOLERANCE * size.max())
    taken = order[effective[order]]
    R: Array = np.asarray(np.linalg.qr(Y[:, taken] / size[taken], mode="r"))
    kept = _independent(R, _rank(R))
    columns = taken[kept]
    solved = np.linalg.lstsq(R[:, kept], R, rcond=None)[0]
    solved[np.abs(solved) < RANK_TOLERANCE] = 0.0
    grouping = np.zeros((len(kept), len(names)))
    grouping[:, taken] = solved * size[taken] / size[columns, None]
    condition = float(np.linalg.cond(R[:, kept]))
    without = tuple(name for name, u, e in zip(names, used, effective, strict=True) if u and not e)
    return BaseParameters(names, columns, grouping, condition, size[columns] / np.sqrt(len(Y)), without)


def _rank(A: Array) -> int:
    """Numerical rank by QR with column pivoting."""
    R = qr(A, mode="r", pivoting=True)[0]
    return int((np.abs(np.diagonal(R)) > RANK_TOLERANCE).sum())


def _independent(A: Array, rank: int) -> list[int]:
    """The first columns that do not nearly depend on those before them, then the first that do not depend on these.

    Modified Gram-Schmidt, twice for accuracy.
    """
    basis = np.zeros((A.shape[0], 0))
    kept: list[int] = []
    for threshold in (CLEAR, RANK_TOLERANCE):
        for k in range(A.shape[1]):
            rest = A[:, k] - basis @ (basis.T @ A[:, k])
            rest -= basis @ (basis.T @ rest)
            if (size := np.linalg.norm(rest)) > threshold and len(kept) < rank:
                kept.append(k)
                basis = np.column_stack([basis, rest / size])
    assert len(kept) == rank, f"rank {rank}, but {len(kept)} independent columns"
    return sorted(kept)
