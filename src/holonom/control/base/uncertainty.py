"""How sure a base is of its pose by dead reckoning: settings, and the covariance along a whole run."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.control.base.uncertainty_kernels import (
    CONSTANTS,
    UncertaintyParams,
    pose_covariance,
    start_uncertainty,
    uncertainty_step,
)
from holonom.errors import OutOfLimits, ShapeError
from holonom.trace.code.loops import loop

__all__ = ["PoseUncertainty", "UncertaintySettings", "covariance_along"]


@dataclass(frozen=True, slots=True)
class UncertaintySettings:
    """Standard deviations of what `control.base.kernels.estimate_step` does not know.

    Attributes
    ----------
    start, start_turn
        Of the first pose, m and rad; a count of the encoders, and what observers lag behind.
    gyro_noise
        Of one sample at 1 kHz, rad/s.
    gyro_bias
        Of the gyro's zero at the start, rad/s; wheels correct it in `bias_time` (s).
    bias_time
        s, as in `EstimateSettings`.
    way_noise
        Of a place, m after 1 s: accelerometers and encoders, through the wheels' filter.
    drift
        Constant error of velocity, m/s, of either axis: an accelerometer's zero through the wheels' filter.
    drag_creep
        Creep of wheels that push against constant drag, m/s along the way.
    scale
        Part of the way, constant: wheels of another size than known.
    force_creep
        Creep per acceleration ahead and to the left, s: a base at a velocity has lagged behind by this times it.
    turn_square
        Turning rate that wheels show falsely per square of acceleration, rad/s per (m/s^2)^2: loads shift, and wheels
        creep unequally.
    turn_lean
        The same per acceleration ahead and to the left, rad/s per m/s^2.

    Raises
    ------
    OutOfLimits
        A negative number, a time that is not positive.
    """

    start: float = 2e-4
    start_turn: float = 2e-4
    gyro_noise: float = 2e-3
    gyro_bias: float = 2e-4
    bias_time: float = 20.0
    way_noise: float = 5e-5
    drift: float = 4e-4
    drag_creep: float = 0.0
    scale: float = 0.0
    force_creep: tuple[float, float] = (0.0, 0.0)
    turn_square: float = 0.0
    turn_lean: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for field in fields(self):
            values = np.atleast_1d(np.asarray(getattr(self, field.name), dtype=np.float64))
            if not np.all(values >= 0.0) or (field.name == "bias_time" and not values[0] > 0.0):
                raise OutOfLimits(
                    f"UncertaintySettings: {field.name} is {getattr(self, field.name)!r}; it must be at least 0, and "
                    "bias_time above 0"
                )

    def params(self, dt: float) -> UncertaintyParams:
        """Params of `uncertainty_step` at a sample time, s."""
        return UncertaintyParams(
            dt=dt,
            start=self.start,
            start_turn=self.start_turn,
            turn_noise=self.gyro_noise**2 * 1e-3 * dt,
            way_noise=self.way_noise**2 * dt,
            gyro_bias=self.gyro_bias,
            bias_gain=dt / self.bias_time,
            drift=self.drift,
            drag_creep=self.drag_creep,
            scale=self.scale,
            force_creep=0.5 * (self.force_creep[0] + self.force_creep[1]),
            force_creep_difference=0.5 * (self.force_creep[0] - self.force_creep[1]),
            turn_square=self.turn_square,
            turn_lean_x=self.turn_lean[0],
            turn_lean_y=self.turn_lean[1],
        )


def covariance_along(
    settings: UncertaintySettings, dt: float, pose: ArrayLike, twist: ArrayLike, acceleration: ArrayLike
) -> Array:
    """Covariance of an estimated pose at every sample of a run.

    Parameters
    ----------
    settings
        What is not known.
    dt
        Sample time, s.
    pose, twist
        (N, 3) as estimated: in odom, and in base_link.
    acceleration
        (N, 2) as measured, m/s^2 in base_link.

    Returns
    -------
    (N, 3, 3), m^2, m rad, rad^2.

    Raises
    ------
    ShapeError
    """
    return PoseUncertainty(settings, dt).along(pose, twist, acceleration)


class PoseUncertainty:
    """The covariance of an estimated pose as a run goes on. Mutable state: what is known so far.

    Parameters
    ----------
    settings
        What is not known.
    dt
        Sample time, s.
    """

    def __init__(self, settings: UncertaintySettings, dt: float) -> None:
        self._params = settings.params(dt)
        self._constants, self._noise = np.empty((4, CONSTANTS)), np.empty((3, 3))
        start_uncertainty(self._params, self._constants, self._noise)

    def along(self, pose: ArrayLike, twist: ArrayLike, acceleration: ArrayLike) -> Array:
        """Return the covariance (N, 3, 3) at the next samples; arguments as in `covariance_along`.

        Raises
        ------
        ShapeError
        """
        rows = (np.ascontiguousarray(x, dtype=np.float64) for x in (pose, twist, acceleration))
        poses, twists, forces, out = _checked(*rows)
        _along(self._params, poses, twists, forces, out, self._constants, self._noise)
        return out


def _checked(poses: Array, twists: Array, forces: Array) -> tuple[Array, Array, Array, Array]:
    """Return the rows, and an array for their covariances."""
    count = len(poses)
    if (poses.shape, twists.shape, forces.shape) != ((count, 3), (count, 3), (count, 2)):
        raise ShapeError(f"pose {poses.shape}, twist {twists.shape}, acceleration {forces.shape} came; give "
                         "(N, 3), (N, 3) and (N, 2)")  # fmt: skip
    return poses, twists, forces, np.empty((count, 3, 3))


@loop(error_model="numpy")
def _along(
    params: UncertaintyParams, pose: Array, twist: Array, force: Array, out: Array, constants: Array, noise: Array
) -> None:
    for k in range(len(pose)):
        now = Planar(twist[k, 0], twist[k, 1], twist[k, 2])
        pose_covariance(params, constants, noise, pose[k, 2], now, out[k])
        uncertainty_step(params, constants, noise, pose[k, 2], now, Planar(force[k, 0], force[k, 1], 0.0))
