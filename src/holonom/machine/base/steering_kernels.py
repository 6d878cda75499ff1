"""Steered wheels as a controller sees them: rows at the measured angles, angles to ask for, shares of force."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.devices.drive_signals import WheelSignals
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH

__all__ = ["SteeredParams", "bend", "look_at_wheels", "share_along", "steer"]

STILL = 1e-3  # m/s of a contact, below which a wheel is not steered
Integers = NDArray[np.int64]
Records = NDArray[np.void]


class SteeredParams(NamedTuple):
    """Wheels of a base that steers: n wheels, q of them steered; m driven rows, s directions in which none slides."""

    places: Array  # (n, 3) x, y, m, and heading at rest, rad
    limits: Array  # (n,) rad to either side; infinite: all around
    lanes: Integers  # (n,) where in the signals a steered wheel is; -1: it is not steered
    driven: Integers  # (m,) wheel of each driven row
    sliding: Integers  # (s,) wheel of each direction without sliding
    curvature: float  # 1/m of the tightest curve
    ahead: float  # s by which set-points look ahead: the lag of the steering motors


@loop(error_model="numpy")
def look_at_wheels(
    params: SteeredParams, signals: WheelSignals, rows: Array, estimate_rows: Array, wheels: Records
) -> None:
    """Fill the rows (m, 3) and (m + s, 3) of the constraints at the measured angles."""
    m = len(params.driven)
    for i in range(m):
        x, y, s, c = _stance(params, signals, params.driven[i])
        rows[i, 0], rows[i, 1], rows[i, 2] = c, s, x * s - y * c
        wheel, lane = wheels[i // WIDTH], i % WIDTH
        wheel.rim_x[lane], wheel.rim_y[lane], wheel.rim_turn[lane] = rows[i, 0], rows[i, 1], rows[i, 2]
        estimate_rows[i] = rows[i]
    for j in range(len(params.sliding)):
        x, y, s, c = _stance(params, signals, params.sliding[j])
        estimate_rows[m + j, 0], estimate_rows[m + j, 1], estimate_rows[m + j, 2] = -s, c, x * c + y * s


@loop(error_model="numpy", forceinline=True)
def _stance(params: SteeredParams, signals: WheelSignals, wheel: int) -> tuple[float, float, float, float]:
    """Place of a wheel, and sine and cosine of its heading."""
    lane = params.lanes[wheel]
    heading = params.places[wheel, 2]
    if lane >= 0:
        heading += signals.turned[lane]
    s, c = sincos(heading)
    return params.places[wheel, 0], params.places[wheel, 1], s, c


@loop(error_model="numpy")
def bend(params: SteeredParams, command: Planar) -> Planar:
    """The command on the tightest curve where it asks for a tighter one."""
    most = params.curvature * math.sqrt(command.x * command.x + command.y * command.y)
    return Planar(command.x, command.y, min(max(command.turn, -most), most))


@loop(error_model="numpy")
def steer(params: SteeredParams, twist: Planar, signals: WheelSignals) -> None:
    """Ask for the angles at which the wheels roll with a twist, nearest modulo half a turn to those asked for last."""
    for i in range(len(params.lanes)):
        lane = params.lanes[i]
        if lane < 0:
            continue
        vx, vy = twist.x - twist.turn * params.places[i, 1], twist.y + twist.turn * params.places[i, 0]
        if vx * vx + vy * vy < STILL * STILL:
            continue
        angle, limit = math.atan2(vy, vx) - params.places[i, 2], params.limits[i]
        near = signals.steering[lane] if limit > math.pi else 0.0
        angle -= math.pi * math.floor((angle - near) / math.pi + 0.5)
        signals.steering[lane] = min(max(angle, -limit), limit)


@loop(error_model="numpy")
def share_along(rows: Array, weights: Array, twist: Planar, states: Records) -> None:
    """Share force on the base among the wheels so that it does the work that it does along a twist.

    `f_i = g_i d_i (xi . F) / sum g d^2` with d the rims' speeds at the twist xi: at given angles a base moves one way.
    """
    square = 0.0
    for i in range(len(rows)):
        d = rows[i, 0] * twist.x + rows[i, 1] * twist.y + rows[i, 2] * twist.turn
        square += weights[i] * d * d
    if square < STILL * STILL:
        return
    for i in range(len(rows)):
        own, lane = states[i // WIDTH], i % WIDTH
        part = weights[i] * (rows[i, 0] * twist.x + rows[i, 1] * twist.y + rows[i, 2] * twist.turn) / square
        own.force_x[lane], own.force_y[lane], own.force_turn[lane] = (
            part * twist.x, part * twist.y, part * twist.turn
        )  # fmt: skip
