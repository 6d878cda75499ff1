"""Curves over time in the report: what they hold, and those of a recorded arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from holonom.app.recording import Recording

__all__ = ["Curve", "curves_html", "joint_curves"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Curve:
    """One plot: `values` (N, k) in `unit` over `time` (N,) in s, a name for each of the k lines; `key` is unique."""

    key: str
    title: str
    unit: str
    time: Array
    values: Array
    names: tuple[str, ...]


def joint_curves(recording: Recording) -> tuple[Curve, ...]:
    """Joint positions, their errors, motor currents and voltages; without those that were not recorded."""
    joints, reference, drives = recording.joints, recording.reference, recording.drives
    names = recording.joint_names
    curves = [Curve("position", "Joint position", "°", joints.time, np.degrees(joints.position), names)]
    if len(reference.time):
        wanted = [np.interp(joints.time, reference.time, column) for column in reference.position.T]
        error = 1e3 * (np.stack(wanted, axis=1) - joints.position)
        curves.append(Curve("error", "Tracking error, reference − measured", "mrad", joints.time, error, names))
    curves.append(Curve("current", "Motor current", "A", drives.time, drives.current, names))
    curves.append(Curve("voltage", "Motor voltage", "V", drives.time, drives.voltage, names))
    return tuple(curve for curve in curves if len(curve.time))


def curves_html(curves: Sequence[Curve]) -> str:
    """Places for the plots, which the script fills."""
    if not curves:
        return ""
    places = "".join(f'<div class="plot" data-curve="{escape(curve.key)}"></div>' for curve in curves)
    note = "Click to move the replay there; drag to zoom, double click to zoom out; click a name to hide its curve."
    return (
        f'<section id="curves" class="card"><h2>Curves</h2><p class="note">{note}</p><div class="plots">{places}</div>'
        "</section>"
    )
