"""Curves over time in the report: what they hold, and those of a recorded arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.app.recording import Recording
from holonom.app.report.markup import Html, html, joined
from holonom.arrays import Array
from holonom.model.joint_kinds import kind_of

__all__ = ["Curve", "curves_html", "joint_curves"]

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Curve:
    """One plot: `values` (N, k) in `unit` over `time` (N,) in s, a name for each of the k lines; `key` is unique."""

    key: str
    title: str
    unit: str
    time: Array
    values: Array
    names: tuple[str, ...]


def joint_curves(
    recording: Recording, kinds: Sequence[str] = (), key: str = "", *, ideal: bool = False
) -> tuple[Curve, ...]:
    """Curves of the joints: positions, errors, motor currents and voltages; without those that were not recorded.

    Speeds and efforts stand in where nothing is known of the motors.

    Parameters
    ----------
    recording
        Of one robot.
    kinds
        "revolute" or "prismatic" for each joint; all revolute unless given.
    key
        Goes before the curves' keys.
    ideal
        Whether its drives are: no efforts are drawn then.
    """
    joints, drives, names = recording.joints, recording.drives, recording.joint_names
    known = kinds if len(kinds) == len(names) else ["revolute"] * len(names)
    slides = np.array([not kind_of(kind).turns for kind in known], dtype=bool)
    curves = _by_kind(f"{key}position", "Joint position", ("°", "mm"), joints.time, joints.position, names, slides)
    title = "Tracking error, reference − measured"
    curves += _by_kind(f"{key}error", title, ("mrad", "mm"), joints.time, _error(recording), names, slides)
    if not len(drives.time):
        curves.append(Curve(f"{key}velocity", "Joint speed", "rad/s or m/s", joints.time, joints.velocity, names))
    if not len(drives.time) and not ideal:
        curves.append(Curve(f"{key}effort", "Joint effort", "N m or N", joints.time, joints.effort, names))
    curves.append(Curve(f"{key}current", "Motor current", "A", drives.time, drives.current, names))
    curves.append(Curve(f"{key}voltage", "Motor voltage", "V", drives.time, drives.voltage, names))
    return tuple(curve for curve in curves if len(curve.time) and curve.values.shape[1])


def _by_kind(
    key: str, title: str, units: tuple[str, str], time: Array, values: Array, names: Sequence[str], slides: Mask
) -> list[Curve]:
    """One curve for joints that turn, one for those that slide."""
    factors = {"°": 180.0 / np.pi, "mrad": 1e3, "mm": 1e3}
    found = []
    for unit, which in zip(units, (~slides, slides), strict=True):
        if values.size and which.any():
            named = tuple(name for name, wanted in zip(names, which, strict=True) if wanted)
            own = key if unit == units[0] else f"{key}_slide"
            found.append(Curve(own, title, unit, time, factors[unit] * values[:, which], named))
    return found


def _error(recording: Recording) -> Array:
    """Reference less measured position (N, n), at the joints' times; nothing where there is no reference."""
    joints, reference = recording.joints, recording.reference
    if not len(reference.time):
        return np.empty((0, 0))
    wanted = [np.interp(joints.time, reference.time, column) for column in reference.position.T]
    return np.stack(wanted, axis=1) - joints.position


def curves_html(curves: Sequence[Curve], name: str, title: str) -> Html:
    """Places for the plots, which the script fills."""
    if not curves:
        return Html()
    places = joined(html('<div class="plot" data-curve="{}"></div>', curve.key) for curve in curves)
    note = "Click to move the replay there; drag to zoom, double click to zoom out; click a name to hide its curve."
    return html(
        '<section id="{}" class="card curves"><h2>{}</h2><p class="note">{}</p><div class="plots">{}</div></section>',
        name, title, note, places,
    )  # fmt: skip
