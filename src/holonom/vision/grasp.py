"""From which side a two-finger gripper takes a disc among its neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["grasp_angles"]

DIRECTIONS = 36
"""Closing directions tried over half a turn."""


def grasp_angles(
    centres: ArrayLike,
    diameters: ArrayLike,
    *,
    opening: float,
    finger: tuple[float, float],
    preferred: float,
    clearance: float,
) -> NDArray[np.float64]:
    """Closing direction for each disc that leaves the open fingers room beside its neighbours.

    Parameters
    ----------
    centres, diameters
        Discs in the table plane, (k, 2) and (k,), m.
    opening
        Distance of the open fingers' inner faces, m.
    finger
        A finger's width (across the closing direction) and thickness (along it), m.
    preferred
        Closing direction (rad) to be kept to where a disc leaves `clearance` (m) around the fingers there.

    Returns
    -------
    Angles (k,) in rad from the plane's x axis, within a quarter turn of `preferred`: the nearest to it with enough
    clearance, or the one with the most.
    """
    places, radii = np.asarray(centres, dtype=float).reshape(-1, 2), np.asarray(diameters, dtype=float) / 2
    offsets = np.pi * (np.arange(DIRECTIONS) / DIRECTIONS - 0.5)
    offsets = offsets[np.argsort(np.abs(offsets), kind="stable")]
    angles = np.empty(len(places))
    for k in range(len(places)):
        others = np.arange(len(places)) != k
        room = [_room(places[others] - places[k], radii[others], preferred + turn, opening, finger) for turn in offsets]
        enough = np.flatnonzero(np.array(room) >= clearance)
        angles[k] = preferred + offsets[enough[0] if enough.size else int(np.argmax(room))]
    return angles


def _room(
    centres: NDArray[np.float64],
    radii: NDArray[np.float64],
    angle: float,
    opening: float,
    finger: tuple[float, float],
) -> float:
    """Smallest gap between either open finger and any neighbour, m; infinite without neighbours."""
    c, s = np.cos(angle), np.sin(angle)
    along, across = centres @ [c, s], centres @ [-s, c]
    width, thickness = finger
    beside = np.maximum(np.abs(across) - width / 2, 0.0)
    gaps = [
        np.hypot(beside, np.maximum(np.abs(along - side * (opening + thickness) / 2) - thickness / 2, 0.0)) - radii
        for side in (-1.0, 1.0)
    ]
    return float(np.min(gaps, initial=np.inf))
