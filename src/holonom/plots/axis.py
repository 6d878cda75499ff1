"""Figures of a servo axis: Bode plots of its loops, a step, a move, the torque-speed plane, spread over tolerances."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from holonom.arrays import Array
from holonom.plots.figure import COLORS, new_figure, saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_bode", "draw_spread", "draw_steps", "draw_torque_speed"]


def draw_bode(
    loops: Mapping[str, tuple[Array, Array]], crossovers: Mapping[str, float], *, save: str | Path | None = None
) -> Figure:
    """Draw open loops by name: frequencies (n,), rad/s, and complex responses; crossovers are marked.

    Raises
    ------
    MissingExtra, OutputError
    """
    figure = new_figure(8.0, 5.6)
    size, phase = figure.subplots(2, 1, sharex=True)
    for k, (name, (w, L)) in enumerate(loops.items()):
        f, angle = w / (2.0 * np.pi), np.degrees(np.unwrap(np.angle(L)))
        angle -= 360.0 * round((angle[0] + 90.0) / 360.0)
        size.semilogx(f, 20.0 * np.log10(np.abs(L)), color=COLORS[k], label=name)
        phase.semilogx(f, np.maximum(angle, -270.0), color=COLORS[k])
        cross = crossovers[name] / (2.0 * np.pi)
        phase.plot([cross], [np.interp(np.log(cross), np.log(f), angle)], "o", color=COLORS[k])
    size.axhline(0.0, color="0.5", lw=0.8)
    phase.axhline(-180.0, color="0.5", lw=0.8)
    size.set_ylim(-60.0, 60.0)
    phase.set_ylim(-275.0, -60.0)
    size.set_ylabel("size (dB)")
    phase.set_ylabel("phase (deg)")
    phase.set_xlabel("frequency (Hz)")
    size.legend()
    for axes in (size, phase):
        axes.grid(alpha=0.3, which="both")
    saved(figure, save)
    return figure


def draw_steps(time: Array, rows: Mapping[str, Mapping[str, Array]], *, save: str | Path | None = None) -> Figure:
    """Draw signals over time (n,), s: one axis a unit, each with its curves by name.

    Raises
    ------
    MissingExtra, OutputError
    """
    figure = new_figure(8.0, 1.7 * len(rows) + 0.5)
    axes = np.atleast_1d(figure.subplots(len(rows), 1, sharex=True))
    for one, (unit, curves) in zip(axes, rows.items(), strict=True):
        for k, (name, values) in enumerate(curves.items()):
            one.plot(time, values, color=COLORS[k], label=name, lw=1.2)
        one.set_ylabel(unit)
        one.grid(alpha=0.3)
        if len(curves) > 1:
            one.legend(loc="upper right")
    axes[-1].set_xlabel("time (s)")
    saved(figure, save)
    return figure


def draw_torque_speed(
    speed: Array, peak: Array, lasting: Array | None, cycle: tuple[Array, Array], *, save: str | Path | None = None
) -> Figure:
    """Draw the plane of a motor: greatest torque (n,), N m, over speed (n,), rad/s; what it bears for ever; a cycle.

    Raises
    ------
    MissingExtra, OutputError
    """
    figure = new_figure(6.5, 4.6)
    axes = figure.subplots()
    axes.fill_between(speed, -peak, peak, color=COLORS[5], alpha=0.2, label="for a short time")
    if lasting is not None:
        axes.fill_between(speed, -lasting, lasting, color=COLORS[2], alpha=0.25, label="for ever")
    axes.plot(*cycle, color=COLORS[1], lw=1.0, label="the move")
    axes.set_xlabel("speed of the motor (rad/s)")
    axes.set_ylabel("torque of the motor (N m)")
    axes.grid(alpha=0.3)
    axes.legend(loc="upper right")
    saved(figure, save)
    return figure


def draw_spread(values: Mapping[str, Array], *, save: str | Path | None = None) -> Figure:
    """Draw how numbers (k,) spread, each by its name in a histogram.

    Raises
    ------
    MissingExtra, OutputError
    """
    figure = new_figure(2.8 * len(values), 2.6)
    for one, (name, found) in zip(np.atleast_1d(figure.subplots(1, len(values))), values.items(), strict=True):
        one.hist(found, bins=15, color=COLORS[0])
        one.set_xlabel(name)
        one.set_yticks([])
    saved(figure, save)
    return figure
