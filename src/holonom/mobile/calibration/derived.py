"""What is calibrated of any wheel set: parameters derived from a `WheelBase`, by the kinds of its wheels.

Each kind names what may be wrong with it; a number that the odometry of any motion cannot tell from those before it
(the place of a sensor beside the origin of base_link, say) is left out, by the rank of the increments' derivatives over
random motions of the base. Derivatives are complex steps (Squire & Trapp, SIAM Review 40, 1998): exact to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError, UnknownName
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.calibration.parameters import SETS
from holonom.mobile.calibration.runs import Run

__all__ = ["DerivedParameters", "derived_parameters"]


STEP = 1e-40  # imaginary step: its square is nothing beside any number
HELD = 1e4  # weight of a wheel that must not slide beside one that rolls
SAMPLES, SEED = 96, 5  # random motions that tell which numbers odometry can tell at all
OWN = 1e-6  # share of its effect that a parameter must have for itself


@dataclass(frozen=True, slots=True)
class DerivedParameters:
    """Numbers of a wheel set and the increments that they make.

    Attributes
    ----------
    drive, set : name of the base, and which of `SETS`.
    names : of the p parameters; lengths in m, angles in rad, gears as ratios.
    nominal : (p,) by the base's description.
    scale : (p,) by how much each may reasonably be wrong altogether.
    increments : run, (p,) -> increments (N, 3) in the truth's frame, m and rad, and their derivatives (N, 3, p).
    """

    drive: str
    set: str
    names: tuple[str, ...]
    nominal: Array
    scale: Array
    increments: Callable[[Run, Array], tuple[Array, Array]]


class _Geometry(NamedTuple):
    """Places (..., wheels), axles and roller angles, radii; zero angles (..., groups), gears; the truth's frame."""

    x: Array
    y: Array
    axle: Array
    roller: Array
    radius: Array
    zero: Array
    gear: Array
    frame: Array


class _Effect(NamedTuple):
    """One parameter: nominal, scale, and what it changes of a geometry (which field, at which places, by how much)."""

    name: str
    nominal: float
    scale: float
    changes: tuple[tuple[str, Array], ...]


def derived_parameters(base: WheelBase, set_name: str = "physical") -> DerivedParameters:
    """Return what can be calibrated of a base, by the kinds of its wheels.

    Radii of driven wheels; of fixed wheels on an axle their `track`; of skidding ones `effective_track` and `centre`;
    of Swedish ones their `lever`; of steered ones `zero_<group>`, `steering_gear`, and `wheelbase` where fixed wheels
    stand behind them, else `lever`. The extended set adds the pose of the truth's frame on the base (`frame_ahead`,
    `frame_left`, `frame_yaw`), rollers' angles, and every wheel's own direction and place.

    Parameters
    ----------
    base : as it is believed to be; its wheels are those of a run's columns: driven speeds, steering angles.
    set_name : "physical" or "extended".

    Raises
    ------
    UnknownName
        No such set.
    CalibrationError
        A driven ball: one that spins on the spot tells nothing of its place.
    """
    if set_name not in SETS:
        raise UnknownName("set of parameters", set_name, SETS)
    if any(w.kind in ("spherical", "ball") and w.driven for w in base.wheels):
        raise CalibrationError(
            f"base {base.name!r} drives a ball; bases on fixed, steered, Swedish or skidding wheels are calibrated"
        )
    effects = _physical(base) + (_extended(base) if set_name == "extended" else [])
    kept = _told(base, effects)

    def increments(run: Run, p: Array) -> tuple[Array, Array]:
        return _increments(base, kept, run, p)

    return DerivedParameters(
        base.name, set_name, tuple(e.name for e in kept), np.array([e.nominal for e in kept]),
        np.array([e.scale for e in kept]), increments,
    )  # fmt: skip


def _physical(base: WheelBase) -> list[_Effect]:
    wheels = base.wheels
    found = [
        _Effect(f"radius_{w.name.replace(' ', '_')}", w.radius, w.radius, (("radius", _one(i, len(wheels))),))
        for i, w in enumerate(wheels)
        if w.driven
    ]
    at = np.array([w.acting for w in wheels])
    found += _lateral("effective_track", at, [i for i, w in enumerate(wheels) if w.kind == "skid"])
    skidding = np.array([float(w.kind == "skid") for w in wheels])
    if skidding.any():
        middle = float(at[skidding > 0.0, 0].mean())
        found.append(_Effect("centre", middle, base.radius, (("x", skidding),)))
    fixed = [i for i, w in enumerate(wheels) if w.kind == "fixed"]
    found += _lateral("track", at, [i for i in fixed if wheels[i].driven])
    steered = [i for group in base.layout.groups for i in group]
    if steered and fixed:
        found += _stretched("wheelbase", at, steered, about=at[fixed].mean(axis=0) * [1.0, 0.0], ahead=True)
    rest = [i for i, w in enumerate(wheels) if w.kind == "swedish" or (w.kind == "steered" and not fixed)]
    found += _stretched("lever", at, rest, about=at[rest].mean(axis=0) if rest else np.zeros(2), ahead=False)
    k = len(base.steered)
    for g, name in enumerate(base.steered):
        found.append(_Effect(f"zero_{name.replace(' ', '_')}", 0.0, 1.0, (("zero", _one(g, k)),)))
    return found + ([_Effect("steering_gear", 1.0, 1.0, (("gear", np.ones(k)),))] if k else [])


def _extended(base: WheelBase) -> list[_Effect]:
    wheels, n, R = base.wheels, len(base.wheels), base.radius
    names = ("frame_ahead", "frame_left", "frame_yaw")
    found = [_Effect(name, 0.0, R if j < 2 else 1.0, (("frame", _one(j, 3)),)) for j, name in enumerate(names)]
    tilted = [i for i, w in enumerate(wheels) if w.kind == "swedish" and w.roller_angle != 0.0]
    if tilted:
        gammas = np.array([w.roller_angle if i in tilted else 0.0 for i, w in enumerate(wheels)])
        size = float(np.abs(gammas).max())
        found.append(_Effect("roller_angle", size, 1.0, (("roller", gammas / size),)))
    own = [(i, w.name.replace(" ", "_")) for i, w in enumerate(wheels) if w.driven and w.kind in ("swedish", "steered")]
    found += [_Effect(f"direction_{name}", 0.0, 1.0, (("axle", _one(i, n)),)) for i, name in own]
    for axis, values in (("x", [w.x for w in wheels]), ("y", [w.y for w in wheels])):
        found += [_Effect(f"{axis}_{name}", values[i], R, ((axis, _one(i, n)),)) for i, name in own]
    return found


def _one(i: int, n: int) -> Array:
    return np.eye(n)[i]


def _lateral(name: str, at: Array, members: list[int]) -> list[_Effect]:
    """Distance of left from right wheels; all of them move away from their middle as it grows."""
    if not members:
        return []
    y = at[members, 1]
    width = float(np.ptp(y))
    if width < 1e-9:
        return []
    change = np.zeros(len(at))
    change[members] = (y - 0.5 * (y.max() + y.min())) / width
    return [_Effect(name, width, width, (("y", change),))]


def _stretched(name: str, at: Array, members: list[int], *, about: Array, ahead: bool) -> list[_Effect]:
    """Mean distance of wheels from a place (2,); all of them move away from it as it grows, or along x only."""
    if not members:
        return []
    away = at[members] - about
    if ahead:
        away[:, 1] = 0.0
    size = float(np.hypot(*away.T).mean())
    if size < 1e-9:
        return []
    change = np.zeros_like(at)
    change[members] = away / size
    return [_Effect(name, size, size, (("x", change[:, 0]), ("y", change[:, 1])))]


def _geometry(base: WheelBase, effects: list[_Effect], p: Array) -> _Geometry:
    """The base with parameters (..., q), which may be complex."""
    wheels, k = base.wheels, len(base.steered)
    at = np.array([w.acting for w in wheels])
    start = {
        "x": at[:, 0], "y": at[:, 1], "axle": np.array([w.axle for w in wheels]),
        "roller": np.array([w.roller_angle for w in wheels]), "radius": np.array([w.radius for w in wheels]),
        "zero": np.zeros(k), "gear": np.ones(k), "frame": np.zeros(3),
    }  # fmt: skip
    fields = {name: np.broadcast_to(v, (*p.shape[:-1], len(v))).astype(p.dtype) for name, v in start.items()}
    for j, effect in enumerate(effects):
        for field, change in effect.changes:
            fields[field] += (p[..., j, None] - effect.nominal) * change
    return _Geometry(**fields)


def _increments(base: WheelBase, effects: list[_Effect], run: Run, p: Array) -> tuple[Array, Array]:
    q = len(p)
    steps = np.concatenate([p[None] + 0j, p + 1j * STEP * np.eye(q)])
    found = _moved(base, _geometry(base, effects, steps), run.turns, run.steering)
    return np.ascontiguousarray(found[0].real), np.ascontiguousarray(np.moveaxis(found[1:].imag, 0, -1) / STEP)


def _moved(base: WheelBase, g: _Geometry, turns: Array, steering: Array) -> Array:
    """Increments (P, N, 3) of P geometries: the model of `WheelBase.twist`, sliding rows by a heavy weight.

    Where steered wheels that no motor turns only lead, the best motion is made as long as the driven rims say.
    """
    axle = np.broadcast_to(g.axle[:, None], (len(g.axle), len(turns) if len(base.steered) else 1, len(base.wheels)))
    axle = axle.copy()
    for j, members in enumerate(base.layout.groups):
        angle = g.gear[:, None, j] * steering[:, j] + g.zero[:, None, j]
        axle[:, :, list(members)] += angle[..., None]
    rolling, sliding, leads = [], [], False
    for i, wheel in enumerate(base.wheels):
        x, y = g.x[:, None, i], g.y[:, None, i]
        s, c = np.sin(axle[..., i]), np.cos(axle[..., i])
        if wheel.driven:
            gamma = g.roller[:, None, i]
            sg, cg = np.sin(axle[..., i] + gamma), np.cos(axle[..., i] + gamma)
            row = np.stack([sg, -cg, -(x * cg + y * sg)], axis=-1)
            rolling.append(row / (np.cos(gamma)[..., None] if wheel.kind == "swedish" else 1.0))
        if wheel.kind in ("fixed", "steered", "skid"):
            weight = 1.0 if wheel.kind == "steered" and wheel.driven else HELD
            leads = leads or (wheel.kind == "steered" and not wheel.driven)
            sliding.append(weight * np.stack([c, s, x * s - y * c], axis=-1))
    scale = np.array([1.0, 1.0, 1.0 / base.radius])
    D = np.stack(rolling, axis=-2) * scale
    rows = np.concatenate([D, np.stack(sliding, axis=-2) * scale], axis=-2) if sliding else D
    normal = np.swapaxes(rows, -1, -2) @ rows
    normal = normal + 1e-12 * np.eye(3)  # a synchro drive never turns
    driven = [i for i, wheel in enumerate(base.wheels) if wheel.driven]
    rims = turns * g.radius[:, None, driven]
    v = np.linalg.solve(normal, np.swapaxes(D, -1, -2) @ rims[..., None])[..., 0]
    if leads:
        along = (D @ v[..., None])[..., 0]
        square = (along * along).sum(axis=-1)
        still = square.real <= 1e-300
        v = v * np.where(still, 1.0, (along * rims).sum(axis=-1) / np.where(still, 1.0, square))[..., None]
    v = v * scale
    ahead, left, yaw = (g.frame[:, None, j] for j in range(3))
    vx, vy = v[..., 0] - left * v[..., 2], v[..., 1] + ahead * v[..., 2]
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([c * vx + s * vy, c * vy - s * vx, v[..., 2]], axis=-1)


def _told(base: WheelBase, effects: list[_Effect]) -> list[_Effect]:
    """Those that odometry can tell from the ones before them, by random motions that the base can drive."""
    rng = np.random.default_rng(SEED)
    twists = rng.normal(size=(SAMPLES, 3)) * [1.0, 1.0, 1.0 / base.radius]
    twists = base.feasible(twists)
    steering = base.steering(twists)
    turns = base.wheel_speeds(twists, steering, tolerance=np.inf)
    run = Run("random", np.arange(SAMPLES, dtype=np.float64), turns, np.empty((0, 3)), steering)
    nominal = np.array([e.nominal for e in effects])
    slopes = _increments(base, effects, run, nominal)[1] * np.array([e.scale for e in effects])
    columns = (slopes * np.array([1.0, 1.0, base.radius])[:, None]).reshape(-1, len(effects))
    kept: list[_Effect] = []
    basis = np.empty((len(columns), 0))
    for effect, column in zip(effects, columns.T, strict=True):
        size = np.linalg.norm(column)
        own = column - basis @ (basis.T @ column)
        own -= basis @ (basis.T @ own)
        if size > 1e-9 and np.linalg.norm(own) > OWN * size:
            kept.append(effect)
            basis = np.column_stack([basis, own / np.linalg.norm(own)])
    return kept
