"""What a simulation needs before it runs: laws, time grid, the compiled closed loop with its parameters, references."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, isfinite

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array, vectors
from holonom.errors import InputError, OutOfLimits, ShapeError, UnknownName
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.kernels.closed_loop import fields_of
from holonom.mechanics.kernels.movable import check_movable
from holonom.mechanics.kernels.placement import GIVEN
from holonom.mechanics.motion.trajectory import Trajectory
from holonom.trace import Kernel

__all__ = [
    "ComputedTorque",
    "Grid",
    "Law",
    "Loop",
    "PDGravity",
    "TorqueFunction",
    "closed_loop_of",
    "count_of",
    "reference_of",
    "rows_of",
    "time_grid",
    "vector_of",
]

TorqueFunction = Callable[[float, Array, Array], ArrayLike]


@dataclass(frozen=True, slots=True)
class PDGravity:
    """tau = kp (q_r - q) + kd (qd_r - qd) + g(q); gains of one number or (n,), N m/rad and N m s/rad.

    `reference` is a configuration (n,) to hold or a `Trajectory` to follow (then held at its end); the start if none.
    """

    kp: ArrayLike
    kd: ArrayLike
    reference: ArrayLike | Trajectory | None = None


@dataclass(frozen=True, slots=True)
class ComputedTorque:
    """tau = B(q) (qdd_r + kd (qd_r - qd) + kp (q_r - q)) + C(q, qd) qd + g(q), gains in 1/s2 and 1/s.

    Friction that the model states is fed forward along the reference; `reference` as in `PDGravity`.
    """

    kp: ArrayLike
    kd: ArrayLike
    reference: ArrayLike | Trajectory | None = None


Law = PDGravity | ComputedTorque


@dataclass(frozen=True, slots=True)
class Loop:
    """The compiled closed loop and its parameters (K, p), K being 1 where nothing varies.

    `stiction` decides whether joints stick; None where there is no Coulomb friction.
    """

    arm: Arm
    kernel: Kernel
    parameters: Array
    stiction: Kernel | None


@dataclass(frozen=True, slots=True)
class Grid:
    """Step (s), steps per sample, times of the samples and of every half step."""

    dt: float
    every: int
    samples: Array
    halves: Array


def time_grid(duration: float, dt: float, every: int) -> Grid:
    """Whole samples that fill a duration, in steps not longer than `dt`."""
    for name, value in (("duration", duration), ("dt", dt)):
        if not value > 0.0 or not isfinite(value):
            raise OutOfLimits(f"{name} is {value!r} s; give a positive, finite time")
    if every < 1:
        raise OutOfLimits(f"every is {every}; give the steps per stored sample, 1 or more")
    count = max(ceil(duration / (dt * every) - 1e-9), 1)
    return Grid(
        duration / (count * every),
        every,
        np.linspace(0.0, duration, count + 1),
        np.linspace(0.0, duration, 2 * count * every + 1),
    )


def closed_loop_of(
    arm: Arm,
    controller: Law | TorqueFunction | None,
    friction: bool | None,
    varied: Mapping[str, ArrayLike | None],
    wrench: ArrayLike | None,
    wrench_frame: str | None,
) -> Loop:
    """Compile the closed loop and lay out its parameters; `varied` maps "payload", "masses", "friction" to rows."""
    if (wrench is None) != (wrench_frame is None):
        raise InputError('wrench= and wrench_frame= ("world" or "tool") go together; one of them is missing')
    if wrench_frame not in (None, "world", "tool"):
        raise UnknownName("wrench frame", str(wrench_frame), ("world", "tool"))
    given = {name: value for name, value in varied.items() if value is not None}
    if "payload" not in given:
        check_movable(arm.model)
    has_friction = any(joint.friction is not None for joint in arm.model.joints)
    options = {
        "law": {PDGravity: "pd_gravity", ComputedTorque: "computed_torque"}.get(type(controller), "torque"),
        "varied": tuple(given),
        "friction": has_friction if friction is None else friction,
        "wrench_frame": wrench_frame,
        "given": tuple(GIVEN) if arm.placement else (),
    }
    values = dict(given)
    if arm.placement:
        values |= {f"at_{name}": value.ravel() for name, value in arm.placement.numbers.items()}
    if isinstance(controller, Law):
        kp, kd = _gains("kp", controller.kp, arm.n), _gains("kd", controller.kd, arm.n)
        values["gains"] = np.concatenate([kp, kd])
    if wrench is not None:
        values["wrench"] = wrench
    fields = {name: width for name, width in fields_of(arm.model, options).items() if width}
    tables = {name: rows_of(name, values[name], width) for name, width in fields.items()} or {"none": np.zeros((1, 1))}
    count = count_of(tables)
    whole = np.concatenate([np.broadcast_to(table, (count, table.shape[1])) for table in tables.values()], axis=1)
    rough = [j.friction for j in arm.model.joints if j.friction is not None]
    sticks = options["friction"] and any(f.coulomb_positive or f.coulomb_negative for f in rough)
    stiction = arm.first.kernel("stiction", **options) if sticks else None
    return Loop(arm, arm.first.kernel("closed_loop", **options), whole, stiction)


def vector_of(name: str, value: ArrayLike, n: int) -> Array:
    """`value` as finite floats (n,)."""
    rows = rows_of(name, value, n)
    if np.ndim(value) != 1:
        raise ShapeError(f"{name} has shape {np.shape(value)}; give one configuration ({n},)")
    return rows[0]


def rows_of(name: str, value: ArrayLike, width: int) -> Array:
    """`value` as finite rows (K, width); (width,) gives K = 1."""
    if np.ndim(value) not in (1, 2):
        raise ShapeError(f"{name} has shape {np.shape(value)}; ({width},) or (K, {width}) is needed")
    return np.atleast_2d(vectors(name, value, width))


def count_of(tables: Mapping[str, Array]) -> int:
    """The number of rows that the tables share; one row goes with any number."""
    counts = {name: table.shape[0] for name, table in tables.items() if table.shape[0] != 1}
    if len(set(counts.values())) > 1:
        named = ", ".join(f"{name}: {count}" for name, count in counts.items())
        raise ShapeError(f"numbers of variations differ ({named}); give one row each, or the same number of rows")
    return next(iter(counts.values()), 1)


def _gains(name: str, value: ArrayLike, n: int) -> Array:
    gains = real_array(name, value)
    if gains.shape not in ((), (n,)) or not np.isfinite(gains).all() or (gains < 0.0).any():
        raise OutOfLimits(f"{name} is {value!r}; give finite gains, not negative: one number or ({n},)")
    return np.broadcast_to(gains, (n,))


def reference_of(arm: Arm, controller: object, start: Array) -> Callable[[Array], Array]:
    """The reference of a compiled law as a function of times (N,)."""
    if not isinstance(controller, Law):
        return lambda t: np.zeros((np.size(t), arm.n))
    wanted = start if controller.reference is None else controller.reference
    if isinstance(wanted, Trajectory):
        if wanted.q.shape[1] != arm.n:
            raise ShapeError(f"the reference moves {wanted.q.shape[1]} joints; the arm has {arm.n}")
        return _along(wanted)
    held = np.concatenate([vector_of("reference", wanted, arm.n), np.zeros(2 * arm.n)])
    return lambda t: np.broadcast_to(held, (np.size(t), held.shape[0])).copy()


def _along(trajectory: Trajectory) -> Callable[[Array], Array]:
    """Positions and speeds between samples by Hermite cubics, accelerations linear; at rest after the end."""
    from scipy.interpolate import CubicHermiteSpline

    times = trajectory.dt * np.arange(trajectory.q.shape[0])
    if times.shape[0] == 1:
        held = np.concatenate([trajectory.q[0], 0.0 * trajectory.q[0], 0.0 * trajectory.q[0]])
        return lambda t: np.broadcast_to(held, (np.size(t), held.shape[0])).copy()
    path = CubicHermiteSpline(times, trajectory.q, trajectory.qd)

    def sample(t: Array) -> Array:
        inside = np.clip(np.atleast_1d(t), 0.0, times[-1])
        running = (np.atleast_1d(t) <= times[-1])[:, None]
        qdd = np.stack([np.interp(inside, times, column) for column in trajectory.qdd.T], axis=-1)
        return np.concatenate([path(inside), path(inside, 1) * running, qdd * running], axis=-1)

    return sample
