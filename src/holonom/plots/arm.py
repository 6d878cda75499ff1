"""An arm as sticks with frames."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mechanics import Arm
from holonom.plots.figure import COLORS, new_figure, saved
from holonom.plots.skeleton import configurations, reach, sticks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_arm", "draw_sticks", "room"]

_AXES = ("#C0392B", "#27AE60", "#2471A3")  # x, y, z


def draw_arm(
    arm: Arm, q: ArrayLike, *, frames: bool = True, view: tuple[float, float] = (22.0, -55.0),
    save: str | Path | None = None,
) -> Figure:  # fmt: skip
    """Draw an arm in the room.

    Parameters
    ----------
    q
        (n,), or (k, n): the last one is drawn full, the others pale.
    frames
        Whether base and tool frame are drawn and named (x red, y green, z blue).
    view
        Elevation and azimuth of the eye, degrees.
    save
        File to write too.

    Raises
    ------
    ShapeError, InputError, OutputError
    """
    poses = arm.frames(configurations(arm, q))
    figure = new_figure(5.5, 5.0)
    axes: Any = figure.add_subplot(projection="3d")
    lines = [sticks(arm, T) for T in poses]
    for k, branches in enumerate(lines):
        last = k == len(lines) - 1
        draw_sticks(axes, branches, alpha=1.0 if last else 0.15 + 0.35 * k / len(lines))
    center, half = reach([line for branches in lines for line in branches])
    if frames:
        _frame(axes, poses[-1, 0], 0.3 * half, "base")
        _frame(axes, poses[-1, -1], 0.3 * half, "tool")
    room(axes, center, half, view)
    axes.set_title(arm.model.name, y=0.97)
    saved(figure, save)
    return figure


def draw_sticks(axes: Any, branches: list[Array], *, alpha: float = 1.0) -> None:
    """Links as lines, joints as dots."""
    for line in branches:
        axes.plot(*line.T, color="#34495E", linewidth=4.0, alpha=alpha, solid_capstyle="round")
        axes.plot(*line.T, "o", color=COLORS[4], markeredgecolor="#34495E", markersize=5.0, alpha=alpha)


def room(axes: Any, center: Array, half: float, view: tuple[float, float]) -> None:
    """A cube of the room with equal scales."""
    for name, middle in zip("xyz", center, strict=True):
        getattr(axes, f"set_{name}lim")(middle - half, middle + half)
        getattr(axes, f"set_{name}label")(f"{name} (m)", labelpad=6)
        getattr(axes, f"{name}axis").set_major_locator(_few())
    axes.set_box_aspect((1.0, 1.0, 1.0), zoom=0.86)
    axes.view_init(*view)


def _few() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)


def _frame(axes: Any, T: Array, length: float, name: str) -> None:
    for axis, color in zip(T[:3, :3].T, _AXES, strict=True):
        tip = T[:3, 3] + length * axis
        axes.plot(*np.stack([T[:3, 3], tip]).T, color=color, linewidth=2.0)
    box = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.0}
    place = T[:3, 3] - 0.7 * length * T[:3, :3].sum(axis=1)  # beside the frame, away from its three axes
    axes.text(*place, name, fontsize=9, bbox=box, ha="center", va="center")
