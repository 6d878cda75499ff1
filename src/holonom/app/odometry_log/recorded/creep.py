"""What gripping wheels creep, taken off a recording as the controller takes it off: by currents and accelerations.

Left in, it would be taken for geometry: rims run ahead of the floor by as much as they push, inner and outer wheels of
a curve, front and rear ones differently, and always alike, so that no repetition shows it.
"""

from __future__ import annotations

import numpy as np

from holonom.app.recording import Recording
from holonom.app.recording.robot import BaseDescription, WheelCreep
from holonom.arrays import Array
from holonom.mobile import WheelBase
from holonom.mobile.base.drivable import skids

__all__ = ["known_creep", "unknown_share"]

HALF = 0.5
"""As much again of the slip, with all the grip; as the controller has it (`machine.base.wheel_kernels.creep`)."""

ROLLERS = 1.0
OTHERS = 0.3
"""Standard deviations of known creep as a share of it: rollers take current for their own turning, too."""


def unknown_share(base: BaseDescription) -> float:
    """By how much what is known of its creep may be wrong, as a share of it."""
    rolls = base.base is not None and any(wheel.kind == "swedish" for wheel in base.base.wheels)
    return ROLLERS if rolls else OTHERS


def known_creep(recording: Recording, base: BaseDescription, turns: Array, steering: Array) -> tuple[Array, Array]:
    """How far wheels crept in each sample, (N, m) rad, and how far the base drifted as wheels crept across, (N, 3).

    None (0 rows) where a recording does not say what is known of its wheels, or these skid, which is no creep.
    """
    count, none = len(turns), (np.empty((0, turns.shape[1])), np.empty((0, 3)))
    current, felt = recording.tracks.get("/measured/motor_current"), recording.tracks.get("/imu")
    known, wheels = base.creep, base.base
    if known is None or wheels is None or current is None or felt is None:
        return none
    if skids(wheels.wheels) or min(len(current.time), len(felt.time)) < count:
        return none
    dt = np.diff(current.time[:count], prepend=current.time[0])[:, None]
    rims = _slip(known, current.fields["current"][:count]) / np.array(base.radii)
    drift = _drift(wheels, steering, known.across, felt.fields["acceleration"][:count])
    return dt * _halfway(rims), dt * _halfway(drift)


def _slip(known: WheelCreep, current: Array) -> Array:
    """Slip (N, m) of the rims, m/s, at currents, A."""
    part = np.clip(np.array(known.grip_per_ampere) * current, -1.0, 1.0)
    return np.asarray(np.array(known.full) * part * (1.0 + HALF * part * part))


def _drift(base: WheelBase, steering: Array, across: float, acceleration: Array) -> Array:
    """Twist (N, 3) of a base whose wheels roll nothing, and creep across against an acceleration (N, 2), m/s2."""
    still = base.sliding_matrix(steering if base.steered else None)
    driven = [name in base.driven for name in base.rolling_names]
    rolls = base.rolling_matrix(steering if base.steered else None)[..., driven, :]
    scale = np.array([1.0, 1.0, 1.0 / base.radius])
    rows = np.broadcast_to(
        np.concatenate([rolls, still], axis=-2) * scale, (len(acceleration), rolls.shape[-2] + still.shape[-2], 3)
    )
    creep = np.zeros(rows.shape[:2])
    creep[:, rolls.shape[-2] :] = -across * np.einsum("nki,ni->nk", rows[:, rolls.shape[-2] :, :2], acceleration)
    found = np.linalg.pinv(rows, rcond=1e-6) @ creep[..., None]
    return np.asarray(found[..., 0] * scale)


def _halfway(rates: Array) -> Array:
    """Means of rates (N, k) and those before them."""
    found = rates.copy()
    found[1:] = 0.5 * (rates[1:] + rates[:-1])
    return found
