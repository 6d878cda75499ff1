"""Sensors of a log beside its wheels: a gyro and an optical sensor, calibrated by the truth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from holonom.app.odometry_log import OdometryLog
from holonom.app.odometry_log.motion import moved
from holonom.arrays import Array
from holonom.mobile.calibration import Run
from holonom.mobile.odometry import OpticalSensor, calibrate_gyro, calibrate_optical, optical_increments

__all__ = ["sensor_lines", "sensors_of"]


def sensors_of(log: OdometryLog) -> dict[str, Any]:
    """What the truth says of a gyro and of an optical sensor, where the runs have them."""
    data: dict[str, Any] = {}
    gyros = [run for run in log.runs if len(run.rate)]
    if gyros:
        found = [calibrate_gyro(run.time, run.rate, run.heading) for run in gyros]
        weights = np.array([[one.scale_sigma**-2, one.bias_sigma**-2] for one in found])
        values = np.array([[one.scale, one.bias] for one in found])
        (scale, bias), sigma = (values * weights).sum(0) / weights.sum(0), 1.0 / np.sqrt(weights.sum(0))
        data["gyro"] = {
            "scale": {"value": float(scale), "sigma": float(sigma[0]), "unit": "1"},
            "bias": {"value": float(bias), "sigma": float(sigma[1]), "unit": "rad/s"},
        }
    flows = [run for run in log.runs if len(run.flow)]
    if flows:
        counts = np.concatenate([run.flow[1:] for run in flows])
        steps = np.concatenate([_steps(run) for run in flows])
        sensor = calibrate_optical(OpticalSensor(0.0, 0.0), counts, steps)
        residual = optical_increments([sensor], counts[:, None], steps[:, 2]).increments - steps
        data["optical"] = {
            "x_m": sensor.x, "y_m": sensor.y, "angle_deg": math.degrees(sensor.angle), "scale_m": sensor.scale,
            "residual_m": float(np.sqrt((residual[:, :2] ** 2).mean())),
        }  # fmt: skip
    return data


def _steps(run: Run) -> Array:
    """Increments (N - 1, 3) of the truth in the frame half-way round."""
    at = np.arange(len(run.time))
    return moved(np.column_stack([run.truth[:, :2], run.heading]), at[:-1], at[1:], 1.0)


def sensor_lines(data: Mapping[str, Any]) -> list[str]:
    """Return what to print of them."""
    lines = []
    if "gyro" in data:
        scale, bias = data["gyro"]["scale"], data["gyro"]["bias"]
        lines.append(f"gyro: scale {scale['value']:.6f} +- {scale['sigma']:.2g}, "
                     f"bias {bias['value']:.6f} +- {bias['sigma']:.2g} rad/s")  # fmt: skip
    if "optical" in data:
        told = data["optical"]
        place = f"({told['x_m']:.4f}, {told['y_m']:.4f}) m, turned by {told['angle_deg']:.2f} deg"
        scale = f"{told['scale_m']:.6g} m per count, {told['residual_m']:.2g} m off in a sample"
        lines.append(f"optical sensor: at {place}, {scale}")
    return lines
