"""How errors of the wheels grow along a run: the pose's deviation, by propagation and by simulated runs.

Of one cause at a time: every radius wrong by its own share of `spread` (constant along the run), every wheel standing
turned, or steered, by its own part of `angle` (constant), or every wheel slipping by its own part of `slip` of its way
in each metre (white along the way). Increments are those that are calibrated, `DerivedParameters.sampled`, and carried
along by the derivatives of the integration; runs are simulated with the same increments at numbers that are drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.errors import OutOfLimits, UnknownName
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.calibration.derived import DerivedParameters
from holonom.mobile.calibration.runs import Run
from holonom.mobile.equations.varied_wheels import HELD, HELD_KINDS, Effect
from holonom.mobile.odometry import integrate
from holonom.mobile.odometry.kernels import sensitivities_into

__all__ = ["CAUSES", "ErrorGrowth", "error_growth"]


CAUSES: Mapping[str, float] = MappingProxyType({"radius": 0.01, "slip": 0.01, "mounting": np.pi / 180.0})
"""Cause -> its usual size: share of each radius; share of the way of each rim, over a metre; rad of each wheel."""


class ErrorGrowth(NamedTuple):
    """Deviations at the end of a run, x and y (m) in the frame of its start, heading (rad).

    `propagated` (3,) to first order; `simulated` (3,) over drawn runs.
    """

    propagated: Array
    simulated: Array


def error_growth(
    base: WheelBase, run: Run, cause: str, size: float | None = None, *, runs: int = 200, seed: int = 0
) -> ErrorGrowth:
    """Return how far off odometry is at the end of a run for one cause of errors.

    Parameters
    ----------
    base : the wheels.
    run : what they do, such as `standard_run` gives; its truth is not used.
    cause : a key of `CAUSES`.
    size : standard deviation of the cause at each wheel; that of `CAUSES` unless given.
    runs : how many are simulated.
    seed : of what is drawn.

    Raises
    ------
    UnknownName, OutOfLimits
    """
    if cause not in CAUSES:
        raise UnknownName("cause of errors", cause, CAUSES)
    sigma = CAUSES[cause] if size is None else size
    if not (np.isfinite(sigma) and sigma > 0.0 and runs > 1):
        raise OutOfLimits(f"a size of {sigma} and {runs} runs came; a size above zero and two runs or more are allowed")
    rng = np.random.default_rng(seed)
    parameters = _wrong(base, "mounting" if cause == "mounting" else "radius")
    nominal = parameters.nominal
    if cause == "slip":
        ways = np.maximum(np.abs(run.turns), 1e-12) * base.wheel_radii  # m of each rim in each sample
        share = sigma / np.sqrt(ways)  # over a metre of way `sigma` of it is left
        propagated = _slipping(run, parameters, share)
        turns = run.turns * (1.0 + share * rng.normal(size=(runs, *ways.shape)))
        drawn = np.einsum("nim,rnm->rni", parameters.by_turns(run), turns, optimize=True)
    else:
        scale = sigma * parameters.scale
        propagated = np.sqrt(((_slopes(parameters, run) * scale) ** 2).sum(axis=1))
        drawn = parameters.increments_of(run, nominal + scale * rng.normal(size=(runs, len(nominal))))
    ends = _ends(drawn) - _ends(parameters.increments_of(run, nominal[None]))
    return ErrorGrowth(propagated, np.sqrt((ends**2).mean(axis=0)))


def _ends(increments: Array) -> Array:
    """Last poses (P, 3) of increments (P, N, 3), along arcs."""
    dx, dy, turn = np.moveaxis(increments, -1, 0)
    half = np.cumsum(turn, axis=-1) - 0.5 * turn
    c, s, chord = np.cos(half), np.sin(half), np.sinc(turn / (2.0 * np.pi))
    return np.stack([(chord * (c * dx - s * dy)).sum(-1), (chord * (s * dx + c * dy)).sum(-1), turn.sum(-1)], axis=-1)


def _slopes(parameters: DerivedParameters, run: Run) -> Array:
    """Derivatives (3, p) of the last pose by the parameters."""
    at = parameters.sampled(run, parameters.nominal)
    poses, out = np.empty_like(at.increments), np.empty_like(at.slopes)
    sensitivities_into(at.increments, at.slopes, np.zeros(3), 0.5, True, poses, out)
    return out[-1]


def _slipping(run: Run, parameters: DerivedParameters, share: Array) -> Array:
    """Deviations (3,) of the last pose by independent shares (N, m) of each turn."""
    m = run.turns.shape[1]
    by_turn = parameters.by_turns(run)  # (N, 3, m)
    at = parameters.sampled(run, parameters.nominal).increments
    poses = integrate(at, rule="exact")
    before = np.vstack([np.zeros(3), poses[:-1]])
    total = np.zeros(3)
    for j in range(m):
        step = by_turn[:, :, j] * (run.turns[:, j] * share[:, j])[:, None]
        half = before[:, 2] + 0.5 * at[:, 2]
        c, s = np.cos(half), np.sin(half)
        chord = np.sinc(at[:, 2] / (2.0 * np.pi))
        moved = np.stack([chord * (c * step[:, 0] - s * step[:, 1]), chord * (s * step[:, 0] + c * step[:, 1])], axis=1)
        lever = poses[-1, :2] - 0.5 * (before[:, :2] + poses[:, :2])  # a turn in a step swings all that follows
        moved += step[:, 2:] * np.stack([-lever[:, 1], lever[:, 0]], axis=1)
        total += np.array([(moved[:, 0] ** 2).sum(), (moved[:, 1] ** 2).sum(), (step[:, 2] ** 2).sum()])
    return np.sqrt(total)


def _wrong(base: WheelBase, cause: str) -> DerivedParameters:
    """What may be wrong with each wheel: its "radius", or by "mounting" the direction in which it stands or is steered.

    Wheels that stand otherwise than their axle drag each other: their sliding then counts as much as their rolling.
    """
    wheels, n = base.wheels, len(base.wheels)
    if cause == "radius":
        found = [Effect(f"radius_{w.name}", w.radius, w.radius, (("radius", np.eye(n)[i]),))
                 for i, w in enumerate(wheels) if w.driven]  # fmt: skip
    else:
        rolls = (*HELD_KINDS, "swedish", "ball")
        found = [Effect(f"direction_{w.name}", 0.0, 1.0, (("axle", np.eye(n)[i]),))
                 for i, w in enumerate(wheels) if w.kind in rolls]  # fmt: skip
    nominal, scale = (np.array([getattr(e, name) for e in found]) for name in ("nominal", "scale"))
    held = HELD if cause == "radius" else 1.0
    return DerivedParameters(base, "extended", tuple(e.name for e in found), nominal, scale, {}, tuple(found), held)
