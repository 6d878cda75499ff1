"""Motor patterns that do nothing: wheels that fight each other (null space of C_alpha; specification 06.2).

They make no force along any motion that the sliding rows leave free, whatever the mass distribution: `(D S)^T f = 0`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, is_finite, shown
from holonom.devices import DcMotor, Gear
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.coupling import Coupling, coupling_of

__all__ = ["PatternParts", "copper_loss", "idle_patterns", "readable_patterns", "split_pattern"]

_ZERO = 1e-9


@dataclass(frozen=True, slots=True)
class PatternParts:
    """A motor pattern (..., n) taken apart: `useful + fighting`, orthogonal to each other.

    `lost` (...) is the share of the square sum that fights, which is the share of the heat in equal motors; 0 for a
    pattern of zeros.
    """

    useful: Array
    fighting: Array
    lost: Array


def idle_patterns(base: WheelBase | Coupling | ArrayLike) -> Array:
    """Orthonormal patterns (n, n - rank) of wheel forces that neither push nor turn the base, one per column.

    The largest entry of each is positive. For four symmetric wheels it is (1, -1, 1, -1) / 2.
    """
    coupling = coupling_of(base)
    N: Array = scipy.linalg.null_space((coupling.velocity @ coupling.motions).T, rcond=_ZERO)
    return N * np.sign(np.take_along_axis(N, np.abs(N).argmax(axis=0, keepdims=True), axis=0))


def readable_patterns(base: WheelBase | Coupling | ArrayLike) -> Array:
    """The same patterns (n, n - rank) as a reader would write them: few wheels each, the largest force 1.

    Each column holds rank + 1 wheels at most: those that carry the motion and one that fights them. For four symmetric
    wheels it is (1, -1, 1, -1).
    """
    coupling = coupling_of(base)
    D = coupling.velocity @ coupling.motions
    n = len(D)
    _, R, order = scipy.linalg.qr(D.T, pivoting=True)
    rank = int((np.abs(np.diag(R)) > _ZERO * np.abs(R).max()).sum()) if R.any() else 0
    N = np.zeros((n, n - rank))
    N[order[rank:], np.arange(n - rank)] = 1.0
    N[order[:rank]] = -scipy.linalg.solve_triangular(R[:rank, :rank], R[:rank, rank:])
    N[np.abs(N) < _ZERO] = 0.0
    N /= np.abs(N).max(axis=0, initial=0.0)
    first = np.take_along_axis(N, (N != 0.0).argmax(axis=0)[None, :], axis=0)
    return N * np.sign(first)


def split_pattern(base: WheelBase | Coupling | ArrayLike, forces: ArrayLike) -> PatternParts:
    """Take wheel forces (..., n) apart into what moves the base and what only fights: `f = C^+ C f + (1 - C^+ C) f`.

    Raises
    ------
    ShapeError
    """
    N = idle_patterns(base)
    f = finite("forces", forces)
    if f.shape[-1:] != (len(N),):
        raise ShapeError(f"forces have shape {f.shape}; their last axis must be the {len(N)} wheels")
    fighting: Array = f @ N @ N.T
    whole = (f * f).sum(axis=-1)
    lost = np.divide((fighting * fighting).sum(axis=-1), whole, out=np.zeros_like(whole), where=whole > 0.0)
    return PatternParts(f - fighting, fighting, lost)


def copper_loss(forces: ArrayLike, motor: DcMotor, gear: Gear, wheel_radius: float) -> Array:
    """Heat (...), W, that wheel forces (..., n), N, cost in the windings: `R i^2`, `i = f r / (nu eta k_t)`.

    Heat of the useful and of the fighting part add up to the heat of the pattern.

    Raises
    ------
    OutOfLimits
    """
    if not (is_finite(wheel_radius) and wheel_radius > 0.0):
        raise OutOfLimits(f"wheel radius is {shown(wheel_radius)} m; it must be a finite number above 0")
    current = finite("forces", forces) * wheel_radius / (gear.ratio * gear.efficiency * motor.torque_constant)
    heat: Array = motor.resistance * (current * current).sum(axis=-1)
    return heat
