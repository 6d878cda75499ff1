"""Drives in polar plots (effective motors, acceleration, speed), and slip over time (specification 06.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array
from holonom.errors import InputError, ShapeError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.coupling import Coupling, coupling_of
from holonom.mobile.drive.envelopes import Envelope, Limit, effective_motors
from holonom.mobile.drive.failed_motor import motors_hold_all
from holonom.mobile.drive.slip import SlipReport, SlipStatus
from holonom.plots.figure import COLORS, new_figure, saved

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_effective_motors", "draw_envelopes", "draw_slip"]

_AROUND = np.linspace(0.0, 2.0 * np.pi, 721)


def draw_effective_motors(
    base: WheelBase | Coupling | ArrayLike, *, out: Sequence[int] = (), names: Sequence[str] | None = None,
    save: str | Path | None = None,
) -> Figure:  # fmt: skip
    """Draw the effective number of motors by direction; with `out`, also without those motors.

    Forwards (x of base_link) is up, left is left. Short lines show where each wheel drives. Wheels are called by their
    names in the base, or numbered from 1. Where motors that are left cannot push the base every way without turning it,
    their line is left out, and the legend says so.

    Raises
    ------
    ShapeError, OutOfLimits, InputError, OutputError
    """
    coupling = coupling_of(base)
    called = _called(names or (base.driven if isinstance(base, WheelBase) else None), coupling.wheels)
    figure, axes = _polar(5.2)
    curves = {"all motors": effective_motors(coupling, _AROUND)}
    if out:
        value = effective_motors(coupling, _AROUND, out=out)
        gone = "without " + " and ".join(called[i] for i in out)
        if motors_hold_all(coupling, sum(1 << i for i in set(out))):
            curves[gone] = value
        else:
            curves[f"{gone}: cannot hold its heading, not drawn"] = np.full_like(value, np.nan)
    for k, (name, value) in enumerate(curves.items()):
        axes.plot(_AROUND, value, color=COLORS[k], label=name)
        axes.fill(_AROUND, value, color=COLORS[k], alpha=0.12)
    top = 1.12 * float(curves["all motors"].max())
    for i, row in enumerate(coupling.velocity):
        angle = float(np.arctan2(row[1], row[0]))
        color = "0.75" if i in out else "0.35"
        axes.plot([angle, angle], [0.9 * top, top], color=color, linewidth=3.0, solid_capstyle="butt")
        axes.annotate(called[i], (angle, 0.83 * top), color=color, ha="center", va="center", fontsize=8)
    axes.set_ylim(0.0, top)
    axes.set_title("effective motors", fontsize=11, pad=22)
    axes.legend(loc="upper left", bbox_to_anchor=(-0.12, -0.03), fontsize=9, frameon=False)
    saved(figure, save)
    return figure


def draw_envelopes(
    envelopes: Mapping[str, Envelope], *, title: str = "", unit: str = "", save: str | Path | None = None
) -> Figure:
    """Draw envelopes in one polar plot, forwards up; dashed where the floor binds some wheel, not only motors.

    Raises
    ------
    InputError, OutputError
    """
    if not envelopes:
        raise InputError("draw_envelopes: no envelope is given; name one at least")
    figure, axes = _polar(5.2)
    for k, (name, envelope) in enumerate(envelopes.items()):
        order = np.argsort(envelope.directions)
        phi, value = envelope.directions[order], np.where(envelope.reachable, envelope.value, np.nan)[order]
        floor = (envelope.limits[order] == Limit.FRICTION).any(axis=1)
        for part, style, label in ((~floor, "-", name), (floor, "--", f"{name}, floor binds")):
            if part.any():
                axes.plot(
                    phi, np.where(_widened(part), value, np.nan), style, color=COLORS[k % len(COLORS)], label=label
                )
    axes.set_ylim(bottom=0.0)
    axes.set_title(f"{title} ({unit})" if unit else title, fontsize=11, pad=14)
    axes.legend(loc="upper left", bbox_to_anchor=(-0.12, -0.03), fontsize=9, frameon=False)
    saved(figure, save)
    return figure


def draw_slip(
    time: ArrayLike, report: SlipReport, *, names: Sequence[str] | None = None, save: str | Path | None = None
) -> Figure:
    """Draw the residual of each wheel over time (N,), s, its square sum beside the bound, and what was said.

    Raises
    ------
    ShapeError, InputError, OutputError
    """
    t = np.asarray(time, float)
    n = report.residual.shape[1]
    if t.shape != (len(report.status),):
        raise ShapeError(f"time has shape {t.shape}; it must be ({len(report.status)},), one per sample of the report")
    called = _called(names, n)
    figure = new_figure(8.0, 6.0)
    rows: Any = figure.subplots(3, 1, sharex=True, gridspec_kw={"height_ratios": (3, 2, 0.35 + 0.28 * n)})
    for i in range(n):
        rows[0].plot(t, report.residual[:, i], color=COLORS[i % len(COLORS)], linewidth=0.8, label=called[i])
    rows[0].set_ylabel("residual (m/s)")
    figure.legend(*rows[0].get_legend_handles_labels(), loc="outside upper center", ncols=min(n, 6), frameon=False)
    rows[1].semilogy(t, np.maximum(report.statistic, 1e-3), color="0.3", linewidth=0.8)
    rows[1].axhline(report.threshold, color=COLORS[1], linestyle="--", label="bound of noise")
    rows[1].set_ylabel("square sum\n(of noise)")
    rows[1].legend(loc="upper right", fontsize=8)
    _said(rows[2], t, report, called)
    rows[2].set_xlabel("time (s)")
    saved(figure, save)
    return figure


def _said(axes: Any, t: Array, report: SlipReport, called: Sequence[str]) -> None:
    """One line per wheel: named (full), candidate (pale)."""
    unsure = report.status == SlipStatus.AMBIGUOUS
    for i in range(len(called)):
        color = COLORS[i % len(COLORS)]
        axes.fill_between(
            t, i - 0.4, i + 0.4, where=report.candidates[:, i] & unsure, color=color, alpha=0.25, linewidth=0
        )
        axes.fill_between(t, i - 0.4, i + 0.4, where=report.named[:, i], color=color, linewidth=0)
    axes.set_yticks(range(len(called)), called, fontsize=8)
    axes.set_ylim(len(called) - 0.4, -0.6)
    axes.set_title("slips (full), may slip (pale)", fontsize=9, loc="left")


def _called(names: Sequence[str] | None, n: int) -> list[str]:
    """Names of n wheels; numbered from 1 where there are none, as `WheelBase` does."""
    called = [f"wheel {i + 1}" for i in range(n)] if names is None else list(names)
    if len(called) != n:
        raise ShapeError(f"{len(called)} names for {n} wheels; give one each")
    return called


def _polar(size: float) -> tuple[Figure, Any]:
    figure = new_figure(size, size)
    axes: Any = figure.add_subplot(projection="polar")
    axes.set_theta_zero_location("N")
    axes.tick_params(labelsize=8)
    return figure, axes


def _widened(part: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The part and one sample after it, so that the line has no gap."""
    wide = part.copy()
    wide[1:] |= part[:-1]
    return wide
