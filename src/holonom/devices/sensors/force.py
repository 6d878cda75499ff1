"""Six-axis force sensor: bias, noise, crosstalk, and the tool that hangs on it (spec 03.4).

Wrenches are [f; t] in the sensor's frame, N and N m: what acts on the sensor's tool side. A tool of mass m whose centre
of mass is at c (sensor frame) adds `f = m R^T g`, `t = c x f` at the orientation R of the sensor in the world.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array, vectors
from holonom.errors import CalibrationError, ModelError, NotAPose, ShapeError
from holonom.registry import check_fields, parameter

__all__ = ["Crosstalk", "ForceSensor", "ToolLoad", "fit_crosstalk", "fit_tool"]

Six = tuple[float, float, float, float, float, float]

IDENTITY: tuple[Six, ...] = tuple(tuple(float(i == k) for k in range(6)) for i in range(6))  # type: ignore[misc]
LEAST_SPREAD = 1e-3  # smallest over largest singular value of poses or loads that tell all unknowns
LARGEST_CONDITION = 1e6  # of a crosstalk matrix
LEAST_POSES, LEAST_LOADS = 4, 7
TOLD = 3.0  # standard deviations above which a mass is one


@dataclass(frozen=True, slots=True)
class ForceSensor:
    """A force and torque sensor: it reads `C w + b` and noise.

    Raises
    ------
    ModelError
        A number that is not finite, negative noise, a crosstalk matrix that is not 6 by 6 or hides a direction.
    """

    force_noise: float = parameter(0.1, meaning="standard deviation of a force", unit="N", least=0.0)
    torque_noise: float = parameter(5e-3, meaning="standard deviation of a torque", unit="N m", least=0.0)
    bias: Six = parameter((0.0,) * 6, meaning="readings without load, N and N m")
    crosstalk: tuple[Six, Six, Six, Six, Six, Six] = parameter(IDENTITY, meaning="C, readings of a unit wrench")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        condition = float(np.linalg.cond(self.matrix))
        if not condition < LARGEST_CONDITION:
            raise ModelError(
                f"ForceSensor: crosstalk has the condition number {condition:.3g}; it must be below "
                f"{LARGEST_CONDITION:g}, or some wrench is not read"
            )

    @property
    def matrix(self) -> Array:
        """C (6, 6)."""
        return np.array(self.crosstalk)

    def measure(self, wrench: ArrayLike, random: np.random.Generator) -> Array:
        """Return readings (..., 6) of true wrenches (..., 6), N and N m; noise is drawn from `random`.

        Raises
        ------
        ShapeError, NotFinite
        """
        truth = vectors("wrench", wrench, 6)
        noise = np.repeat([self.force_noise, self.torque_noise], 3)
        read: Array = truth @ self.matrix.T + np.array(self.bias) + noise * random.standard_normal(truth.shape)
        return read

    def wrench(self, readings: ArrayLike, bias: ArrayLike | None = None) -> Array:
        """Return wrenches (..., 6) by readings (..., 6): less the bias (6,), the sheet's unless given, and decoupled.

        Raises
        ------
        ShapeError, NotFinite
        """
        given = vectors("readings", readings, 6)
        zero = np.array(self.bias) if bias is None else finite_array("bias", bias, (6,))
        found = np.linalg.solve(self.matrix, (given - zero).reshape(-1, 6).T)
        return np.asarray(found.T.reshape(given.shape), dtype=np.float64)


@dataclass(frozen=True, slots=True)
class ToolLoad:
    """A tool, and the biases of the sensor that it hangs on, each with its standard deviation.

    Attributes
    ----------
    mass, mass_error
        kg.
    centre, centre_error
        Centre of mass (3,), sensor frame, m; errors infinite, and the centre 0, where the mass is none.
    moment
        Mass times centre (3,), kg m, which is told even so.
    bias, bias_error
        (6,), N and N m.
    force_noise, torque_noise
        Standard deviations of what the fit does not explain, N and N m.
    gravity
        (3,), m/s2, in the world.
    """

    mass: float
    mass_error: float
    centre: Array
    centre_error: Array
    moment: Array
    bias: Array
    bias_error: Array
    force_noise: float
    torque_noise: float
    gravity: Array

    def weight(self, rotations: ArrayLike) -> Array:
        """Return the tool's wrenches (..., 6) at orientations R_ws (..., 3, 3) of the sensor in the world.

        Raises
        ------
        ShapeError, NotFinite, NotAPose
        """
        down = _down(rotations, self.gravity)
        return np.concatenate([self.mass * down, np.cross(np.broadcast_to(self.moment, down.shape), down)], axis=-1)

    def contact(self, rotations: ArrayLike, wrenches: ArrayLike) -> Array:
        """Return what is left (..., 6) of decoupled wrenches (..., 6) less bias and tool: the contact's.

        Raises
        ------
        ShapeError, NotFinite, NotAPose
        """
        found: Array = vectors("wrenches", wrenches, 6) - self.bias - self.weight(rotations)
        return found


def fit_tool(rotations: ArrayLike, wrenches: ArrayLike, *, gravity: ArrayLike) -> ToolLoad:
    """Find a tool's mass and centre of mass, and the sensor's bias, from readings at rest without contact.

    Linear least squares, forces and torques apart: `f = m u + b_f`, `t = (m c) x u + b_t` with `u = R^T g`.

    Parameters
    ----------
    rotations : R_ws (N, 3, 3), at least 4, which tilt the sensor about two axes.
    wrenches : decoupled readings (N, 6), N and N m, in the sensor's frame.
    gravity : (3,), m/s2, in the world: downwards.

    Raises
    ------
    CalibrationError
        Fewer than 4 poses, poses that do not tell the unknowns, a mass below zero.
    ShapeError, NotFinite, NotAPose
    """
    read = finite_array("wrenches", wrenches, ("N", 6))
    g = finite_array("gravity", gravity, (3,))
    if len(read) < LEAST_POSES:
        raise CalibrationError(f"{len(read)} poses came; at least {LEAST_POSES} are needed, tilted about two axes")
    given = np.asarray(rotations, dtype=float)
    if given.shape != (len(read), 3, 3):
        raise ShapeError(f"rotations has shape {given.shape}; ({len(read)}, 3, 3) is needed: one for each wrench")
    down = _down(given, g)
    force = np.concatenate([down[:, :, None], np.broadcast_to(np.eye(3), (len(down), 3, 3))], axis=2)
    torque = np.concatenate([-_cross(down), np.broadcast_to(np.eye(3), (len(down), 3, 3))], axis=2)
    (mass, *bias_f), of_force, force_noise = _solved(force.reshape(-1, 4), read[:, :3].ravel())
    found, of_torque, torque_noise = _solved(torque.reshape(-1, 6), read[:, 3:].ravel())
    moment, bias_t = found[:3], found[3:]
    mass_error = math.sqrt(of_force[0, 0])
    if mass < -TOLD * mass_error:
        raise CalibrationError(
            f"the tool's mass would be {mass:.3g} kg; the readings are of what acts on the sensor, or of the reaction: "
            "turn their signs, and look at the sign of gravity"
        )
    centre, centre_error = np.zeros(3), np.full(3, math.inf)
    if mass > TOLD * mass_error:
        centre = moment / mass
        centre_error = np.sqrt(np.diagonal(of_torque)[:3] + centre**2 * of_force[0, 0]) / mass
    bias_error = np.sqrt(np.concatenate([np.diagonal(of_force)[1:], np.diagonal(of_torque)[3:]]))
    bias = np.concatenate([bias_f, bias_t])
    return ToolLoad(
        float(mass), mass_error, centre, centre_error, moment, bias, bias_error, force_noise, torque_noise, g
    )


@dataclass(frozen=True, slots=True)
class Crosstalk:
    """Matrix C (6, 6) and bias (6,) by known loads, with standard deviations; noise (6,) of each reading."""

    matrix: Array
    matrix_error: Array
    bias: Array
    bias_error: Array
    noise: Array


def fit_crosstalk(wrenches: ArrayLike, readings: ArrayLike) -> Crosstalk:
    """Find a sensor's crosstalk and bias from known wrenches (N, 6) and what it read (N, 6), N and N m.

    Raises
    ------
    CalibrationError
        Fewer than 7 loads, or loads that leave a direction out.
    ShapeError, NotFinite
    """
    loads = finite_array("wrenches", wrenches, ("N", 6))
    read = finite_array("readings", readings, (len(loads), 6))
    if len(loads) < LEAST_LOADS:
        raise CalibrationError(f"{len(loads)} loads came; at least {LEAST_LOADS} are needed, in all six directions")
    A = np.concatenate([loads, np.ones((len(loads), 1))], axis=1)
    columns = [_solved(A, column) for column in read.T]
    rows = np.array([found for found, _, _ in columns])
    errors = np.sqrt(np.array([np.diagonal(covariance) for _, covariance, _ in columns]))
    return Crosstalk(rows[:, :6], errors[:, :6], rows[:, 6], errors[:, 6], np.array([noise for _, _, noise in columns]))


def _solved(A: Array, y: Array) -> tuple[Array, Array, float]:
    """Least squares: the unknowns, their covariance by what is left over, and its standard deviation."""
    size = np.linalg.norm(A, axis=0)
    if (size == 0.0).any():
        raise CalibrationError("one unknown is in no measurement: vary poses or loads, and state gravity")
    U, s, Vt = np.linalg.svd(A / size, full_matrices=False)
    if s[-1] < LEAST_SPREAD * s[0]:
        raise CalibrationError(
            f"the measurements do not tell all unknowns (spread {s[-1] / s[0]:.2g}, needed {LEAST_SPREAD:g}): take "
            "poses that tilt the sensor about two axes, loads in all directions"
        )
    found = Vt.T @ ((U.T @ y) / s) / size
    left, spare = y - A @ found, len(y) - A.shape[1]
    variance = float(left @ left) / spare if spare else 0.0
    spread = Vt.T / s / size[:, None]
    return found, variance * spread @ spread.T, math.sqrt(variance)


def _down(rotations: ArrayLike, gravity: Array) -> Array:
    """Gravity (..., 3) in the frames of rotations (..., 3, 3)."""
    R = vectors("rotations", rotations, 3)
    if R.ndim < 2 or R.shape[-2] != 3:
        raise ShapeError(f"rotations has shape {R.shape}; (..., 3, 3) is needed")
    off = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(initial=0.0)
    if off > 1e-6 or (np.linalg.det(R) < 0.0).any():
        raise NotAPose(f"rotations: R^T R differs from 1 by up to {off:.2g}, or mirrors; rotation matrices are needed")
    down: Array = np.swapaxes(R, -1, -2) @ gravity
    return down


def _cross(v: Array) -> Array:
    """Matrices [v]x (N, 3, 3)."""
    zero = np.zeros(len(v))
    x, y, z = v.T
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
