"""Maps: what an arm reaches in a slice of the room, and how well it moves over two of its joints."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import InputError, OutOfLimits, UnknownName
from holonom.mechanics import Arm
from holonom.mechanics.analysis import manipulability
from holonom.plots.figure import COLORS, new_figure, saved
from holonom.plots.skeleton import configurations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_manipulability", "draw_workspace"]

_PLANES = {"xy": (0, 1, 2), "xz": (0, 2, 1), "yz": (1, 2, 0)}
_BATCH = 1 << 16


def draw_workspace(
    arm: Arm, *, plane: Literal["xy", "xz", "yz"] = "xz", at: float = 0.0, thickness: float = 0.05,
    samples: int = 3_000_000, cells: int = 80, seed: int = 0, save: str | Path | None = None,
) -> Figure:  # fmt: skip
    """Map the places that the tool point reaches near a plane, coloured by the best manipulability found there.

    Random configurations within the joint limits: a cell without colour was not met, which proves nothing.

    Parameters
    ----------
    plane, at, thickness
        The slice: two world axes, its place on the third one and its thickness (m).
    samples, seed
        How many configurations, and the seed that chooses them.
    cells
        Cells of the map along its longer side.

    Raises
    ------
    UnknownName, OutOfLimits, InputError, OutputError
    """
    if plane not in _PLANES:
        raise UnknownName("plane", plane, _PLANES)
    a, b, across = _PLANES[plane]
    p, w = _slice(arm, across, at, thickness, samples, np.random.default_rng(seed))
    if p.shape[0] == 0:
        raise OutOfLimits(f"no configuration brings the tool to {'xyz'[across]} = {at:g} m; choose another plane")
    low, high = p[:, [a, b]].min(axis=0), p[:, [a, b]].max(axis=0)
    side = max(float((high - low).max()) / cells, 1e-9)
    shape = np.ceil((high - low) / side).astype(int) + 1
    best = np.full(tuple(shape), np.nan)
    i, j = ((p[:, [a, b]] - low) / side).astype(int).T
    np.fmax.at(best, (i, j), w)
    figure = new_figure(5.6, 5.0)
    axes = figure.add_subplot()
    edges = (low[0], low[0] + side * shape[0], low[1], low[1] + side * shape[1])
    picture = axes.imshow(best.T, origin="lower", extent=edges, cmap="viridis", interpolation="nearest")
    base = np.array(arm.model.base)[:3, 3]
    axes.plot(base[a], base[b], "s", color=COLORS[1], label="base")
    axes.set(xlabel=f"{plane[0]} (m)", ylabel=f"{plane[1]} (m)", aspect="equal",
             title=f"{arm.model.name}: tool point, {'xyz'[across]} = {at:g} m")  # fmt: skip
    axes.set_xlim(edges[0] - 4 * side, edges[1] + 4 * side)
    axes.set_ylim(edges[2] - 4 * side, edges[3] + 4 * side)
    axes.legend(loc="upper right", framealpha=0.9)
    figure.colorbar(picture, ax=axes, label="best manipulability", shrink=0.8)
    saved(figure, save)
    return figure


def draw_manipulability(
    arm: Arm, q: ArrayLike, *, joints: tuple[int, int] = (1, 2), samples: int = 121, save: str | Path | None = None
) -> Figure:
    """Map manipulability over two joints within their limits, the others as in `q` (n,); `q` is marked.

    `joints` counts from 0.

    Raises
    ------
    ShapeError, OutOfLimits, InputError, OutputError
    """
    row = configurations(arm, q)[-1]
    if len(set(joints)) != 2 or not all(0 <= k < arm.n for k in joints):
        raise OutOfLimits(f"joints {joints}: give two different numbers from 0 to {arm.n - 1}")
    low, high = _ranges(arm)
    x, y = (np.linspace(low[k], high[k], samples) for k in joints)
    grid = np.broadcast_to(row, (samples, samples, arm.n)).copy()
    grid[..., joints[0]], grid[..., joints[1]] = np.meshgrid(x, y)
    figure = new_figure(5.6, 4.6)
    axes = figure.add_subplot()
    filled = axes.contourf(x, y, manipulability(arm, grid), levels=24, cmap="viridis")
    axes.plot(row[joints[0]], row[joints[1]], "o", color="white", markeredgecolor="black", label="q")
    names = arm.limits.names
    units = [joint.unit for joint in (arm.model.joints[i] for i in arm.model.independent)]
    axes.set(xlabel=f"{names[joints[0]]} ({units[joints[0]]})", ylabel=f"{names[joints[1]]} ({units[joints[1]]})",
             title=f"{arm.model.name}: manipulability")  # fmt: skip
    axes.legend(loc="upper right", framealpha=0.9)
    figure.colorbar(filled, ax=axes)
    saved(figure, save)
    return figure


def _ranges(arm: Arm) -> tuple[Array, Array]:
    """Position limits (n,) each; half a turn either way for revolute joints without any."""
    limits = arm.limits
    turns = np.array([arm.model.joints[i].turns for i in arm.model.independent])
    for name, low, high, turn in zip(limits.names, limits.lower, limits.upper, turns, strict=True):
        if not turn and not np.isfinite(low + high):
            raise InputError(f"joint {name!r} slides without limits; give it some to draw its range")
    low = np.where(turns & np.isinf(limits.lower), -np.pi, limits.lower)
    return low, np.where(turns & np.isinf(limits.upper), np.pi, limits.upper)


def _slice(
    arm: Arm, across: int, at: float, thickness: float, samples: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Tool points (k, 3) within the slice and the manipulability of the configurations that led there."""
    low, high = _ranges(arm)
    points, values = [], []
    for first in range(0, samples, _BATCH):
        q = rng.uniform(low, high, (min(_BATCH, samples - first), arm.n))
        p = arm.fk(q)[:, :3, 3]
        near = np.abs(p[:, across] - at) <= 0.5 * thickness
        points.append(p[near])
        values.append(np.asarray(manipulability(arm, q[near])) if near.any() else np.empty(0))
    return np.concatenate(points), np.concatenate(values)
