"""What a base says when it refuses: a dragged wheel, steering beyond its range, speeds that leave the twist open."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.errors import InputError, OutOfLimits
from holonom.mobile.base.protocol import ConstrainedBase

__all__ = ["beyond_steering", "dragged_wheel", "no_constant", "undetermined"]


def dragged_wheel(base: ConstrainedBase, twist: ArrayLike, steering: ArrayLike | None, drag: Array) -> OutOfLimits:
    """Name the wheel that is dragged fastest, given how fast any is (..., columns), m/s."""
    worst = np.abs(drag).max(axis=-1)
    row = np.unravel_index(int(worst.argmax()), worst.shape)
    at = base.steering(twist) if steering is None else vectors("steering", steering, len(base.steered))
    xi = np.broadcast_to(vectors("twist", twist, 3), (*worst.shape, 3))[row]
    speeds = np.abs(base.sliding_matrix(np.broadcast_to(at, (*worst.shape, at.shape[-1]))[row]) @ xi)
    wheel = int(np.argmax(speeds > (1.0 - 1e-9) * speeds.max()))  # the first of those on one axle
    place = f" in row {tuple(int(k) for k in row)}" if row else ""
    return OutOfLimits(
        f"twist ({', '.join(f'{v:.6g}' for v in xi)}){place} would drag wheel {base.sliding_names[wheel]!r} "
        f"sideways at {speeds[wheel]:.4g} m/s; base.feasible(twist) gives the nearest that drags none"
    )


def beyond_steering(base: ConstrainedBase, steering: Array, limits: list[float]) -> OutOfLimits | None:
    """Name the first steering angle (..., k) that exceeds its limit, rad; None if none does."""
    for k, (limit, name) in enumerate(zip(limits, base.steered, strict=True)):
        if limit < math.pi / 2 and (most := np.abs(steering[..., k]).max(initial=0.0)) > limit + 1e-9:
            return OutOfLimits(
                f"{name!r} would have to steer {most:.4g} rad; its max_steering is "
                f"{limit:.4g} rad: ask for a wider turn"
            )
    return None


def no_constant(base: ConstrainedBase) -> InputError:
    """Say that a base that steers has no constant coupling."""
    return InputError(
        f"base {base.name!r} steers ({', '.join(base.steered)}): its coupling is no constant; "
        "rolling_matrix(steering) holds the rows"
    )


def undetermined(base: ConstrainedBase) -> InputError:
    """Say that the driven speeds leave the twist open."""
    return InputError(
        f"speeds of {', '.join(base.driven)} do not determine the twist of base {base.name!r}"
        f"{' at this steering' if base.steered else ''}; drive or constrain it with another wheel"
    )
