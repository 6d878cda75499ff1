"""Velocity and force ellipsoids at the tool of an arm (Siciliano 3.9)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mechanics import Arm
from holonom.mechanics.analysis import Ellipsoid, force_ellipsoid, velocity_ellipsoid
from holonom.plots.arm import draw_sticks, room
from holonom.plots.figure import COLORS, new_figure, saved
from holonom.plots.skeleton import configurations, reach, sticks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_ellipsoids"]

_LONGEST = 20.0  # a force radius beyond this many times the shortest is drawn that long


def draw_ellipsoids(
    arm: Arm, q: ArrayLike, *, part: Literal["translation", "rotation"] = "translation",
    view: tuple[float, float] = (22.0, -55.0), save: str | Path | None = None,
) -> Figure:  # fmt: skip
    """Draw the arm twice, with its velocity and with its force ellipsoid at the tool.

    Each is scaled to half the arm's size; the true radii stand in the titles. Their axes are the same: where the arm
    is fast it is weak.

    Raises
    ------
    ShapeError, InputError, OutputError
    """
    row = configurations(arm, q)[-1]
    T = arm.frames(row)
    lines = sticks(arm, T)
    center, half = reach(lines)
    unit = ("m/s", "N") if part == "translation" else ("rad/s", "N m")
    figure = new_figure(9.0, 4.8)
    both = (
        ("velocity", velocity_ellipsoid(arm, row, part), COLORS[0]),
        ("force", force_ellipsoid(arm, row, part), COLORS[1]),
    )
    for k, (name, ellipsoid, color) in enumerate(both):
        axes: Any = figure.add_subplot(1, 2, k + 1, projection="3d")
        draw_sticks(axes, lines)
        radii = (
            np.minimum(ellipsoid.radii, _LONGEST * float(ellipsoid.radii.min())) if name == "force" else ellipsoid.radii
        )
        surface = T[-1, :3, 3] + 0.5 * half / max(float(radii.max()), 1e-12) * _surface(ellipsoid, radii)
        axes.plot_surface(*np.moveaxis(surface, -1, 0), color=color, alpha=0.25, linewidth=0)
        axes.plot_wireframe(*np.moveaxis(surface, -1, 0), color=color, linewidth=0.5, rstride=6, cstride=6)
        room(axes, center, 1.25 * half, view)
        axes.set_title(f"{name}: {', '.join(f'{r:.3g}' for r in ellipsoid.radii)} {unit[k]}", fontsize=10, y=0.97)
    saved(figure, save)
    return figure


def _surface(ellipsoid: Ellipsoid, radii: Array) -> Array:
    """Points (37, 37, 3) of the ellipsoid about the origin."""
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 37), np.linspace(0.0, np.pi, 37))
    sphere = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    surface: Array = (sphere * radii) @ ellipsoid.axes.T
    return surface
