"""Odometry: from what encoders count to where a base is, how surely, and where it cannot be trusted.

=============================  ====================================================================
`metres_per_tick`              way of the rim per encoder tick, `k = pi D / (N C)`
`angle_per_tick`               angle of the wheel per encoder tick
`count_differences`            ticks per sample from counters that go on, or run over
`integrate`, `RULES`           increments of the base to poses: turn then drive, midpoint, exact arc
`increment_noise`              covariance of increments, from noise of wheels, growing with their way, and steering
`steering_jacobians`           increments of a steered base by the ways of its rims and by its angles
`integrate_with_covariance`    poses with their covariances, an `UncertainPath`
`flag`, `find_gaps`            samples with gaps, slip or motion that cannot be, as `Flags`
`optical_increments`           increments from optical sensors (`OpticalSensor`) that look at the floor
`calibrate_optical`            scale, angle and place of such a sensor
`calibrate_gyro`               scale and zero of a gyro, as a `GyroCalibration`
=============================  ====================================================================

Wheel turns become increments by the base's own forward model: `base.twist(turns, steering)` is linear, and takes angles
(rad) per sample as well as speeds.
"""

from holonom.mobile.odometry.covariance import (
    UncertainPath,
    increment_noise,
    integrate_with_covariance,
    steering_jacobians,
)
from holonom.mobile.odometry.flags import Flags, find_gaps, flag
from holonom.mobile.odometry.gyro import GyroCalibration, calibrate_gyro
from holonom.mobile.odometry.integrate import RULES, angle_per_tick, count_differences, integrate, metres_per_tick
from holonom.mobile.odometry.optical import OpticalIncrements, OpticalSensor, calibrate_optical, optical_increments

__all__ = [
    "RULES",
    "Flags",
    "GyroCalibration",
    "OpticalIncrements",
    "OpticalSensor",
    "UncertainPath",
    "angle_per_tick",
    "calibrate_gyro",
    "calibrate_optical",
    "count_differences",
    "find_gaps",
    "flag",
    "increment_noise",
    "integrate",
    "integrate_with_covariance",
    "metres_per_tick",
    "optical_increments",
    "steering_jacobians",
]
