"""Paths of odometry beside the truth, before and after calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from holonom.arrays import Array
from holonom.errors import ShapeError
from holonom.plots.figure import COLORS, new_figure, saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_odometry"]


SIDE, MOST = 3.2, 4  # inches of a panel, panels in a row


def draw_odometry(
    truth: Sequence[Array], paths: Mapping[str, Sequence[Array]], *, names: Sequence[str] = (),
    save: str | Path | None = None,
) -> Figure:  # fmt: skip
    """Draw each run in a panel of its own: the truth, and what odometry made of it.

    Parameters
    ----------
    truth
        (N, 3) or (N, 2) of each run, x and y in m.
    paths
        For each way of odometry, by its name ("nominal", "calibrated"), the path of each run.
    names
        Of the runs, over the panels.
    save
        File to write too.

    Raises
    ------
    ShapeError, InputError, OutputError
    """
    if not truth or any(len(group) != len(truth) for group in paths.values()):
        raise ShapeError(
            f"{len(truth)} true paths came; give one or more, and as many of {', '.join(paths) or 'others'}"
        )
    across = min(MOST, len(truth))
    down = -(-len(truth) // across)
    figure = new_figure(SIDE * across + 0.4, SIDE * down + 0.5)
    grid = figure.subplots(down, across, squeeze=False)
    for k, axes in enumerate(grid.flat):
        if k >= len(truth):
            axes.set_axis_off()
            continue
        _panel(axes, truth[k], {name: group[k] for name, group in paths.items()})
        axes.set_title(names[k] if names else f"run {k + 1}", fontsize=9)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    saved(figure, save)
    return figure


def _panel(axes: Any, truth: Array, paths: Mapping[str, Array]) -> None:
    axes.plot(truth[:, 0], truth[:, 1], color="#9AA5B1", linewidth=4.0, label="truth", solid_capstyle="round")
    for color, (name, path) in zip(COLORS[1:] + COLORS[:1], paths.items(), strict=False):
        axes.plot(path[:, 0], path[:, 1], color=color, linewidth=1.2, label=name)
        axes.plot(*path[-1, :2], "o", color=color, markersize=4)
    axes.plot(*truth[0, :2], "s", color="black", markersize=5, label="start")
    axes.plot(*truth[-1, :2], "o", color="#5B6770", markersize=6, zorder=1)
    axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axes.set_box_aspect(1.0)
    axes.set_adjustable("datalim")
    axes.margins(0.08)
