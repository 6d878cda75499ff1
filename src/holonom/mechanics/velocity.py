"""Joint rates for tool twists, and joint paths that follow a Cartesian path without drift."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, real_array
from holonom.errors import InputError, ShapeError
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.arm.nearest import joint_vectors
from holonom.mechanics.loops.velocity import AUTO, rates_of_one, rates_of_rows
from holonom.spatial import check_pose

__all__ = ["PathResult", "follow_path", "joint_rates"]


@dataclass(frozen=True, slots=True)
class PathResult:
    """Joints along a path.

    q, qd : (..., N, n) rad or m, and per s; the rates lead from each sample to the next one (0 at the last).
    residual : (..., N) length of the pose error at each sample, m and rad.
    within_limits : (..., N) whether positions and speeds keep the joint limits.
    """

    q: Array
    qd: Array
    residual: Array
    within_limits: NDArray[np.bool_]


def joint_rates(
    arm: Arm, q: ArrayLike, twist: ArrayLike, *, frame: str = "world", damping: str | float = "auto"
) -> Array:
    """Return the joint rates that move the tool with a twist: least squares, and least rates for redundant arms.

    Parameters
    ----------
    q : (..., n).
    twist : (..., 6) [v; w] of the tool point, m/s and rad/s.
    frame : "world", "base" or "tool", the axes of the twist.
    damping : "auto", or lambda of qd = J^T (J J^T + lambda^2)^-1 twist; 0 is the pseudoinverse. "auto" follows the
        smallest singular value s: lambda^2 = (1 - (s / e)^2) e^2 below e = 0.02 of the largest one, 0 above. Then
        rates stay below 1 / e of the twist, and the motion is exact wherever the arm is not near a singularity.

    Returns
    -------
    qd : (..., n) rad/s or m/s.

    Raises
    ------
    ShapeError, UnknownName, InputError

    Notes
    -----
    Nakamura & Hanafusa (1986); Siciliano et al., Robotics, 3.5.2.
    """
    wanted = _damping(damping)
    one, plan, like = arm.prepared[_prepared, frame]
    found: Array | None = one(plan, q, twist, wanted, like)
    return _rates(arm.jacobian(q, frame), twist, wanted) if found is None else found


def _damping(damping: str | float) -> float:
    if damping == "auto":
        return AUTO
    if isinstance(damping, str) or not (math.isfinite(damping) and damping >= 0.0):
        raise InputError(f'damping is {damping!r}; "auto" or a number of at least 0 is needed')
    return float(damping)


def _prepared(arm: Arm, frame: str) -> tuple[Callable[..., Array | None], NDArray[np.int64], Array]:
    """One sample in one compiled call; an arm that stands elsewhere than its first one goes the general way."""
    if arm.placement is not None:
        return lambda *_: None, np.empty(0, np.int64), np.empty(0)
    return rates_of_one(), np.array([arm.kernel("jacobian", frame=frame).address, arm.n]), np.empty(arm.n)


def _rates(J: Array, twist: ArrayLike, damping: float) -> Array:
    """Rates (..., n) for Jacobians (..., 6, n) and twists (..., 6), with lambda or `AUTO`."""
    wanted = real_array("twist", twist)
    if wanted.shape[-1:] != (6,) or not np.isfinite(wanted).all():
        raise ShapeError(f"twist must be finite and of shape (..., 6), [v; w]; shape {wanted.shape} came")
    lead, n = np.broadcast_shapes(J.shape[:-2], wanted.shape[:-1]), J.shape[-1]
    count, qd = math.prod(lead), np.empty((*lead, n))
    rows = np.ascontiguousarray(np.broadcast_to(J, (*lead, 6, n))).reshape(count, 6, n)
    twists = np.ascontiguousarray(np.broadcast_to(wanted, (*lead, 6))).reshape(count, 6)
    rates_of_rows(rows, twists, damping, qd.reshape(count, n))
    return qd


def follow_path(
    arm: Arm, q0: ArrayLike, T_path: ArrayLike, dt: float, *, gain: float | None = None, damping: str | float = "auto"
) -> PathResult:
    """Follow poses sampled in time by closed-loop inverse kinematics: the pose error is fed back, so nothing drifts.

    Each sample's rates are J^+ (twist to the next pose + gain * pose error) and move the joints for `dt`.

    Parameters
    ----------
    q0 : (..., n) joints at the start. They need not reach the first pose: the error decays with exp(-gain t).
    T_path : (..., N, 4, 4), T_wt at the samples; several paths go together.
    dt : time between samples, s.
    gain : 1/s, above 0 and below 2 / dt; 0.5 / dt by default. 0 gives the open loop, which drifts.
    damping : as for `joint_rates`.

    Raises
    ------
    NotAPose, ShapeError, InputError

    Notes
    -----
    Siciliano et al., Robotics, 3.7.1.
    """
    poses = check_pose(T_path, "T_path")
    if poses.ndim < 3 or poses.shape[-3] < 1:
        raise ShapeError(f"T_path must hold poses in a row, (..., N, 4, 4) with N >= 1; shape {poses.shape} came")
    if not (math.isfinite(dt) and dt > 0.0):
        raise InputError(f"dt is {dt} s; a positive time between samples is needed")
    k = 0.5 / dt if gain is None else float(gain)
    if not 0.0 <= k * dt < 2.0:
        raise InputError(f"gain is {gain} 1/s with dt = {dt} s; 0 <= gain < {2.0 / dt:g} keeps the error decaying")
    _damping(damping)
    return _follow(arm, _start(arm, q0, poses.shape[:-3]), poses, dt, k, damping)


def _start(arm: Arm, q0: ArrayLike, lead: tuple[int, ...]) -> Array:
    given = joint_vectors("q0", q0, arm.limits.names)
    try:
        return np.broadcast_to(given, (*lead, arm.n)).copy()
    except ValueError:
        raise ShapeError(f"q0 must broadcast to {(*lead, arm.n)}; shape {given.shape} came") from None


def _follow(arm: Arm, start: Array, poses: Array, dt: float, gain: float, damping: str | float) -> PathResult:
    count = poses.shape[-3]
    q = np.empty((*poses.shape[:-2], arm.n))
    qd = np.zeros_like(q)
    residual = np.empty(poses.shape[:-2])
    q[..., 0, :] = start
    for i in range(count):
        error = _twist(arm.fk(q[..., i, :]), poses[..., i, :, :])
        residual[..., i] = np.linalg.norm(error, axis=-1)
        if i + 1 < count:
            ahead = _twist(poses[..., i, :, :], poses[..., i + 1, :, :]) / dt
            qd[..., i, :] = joint_rates(arm, q[..., i, :], ahead + gain * error, damping=damping)
            q[..., i + 1, :] = q[..., i, :] + dt * qd[..., i, :]
    bounds = arm.limits
    inside = (q >= bounds.lower) & (q <= bounds.upper) & (np.abs(qd) <= bounds.speed)
    return PathResult(q, qd, residual, np.asarray(inside.all(-1)))


def _twist(T: Array, T_to: Array) -> Array:
    """[p_to - p; log(R_to R^T)] (..., 6): what takes one pose to the other in unit time, world axes."""
    from scipy.spatial.transform import Rotation  # heavy: on first use

    turn = T_to[..., :3, :3] @ np.swapaxes(T[..., :3, :3], -1, -2)
    w = Rotation.from_matrix(turn.reshape(-1, 3, 3)).as_rotvec().reshape(*turn.shape[:-2], 3)
    return np.concatenate([T_to[..., :3, 3] - T[..., :3, 3], w], axis=-1)
