"""Gyros and accelerometers: noise, bias that walks, scale (spec 03.4).

Noise and walk are stated as densities, as data sheets and Allan deviations have them (IEEE Std 952-1997): N in
unit/sqrt(Hz), K in unit/sqrt(s).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array
from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["Accelerometer", "DriftParams", "Gyro", "Imu", "ImuReadings", "allan_deviation", "drift_step"]

Three = tuple[float, float, float]


class DriftParams(NamedTuple):
    """Scale (1 where there is no error), standard deviations of a sample and of the bias' step."""

    scale: float
    noise: float
    walk: float


@loop
def drift_step(params: DriftParams, bias: float, truth: float, white: float, step: float) -> tuple[float, float]:
    """Reading of one axis and its bias afterwards; `white` and `step` are normal with variance 1: the caller draws."""
    return params.scale * truth + bias + params.noise * white, bias + params.walk * step


@dataclass(frozen=True, slots=True)
class Gyro:
    """A gyro about the vertical axis.

    Raises
    ------
    ModelError
        A field that is not finite, a negative noise.
    """

    noise: float = parameter(2e-3, meaning="standard deviation of a 1 kHz sample", unit="rad/s", least=0.0)
    bias: float = parameter(2e-4, meaning="what it shows at rest", unit="rad/s")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


@dataclass(frozen=True, slots=True)
class Accelerometer:
    """Accelerometers along two axes of the base; raises as `Gyro` does."""

    noise: float = parameter(0.05, meaning="standard deviation of a 1 kHz sample", unit="m/s2", least=0.0)
    bias: float = parameter(0.02, meaning="what it shows at rest, on both axes", unit="m/s2")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


class ImuReadings(NamedTuple):
    """Rates (N, 3), rad/s, and specific forces (N, 3), m/s2, as read; the biases (N, 6) in them, which nobody knows."""

    rate: Array
    force: Array
    bias: Array


@dataclass(frozen=True, slots=True)
class Imu:
    """Three gyros and three accelerometers, all of a kind alike.

    Accelerometers feel specific force: acceleration less gravity, in the sensor's axes.

    Raises
    ------
    ModelError
        A number that is not finite, a negative density, a scale error of -1 or less.
    """

    gyro_noise: float = parameter(1e-4, meaning="N of the gyros", unit="rad/s/sqrt(Hz)", least=0.0)
    gyro_walk: float = parameter(1e-5, meaning="K of the gyros", unit="rad/s/sqrt(s)", least=0.0)
    gyro_bias: Three = parameter((0.0, 0.0, 0.0), meaning="biases at the start", unit="rad/s")
    gyro_scale: float = parameter(0.0, meaning="part by which gyros read too much", above=-1.0)
    accelerometer_noise: float = parameter(1e-3, meaning="N of the accelerometers", unit="m/s2/sqrt(Hz)", least=0.0)
    accelerometer_walk: float = parameter(1e-4, meaning="K of the accelerometers", unit="m/s2/sqrt(s)", least=0.0)
    accelerometer_bias: Three = parameter((0.0, 0.0, 0.0), meaning="biases at the start", unit="m/s2")
    accelerometer_scale: float = parameter(0.0, meaning="part by which accelerometers read too much", above=-1.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def gyro_params(self, dt: float) -> DriftParams:
        """Params of `drift_step` for a gyro that is read every `dt` (s)."""
        return _params(self.gyro_scale, self.gyro_noise, self.gyro_walk, dt)

    def accelerometer_params(self, dt: float) -> DriftParams:
        """Params of `drift_step` for an accelerometer that is read every `dt` (s)."""
        return _params(self.accelerometer_scale, self.accelerometer_noise, self.accelerometer_walk, dt)

    def measure(self, rate: ArrayLike, force: ArrayLike, dt: float, random: np.random.Generator) -> ImuReadings:
        """Return what it reads every `dt` (s).

        Parameters
        ----------
        rate, force : true rates (N, 3), rad/s, and specific forces (N, 3), m/s2, in the sensor's axes.
        random : noise and walk are drawn from it.

        Raises
        ------
        ShapeError, NotFinite, ModelError
        """
        rates = finite_array("rate", rate, ("N", 3))
        truth = np.concatenate([rates, finite_array("force", force, (len(rates), 3))], axis=1)
        gyro, accelerometer = self.gyro_params(dt), self.accelerometer_params(dt)
        scale, noise, walk = np.repeat(np.array([gyro, accelerometer]).T, 3, axis=1)
        white, steps = random.standard_normal((2, *truth.shape))
        bias = np.concatenate([[[*self.gyro_bias, *self.accelerometer_bias]], walk * steps]).cumsum(axis=0)[:-1]
        read = scale * truth + bias + noise * white
        return ImuReadings(read[:, :3], read[:, 3:], bias)


def allan_deviation(noise: float, walk: float, time: float) -> float:
    """Deviation between means over neighbouring `time` (s): `sqrt(N^2 / t + K^2 t / 3)` (IEEE Std 952-1997, annex C).

    Raises
    ------
    ModelError
        A time that is not positive, a negative density.
    """
    require("allan_deviation", "time", time, above=0.0)
    require("allan_deviation", "noise", noise, least=0.0)
    require("allan_deviation", "walk", walk, least=0.0)
    return math.sqrt(noise * noise / time + walk * walk * time / 3.0)


def _params(scale: float, noise: float, walk: float, dt: float) -> DriftParams:
    require("Imu.params", "dt", dt, above=0.0)
    return DriftParams(1.0 + scale, noise / math.sqrt(dt), walk * math.sqrt(dt))
