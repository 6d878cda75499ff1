"""Increments of any wheel set whose numbers are off, and what its wheels count beyond any motion; complex numbers too.

The model is that of `WheelBase.twist`, with numbers that vary instead of rows that are compiled: derivatives are
complex steps (Squire & Trapp, SIAM Review 40, 1998), exact to rounding, all of them side by side.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.mobile.base.wheel import KINDS
from holonom.mobile.base.wheel_base import WheelBase

__all__ = ["BALL", "HELD", "HELD_KINDS", "Effect", "Geometry", "geometry_of", "moved"]


HELD = 1e4  # weight of a wheel that must not slide beside one that rolls
BALL = 2  # speeds of a ball, along its heading and along its axle
HELD_KINDS = ("fixed", "steered", "skid")


class Geometry(NamedTuple):
    """Places (..., wheels), axles and roller angles, radii; zero angles (..., groups), gears; the truth's frame."""

    x: Array
    y: Array
    axle: Array
    roller: Array
    radius: Array
    zero: Array
    gear: Array
    frame: Array


class Effect(NamedTuple):
    """One parameter: nominal, scale, and what it changes of a geometry (which field, at which places, by how much)."""

    name: str
    nominal: float
    scale: float
    changes: tuple[tuple[str, Array], ...]


def geometry_of(base: WheelBase, effects: Sequence[Effect], p: Array) -> Geometry:
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
    return Geometry(**fields)


def moved(base: WheelBase, g: Geometry, turns: Array, steering: Array, held: float) -> tuple[Array, Array]:
    """Increments (P, N, 3) of P geometries: the model of `WheelBase.twist`, sliding rows of fixed wheels heavy.

    The angle of a steered wheel is measured, like the turn of a driven one: where their axles do not meet in one point
    the motion fits both alike (`WheelBase.twist` lets wheels lead that are not driven; where they meet it is the same).
    And what each row (P, N, k) misses, as a turn of a wheel, rad.
    """
    axle = np.broadcast_to(g.axle[:, None], (len(g.axle), len(turns) if len(base.steered) else 1, len(base.wheels)))
    axle = axle.copy()
    for j, members in enumerate(base.layout.groups):
        angle = g.gear[:, None, j] * steering[:, j] + g.zero[:, None, j]
        axle[:, :, list(members)] += angle[..., None]
    rolling, sliding, weights = [], [], []
    for i, wheel in enumerate(base.wheels):
        x, y = g.x[:, None, i], g.y[:, None, i]
        s, c = np.sin(axle[..., i]), np.cos(axle[..., i])
        if wheel.driven:
            gamma = g.roller[:, None, i]
            sg, cg = np.sin(axle[..., i] + gamma), np.cos(axle[..., i] + gamma)
            row = np.stack([sg, -cg, -(x * cg + y * sg)], axis=-1)
            rolling.append(row / (np.cos(gamma)[..., None] if wheel.kind == "swedish" else 1.0))
        if wheel.driven and len(KINDS[wheel.kind].speeds(wheel)) == BALL:
            spin = np.zeros_like(rolling[-1])
            spin[..., 2] = wheel.radius
            rolling.append(np.stack([c, s, x * s - y * c], axis=-1))
            sliding.append(spin)
            weights.append(held)
        if wheel.kind in HELD_KINDS:
            weights.append(1.0 if wheel.kind == "steered" else held)
            sliding.append(np.stack([c, s, x * s - y * c], axis=-1))
    scale = np.array([1.0, 1.0, 1.0 / base.radius])
    D = np.stack(rolling, axis=-2) * scale
    C = np.stack(sliding, axis=-2) * scale if sliding else D[..., :0, :]
    rows = np.concatenate([D, C * np.array(weights)[:, None]], axis=-2)
    normal = np.empty((*rows.shape[:-2], 3, 3), dtype=rows.dtype)  # tiny complex products are slow, sums are not
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        normal[..., i, j] = normal[..., j, i] = (rows[..., i] * rows[..., j]).sum(axis=-1)
    normal += 1e-12 * np.eye(3)  # a synchro drive never turns
    driven = [i for i, wheel in enumerate(base.wheels) if wheel.driven for _ in KINDS[wheel.kind].speeds(wheel)]
    rims = turns * g.radius[:, None, driven]
    v = _solved(normal, (D * rims[..., None]).sum(axis=-2))
    size = g.radius[:, None, driven]  # as turns of wheels, of which a base that is larger altogether has no more
    apart = turns - (D * v[..., None, :]).sum(axis=-1) / size
    strain = np.concatenate([apart, (C * v[..., None, :]).sum(axis=-1) / size.mean(axis=-1, keepdims=True)], axis=-1)
    v = v * scale
    ahead, left, yaw = (g.frame[:, None, j] for j in range(3))
    vx, vy = v[..., 0] - left * v[..., 2], v[..., 1] + ahead * v[..., 2]
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([c * vx + s * vy, c * vy - s * vx, v[..., 2]], axis=-1), strain


def _solved(A: Array, b: Array) -> Array:
    """x (..., 3) of `A x = b` for symmetric A (..., 3, 3), by the adjugate, quick for many and for complex ones."""
    (a, d, e), (_, f, g), (_, _, h) = (tuple(A[..., i, j] for j in range(3)) for i in range(3))
    row = f * h - g * g, e * g - d * h, d * g - e * f
    rest = a * h - e * e, d * e - a * g, a * f - d * d
    x, y, z = np.moveaxis(np.broadcast_to(b, (*np.broadcast_shapes(A.shape[:-1], b.shape),)), -1, 0)
    scale = 1.0 / (a * row[0] + d * row[1] + e * row[2])
    return np.stack(
        [
            scale * (row[0] * x + row[1] * y + row[2] * z),
            scale * (row[1] * x + rest[0] * y + rest[1] * z),
            scale * (row[2] * x + rest[1] * y + rest[2] * z),
        ],
        axis=-1,
    )
