"""The body of an inverted pendulum as the plant takes it: on one axle, alike to both sides of its plane of pitch."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.errors import ModelError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive, base_mass
from holonom.sim.base.lean_kernels import LeanParams, leaning_terms

__all__ = ["FALLEN", "axle_of", "kinetic_energy", "lean_params"]

FALLEN = math.pi / 3.0
"""Pitch (rad) beyond which a body that balances has fallen."""
ALIKE = 1e-9  # part of a size by which wheels of one axle may differ


def axle_of(base: WheelBase) -> Array:
    """Place (2,) on the axle of a base that balances, beside its centre of mass, in base_link, m.

    Raises
    ------
    ModelError
        Wheels that are not driven, fixed and alike on one axle along y; a body with products of inertia that a pitch
        would turn it by.
    """
    wheels = base.wheels
    x, radius = np.array([w.x for w in wheels]), np.array([w.radius for w in wheels])
    plain = all(w.kind == "fixed" and w.driven and abs(math.sin(w.heading)) < ALIKE for w in wheels)
    if not plain or np.ptp(x) > ALIKE * radius.max() or np.ptp(radius) > ALIKE * radius.max():
        raise ModelError(
            f"base {base.name!r} balances its body; that takes driven fixed wheels alike on one axle along y"
        )
    size = float(np.trace(base.inertia))
    if max(abs(base.inertia[0, 1]), abs(base.inertia[1, 2])) > ALIKE * size:
        raise ModelError(
            f"base {base.name!r} balances its body, whose products of inertia xy and yz must be 0: "
            f"{base.inertia[0, 1]:g} and {base.inertia[1, 2]:g} kg m2 came"
        )
    return np.array([x.mean(), base.com[1]])


def lean_params(base: WheelBase, drive: BaseDrive, gravity: float) -> LeanParams:
    """Params of a body that balances, in gravity (m/s2) into the floor.

    Mass and inertia are of the whole base, upright; of its wheels only what turns about the axle is not in them.
    """
    J, axle = base.inertia, float(np.mean(base.wheel_radii))
    return LeanParams(
        mass=base_mass(base),
        ahead=float(base.com[0] - axle_of(base)[0]),
        rise=base.com_height - axle,
        axle=axle,
        roll=float(J[0, 0]),
        pitch=float(J[1, 1]) + len(base.driven) * drive.wheel_inertia,
        yaw=float(J[2, 2]),
        product=float(J[0, 2]),
        gravity=gravity,
        limit=FALLEN,
    )


def kinetic_energy(lean: LeanParams, state: Any, wheels: NDArray[np.void], states: NDArray[np.void]) -> float:
    """Kinetic energy (J) of a body that balances, its wheels and rotors."""
    t, rate, w = leaning_terms(lean, state), float(state["pitch_rate"]), float(state["w"])
    vx, vy = float(state["vx"]), float(state["vy"])
    body = lean.mass * (vx * vx + vy * vy + 2.0 * (t.up * vx * rate + t.ahead * vy * w))
    turning = wheels["inertia"] * states["speed"] ** 2 + 2.0 * wheels["coupled"] * states["speed"] * rate
    return float(0.5 * (body + t.turning * w * w + t.pitching * rate * rate + turning.sum()))
