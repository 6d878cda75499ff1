"""Curves of a motion beside its limits."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from holonom.errors import ShapeError
from holonom.mechanics.motion import JointLimits, Trajectory
from holonom.plots.figure import COLORS, new_figure, saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_profiles"]


def draw_profiles(
    motion: Trajectory,
    limits: JointLimits | None = None,
    *,
    names: Sequence[str] | None = None,
    save: str | Path | None = None,
) -> Figure:
    """Draw positions, speeds and accelerations of all joints over time.

    With `limits`, speeds and accelerations are drawn as shares of them, the limits as dashed lines at 1 and -1.

    Raises
    ------
    ShapeError, InputError, OutputError
    """
    n = motion.q.shape[1]
    labels = [f"joint {k + 1}" for k in range(n)] if names is None else list(names)
    if len(labels) != n:
        raise ShapeError(f"{len(labels)} names for {n} joints; give one each")
    rows = [(motion.q, "position (rad, m)"), (motion.qd, "speed (1/s)"), (motion.qdd, "acceleration (1/s²)")]
    if limits is not None:
        rows[1:] = [(motion.qd / limits.speed, "speed / limit"), (motion.qdd / limits.acceleration, "acc. / limit")]
    figure = new_figure(7.0, 6.0)
    time = motion.dt * np.arange(motion.q.shape[0])
    all_axes = figure.subplots(3, 1, sharex=True)
    for k, (axes, (values, label)) in enumerate(zip(all_axes, rows, strict=True)):
        for j in range(n):
            axes.plot(time, values[:, j], color=COLORS[j % len(COLORS)], linewidth=1.4, label=labels[j])
        if limits is not None and k > 0:
            for bound in (-1.0, 1.0):
                axes.axhline(bound, color="0.3", linestyle="--", linewidth=0.9)
            axes.set_ylim(-1.15, 1.15)
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    all_axes[-1].set_xlabel("time (s)")
    figure.align_ylabels(all_axes)
    handles, texts = all_axes[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside upper center", ncols=min(n, 6), frameon=False, fontsize=9)
    saved(figure, save)
    return figure
