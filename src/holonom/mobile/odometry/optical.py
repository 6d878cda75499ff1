"""Optical odometry: mouse or flow sensors at known places under a base tell its increments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import CalibrationError, ModelError, ShapeError
from holonom.mobile.odometry.integrate import increments_of

__all__ = ["OpticalIncrements", "OpticalSensor", "calibrate_optical", "optical_increments"]


UNSEEN = 1e-6  # relative singular value below which the motion says nothing about a parameter


@dataclass(frozen=True, slots=True)
class OpticalSensor:
    """A sensor that looks at the floor.

    Attributes
    ----------
    x, y : place in the robot frame, m.
    angle : of its own x axis in the robot frame, rad.
    scale : m per count.
    """

    x: float
    y: float
    angle: float = 0.0
    scale: float = 1.0


@dataclass(frozen=True, slots=True)
class OpticalIncrements:
    """Increments of the base (N, 3), m and rad; `residual` (N, 2 s), m, is what no motion of a rigid base explains."""

    increments: Array
    residual: Array


def optical_increments(
    sensors: Sequence[OpticalSensor], counts: ArrayLike, turns: ArrayLike | None = None
) -> OpticalIncrements:
    """Increments of the base from what its optical sensors count, by least squares.

    Sensor i at p_i sees `scale R(angle)^T ((dx, dy) + dtheta (-y_i, x_i))`: one sensor gives two equations for three
    unknowns, and needs the turn from elsewhere; two or more at different places tell everything.

    Parameters
    ----------
    sensors : the sensors, with their places.
    counts : (N, s, 2)
        What each counted along its own x and y.
    turns : (N,)
        Turn of each sample from a gyro or wheels, rad; needed with one sensor, and believed as it is.

    Raises
    ------
    ModelError
        No sensor, or sensors at one place and no `turns`.
    ShapeError
    """
    if not sensors:
        raise ModelError("no optical sensor came; give one with turns, or two at different places")
    seen = np.asarray(counts, dtype=np.float64)
    if seen.ndim != 3 or seen.shape[1:] != (len(sensors), 2) or not np.all(np.isfinite(seen)):
        raise ShapeError(f"counts have shape {seen.shape}; give finite (samples, {len(sensors)}, 2)")
    A = np.concatenate([_rows(s) for s in sensors])
    floor = np.concatenate([_turned(s, seen[:, i]) for i, s in enumerate(sensors)], axis=1)
    if turns is not None:
        turn = np.asarray(turns, dtype=np.float64)
        if turn.shape != (len(seen),) or not np.all(np.isfinite(turn)):
            raise ShapeError(f"turns have shape {turn.shape}; give one finite number per sample, {len(seen)}")
        rest = floor - turn[:, None] * A[:, 2]
        found = np.column_stack([np.linalg.lstsq(A[:, :2], rest.T, rcond=None)[0].T, turn])
    elif np.linalg.matrix_rank(A) < 3:
        raise ModelError("the optical sensors stand at one place, which tells nothing of turns; give turns too")
    else:
        found = np.linalg.lstsq(A, floor.T, rcond=None)[0].T
    return OpticalIncrements(found, floor - found @ A.T)


def calibrate_optical(sensor: OpticalSensor, counts: ArrayLike, increments: ArrayLike) -> OpticalSensor:
    """Scale, angle and place of a sensor from counts beside known increments of the base.

    With `a = scale cos(angle)`, `b = scale sin(angle)` the problem is linear:
    `a cx - b cy = dx - dtheta y`, `b cx + a cy = dy + dtheta x`.

    Parameters
    ----------
    sensor : as it is believed to be; kept where the motion says nothing about its place.
    counts : (N, 2) of the sensor.
    increments : (N, 3) of the base, m and rad.

    Raises
    ------
    CalibrationError
        A motion that does not tell scale and angle: the sensor hardly moved.
    ShapeError
    """
    known, c = increments_of(increments), np.asarray(counts, dtype=np.float64)
    if c.shape != (len(known), 2) or not np.all(np.isfinite(c)):
        raise ShapeError(f"counts have shape {c.shape}; give finite ({len(known)}, 2)")
    turn = known[:, 2]
    zero = np.zeros_like(turn)
    A = np.concatenate([np.column_stack([c[:, 0], -c[:, 1], zero, turn]),
                        np.column_stack([c[:, 1], c[:, 0], -turn, zero])])  # fmt: skip
    b = np.concatenate([known[:, 0], known[:, 1]])
    if np.linalg.norm(c) == 0.0:
        raise CalibrationError("the sensor counted nothing; drive a metre and turn, over a floor that it sees")
    columns = [0, 1, 2, 3] if _tells_place(A) else [0, 1]
    held = np.array([0.0, 0.0, sensor.x, sensor.y])
    rest = b if len(columns) == 4 else b - A[:, 2:] @ held[2:]
    found = held.copy()
    found[columns] = np.linalg.lstsq(A[:, columns], rest, rcond=None)[0]
    scale = float(np.hypot(found[0], found[1]))
    if scale == 0.0:
        raise CalibrationError("the base did not move while the sensor counted; drive a metre and turn")
    return OpticalSensor(float(found[2]), float(found[3]), float(np.arctan2(found[1], found[0])), scale)


def _rows(sensor: OpticalSensor) -> Array:
    """(2, 3): way of the sensor's place per increment of the base."""
    return np.array([[1.0, 0.0, -sensor.y], [0.0, 1.0, sensor.x]])


def _turned(sensor: OpticalSensor, counts: Array) -> Array:
    """Counts (N, 2) as a way in the robot frame, m."""
    c, s = np.cos(sensor.angle), np.sin(sensor.angle)
    return sensor.scale * np.column_stack([c * counts[:, 0] - s * counts[:, 1], s * counts[:, 0] + c * counts[:, 1]])


def _tells_place(A: Array) -> bool:
    size = np.linalg.norm(A, axis=0)
    if np.any(size == 0.0):
        return False
    values = np.linalg.svd(A / size, compute_uv=False)
    return bool(values[-1] > UNSEEN * values[0])
