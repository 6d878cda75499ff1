"""What is calibrated of any wheel set: parameters derived from a `WheelBase`, by the kinds of its wheels.

Each kind names what may be wrong with it; a number that the odometry of any motion cannot tell from those before it
(the place of a sensor beside the origin of base_link, say) is left out, by the rank of the increments' derivatives over
random motions of the base, and named with what it cannot be told from. A base with more wheels than motions tells more:
its wheels must agree with each other, whatever the truth says (`Sampled.strain`). Derivatives are complex steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError, UnknownName
from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.calibration.parameters import SETS, Parameters, Sampled, drive_parameters
from holonom.mobile.calibration.runs import Motion, Run
from holonom.mobile.equations.varied_wheels import BALL, HELD, HELD_KINDS, Effect, geometry_of, moved

__all__ = ["DerivedParameters", "derived_parameters", "known_parameters", "with_encoders"]


STEP = 1e-40  # imaginary step: its square is nothing beside any number
SAMPLES, SEED = 96, 5  # random motions that tell which numbers odometry can tell at all
OWN = 1e-6  # share of its effect that a parameter must have for itself
NAMED = 0.02  # share of its effect that another must explain to be named


@dataclass(frozen=True, slots=True)
class DerivedParameters:
    """Numbers of a wheel set and the increments that they make.

    Attributes
    ----------
    base : as it is believed to be.
    set : which of `SETS`.
    names : of the p parameters; lengths in m, angles in rad, gears as ratios.
    nominal : (p,) by the base's description.
    scale : (p,) by how much each may reasonably be wrong altogether.
    gauge : numbers that no motion tells from those before them -> these.
    effects : how each parameter changes the base.
    held : weight of wheels that must not slide beside those that roll.
    """

    base: WheelBase
    set: str
    names: tuple[str, ...]
    nominal: Array
    scale: Array
    gauge: Mapping[str, tuple[str, ...]]
    effects: tuple[Effect, ...]
    held: float = HELD

    @property
    def drive(self) -> str:
        """Name of the base."""
        return self.base.name

    def sampled(self, run: Run, p: Array) -> Sampled:
        """Increments of a run and what its wheels count beyond any motion, with their derivatives."""
        return _sampled(self.base, self.effects, run, p, self.held)

    def increments_of(self, run: Run, p: Array) -> Array:
        """Increments (P, N, 3) of a run at P sets of parameters (P, p)."""
        return moved(self.base, geometry_of(self.base, self.effects, p), run.turns, run.steering, self.held)[0]

    def by_turns(self, run: Run) -> Array:
        """Increments (N, 3, m) per turn of each wheel, at the nominal numbers."""
        unit = np.eye(run.turns.shape[1])
        runs = [Run(run.name, run.time, np.tile(row, (len(run.time), 1)), run.truth, run.steering) for row in unit]
        return np.stack([self._moved(one, self.nominal) for one in runs], axis=-1)

    def motion(self, p: Array) -> Array | Motion:
        """What `dead_reckoning` takes: the motion matrix (3, f), of a base that steers a `Motion`."""
        if not self.base.steered:
            m = len(self.base.driven)
            unit = Run("unit", np.arange(m + 1.0), np.eye(m + 1, m), np.empty((0, 3)), np.empty((m + 1, 0)))
            return np.ascontiguousarray(self._moved(unit, p)[:m].T)
        return Motion(lambda run: self._moved(run, p), self.base.radius)

    def _moved(self, run: Run, p: Array) -> Array:
        return np.ascontiguousarray(self.increments_of(run, p[None])[0])


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
        A ball that is driven about three axes.
    """
    if set_name not in SETS:
        raise UnknownName("set of parameters", set_name, SETS)
    if any(w.driven and len(KINDS[w.kind].speeds(w)) > BALL for w in base.wheels):
        raise CalibrationError(f"base {base.name!r} drives a ball about three axes; balls on two are calibrated")
    effects = _physical(base) + (_extended(base) if set_name == "extended" else [])
    kept, gauge = _told(base, effects)
    return DerivedParameters(
        base, set_name, tuple(e.name for e in kept), np.array([e.nominal for e in kept]),
        np.array([e.scale for e in kept]), gauge, tuple(kept),
    )  # fmt: skip


def known_parameters(
    drive: str | WheelBase, nominal: Mapping[str, float] | None = None, set_name: str = "physical"
) -> Parameters:
    """Return what is calibrated of a drive by name, with its nominal numbers, or of a base, which has its own.

    Raises
    ------
    As `drive_parameters` and `derived_parameters`; CalibrationError for numbers beside a base.
    """
    if isinstance(drive, WheelBase):
        if nominal:
            raise CalibrationError(
                f"numbers {', '.join(nominal)} came beside a base, which has its own; leave them out"
            )
        return derived_parameters(drive, set_name)
    return drive_parameters(drive, nominal or {}, set_name)


def _word(wheel: Wheel) -> str:
    return wheel.name.replace(" ", "_")


def with_encoders(base: WheelBase, names: Sequence[str]) -> WheelBase:
    """The same base for odometry from other wheels than those with motors: free wheels with encoders tell as much.

    Parameters
    ----------
    names : of fixed, steered, Swedish or skidding wheels with encoders.

    Raises
    ------
    UnknownName
        No such wheel with an encoder.
    """
    may = [w.name for w in base.wheels if w.driven or w.kind in (*HELD_KINDS, "swedish")]
    for name in names:
        if name not in may:
            raise UnknownName("wheel that can have an encoder", name, may)
    wheels = [replace(w, driven=w.name in names) for w in base.wheels]
    groups = {
        name: [base.wheels[i].name for i in members]
        for name, members in zip(base.steered, base.layout.groups, strict=True)
        if len(members) > 1
    }
    return WheelBase(wheels, name=base.name, radius=base.radius, steering_groups=groups)


def _physical(base: WheelBase) -> list[Effect]:
    wheels = base.wheels
    found = [
        Effect(f"radius_{_word(w)}", w.radius, w.radius, (("radius", _one(i, len(wheels))),))
        for i, w in enumerate(wheels)
        if w.driven
    ]
    at = np.array([w.acting for w in wheels])
    found += _lateral("effective_track", at, [i for i, w in enumerate(wheels) if w.kind == "skid"])
    skidding = np.array([float(w.kind == "skid") for w in wheels])
    if skidding.any():
        middle = float(at[skidding > 0.0, 0].mean())
        found.append(Effect("centre", middle, base.radius, (("x", skidding),)))
    fixed = [i for i, w in enumerate(wheels) if w.kind == "fixed"]
    found += _lateral("track", at, [i for i in fixed if wheels[i].driven])
    steered = [i for group in base.layout.groups for i in group]
    if steered and fixed:
        found += _stretched("wheelbase", at, steered, about=at[fixed].mean(axis=0) * [1.0, 0.0], ahead=True)
    rest = [i for i, w in enumerate(wheels) if w.kind == "swedish" or (w.kind == "steered" and not fixed)]
    found += _stretched("lever", at, rest, about=at[rest].mean(axis=0) if rest else np.zeros(2), ahead=False)
    k = len(base.steered)
    for g, name in enumerate(base.steered):
        found.append(Effect(f"zero_{name.replace(' ', '_')}", 0.0, 1.0, (("zero", _one(g, k)),)))
    return found + ([Effect("steering_gear", 1.0, 1.0, (("gear", np.ones(k)),))] if k else [])


def _extended(base: WheelBase) -> list[Effect]:
    wheels, n, R = base.wheels, len(base.wheels), base.radius
    names = ("frame_ahead", "frame_left", "frame_yaw")
    found = [Effect(name, 0.0, R if j < 2 else 1.0, (("frame", _one(j, 3)),)) for j, name in enumerate(names)]
    tilted = [i for i, w in enumerate(wheels) if w.kind == "swedish" and w.roller_angle != 0.0]
    if tilted:
        gammas = np.array([w.roller_angle if i in tilted else 0.0 for i, w in enumerate(wheels)])
        size = float(np.abs(gammas).max())
        found.append(Effect("roller_angle", size, 1.0, (("roller", gammas / size),)))
    own = [(i, _word(w)) for i, w in enumerate(wheels) if w.driven and w.kind in ("swedish", "steered")]
    found += [Effect(f"direction_{name}", 0.0, 1.0, (("axle", _one(i, n)),)) for i, name in own]
    for axis, values in (("x", [w.x for w in wheels]), ("y", [w.y for w in wheels])):
        found += [Effect(f"{axis}_{name}", values[i], R, ((axis, _one(i, n)),)) for i, name in own]
    return found


def _one(i: int, n: int) -> Array:
    return np.eye(n)[i]


def _lateral(name: str, at: Array, members: list[int]) -> list[Effect]:
    """Distance of left from right wheels; all of them move away from their middle as it grows."""
    if not members:
        return []
    y = at[members, 1]
    width = float(np.ptp(y))
    if width < 1e-9:
        return []
    change = np.zeros(len(at))
    change[members] = (y - 0.5 * (y.max() + y.min())) / width
    return [Effect(name, width, width, (("y", change),))]


def _stretched(name: str, at: Array, members: list[int], *, about: Array, ahead: bool) -> list[Effect]:
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
    return [Effect(name, size, size, (("x", change[:, 0]), ("y", change[:, 1])))]


def _sampled(base: WheelBase, effects: Sequence[Effect], run: Run, p: Array, held: float = HELD) -> Sampled:
    q = len(p)
    steps = np.concatenate([p[None] + 0j, p + 1j * STEP * np.eye(q)])
    parts: list[Array] = []
    for found in moved(base, geometry_of(base, effects, steps), run.turns, run.steering, held):
        slopes = np.moveaxis(found[1:].imag, 0, -1) / STEP
        parts += [np.ascontiguousarray(found[0].real), np.ascontiguousarray(slopes)]
    return Sampled(*parts)


def _told(base: WheelBase, effects: list[Effect]) -> tuple[list[Effect], dict[str, tuple[str, ...]]]:
    """Those that odometry can tell from the ones before them, by random motions that the base can drive; the others."""
    rng = np.random.default_rng(SEED)
    twists = rng.normal(size=(SAMPLES, 3)) * [1.0, 1.0, 1.0 / base.radius]
    twists = base.feasible(twists)
    steering = base.steering(twists)
    turns = base.wheel_speeds(twists, steering, tolerance=np.inf)
    run = Run("random", np.arange(SAMPLES, dtype=np.float64), turns, np.empty((0, 3)), steering)
    nominal = np.array([e.nominal for e in effects])
    found = _sampled(base, effects, run, nominal)
    by_motion = (found.slopes * np.array([1.0, 1.0, base.radius])[:, None]).reshape(-1, len(effects))
    by_strain = found.strain_slopes.reshape(-1, len(effects))
    columns = np.concatenate([by_motion, by_strain]) * np.array([e.scale for e in effects])
    kept: list[Effect] = []
    gauge: dict[str, tuple[str, ...]] = {}
    basis = np.empty((len(columns), 0))
    told: list[Array] = []
    for effect, column in zip(effects, columns.T, strict=True):
        size = np.linalg.norm(column)
        own = column - basis @ (basis.T @ column)
        own -= basis @ (basis.T @ own)
        if size > 1e-9 and np.linalg.norm(own) > OWN * size:
            kept.append(effect)
            told.append(column)
            basis = np.column_stack([basis, own / np.linalg.norm(own)])
            continue
        twin = next((k for k, one in enumerate(told) if _alike(one, column)), None)
        if twin is not None and effect.name.startswith("radius"):  # one number for wheels that only act together
            kept[twin] = _joined(kept[twin], effect)
            continue
        share = np.zeros(0)
        if size > 1e-9:
            A = np.stack(told, axis=1)
            share = np.abs(np.linalg.lstsq(A, column, rcond=None)[0]) * np.linalg.norm(A, axis=0) / size
        gauge[effect.name] = tuple(e.name for e, part in zip(kept, share, strict=False) if part > NAMED)
    return kept, gauge


def _alike(a: Array, b: Array) -> bool:
    return float(np.linalg.norm(a - b)) < OWN * float(np.linalg.norm(b))


def _joined(one: Effect, other: Effect) -> Effect:
    changes = tuple((field, a + b) for (field, a), (_, b) in zip(one.changes, other.changes, strict=True))
    return Effect(f"{one.name}_and_{other.name.removeprefix('radius_')}", one.nominal, one.scale, changes)
