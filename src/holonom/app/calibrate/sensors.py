"""Sensors of a log beside its wheels: a gyro and an optical sensor, calibrated by the truth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from holonom.app.odometry_log import OdometryLog
from holonom.app.odometry_log.motion import moved
from holonom.arrays import Array
from holonom.mobile.calibration import Parameters, Run
from holonom.mobile.odometry import OpticalSensor, calibrate_gyro, calibrate_optical, flag, optical_increments

__all__ = ["sensor_lines", "sensors_of", "slips_of"]


SLIPPING = 8.0  # times the usual disagreement of the wheels from which on one of them slips
LEAST = 0.02  # m/s of a rim, below which none does
SHORTEST = 3  # samples of a slip


def slips_of(log: OdometryLog, parameters: Parameters, values: Array) -> list[str]:
    """Notes on spells in which the wheels of a base with more of them than motions contradict each other: slip.

    Parameters
    ----------
    values : (p,) calibrated.
    """
    notes = []
    for run in log.runs:
        at = parameters.sampled(run, values)
        dt = np.gradient(run.time)
        radius = max(v for n, v in zip(parameters.names, values, strict=True) if n.startswith(("radius", "diameter")))
        rims = at.strain * radius / dt[:, None]
        if not rims.shape[1] or len(run.time) < SHORTEST:
            continue
        worst = np.abs(rims).max(axis=1)
        bound = max(SLIPPING * float(np.median(worst)), LEAST)
        slip = flag(run.time, at.increments, residual=rims, max_residual=bound, gap_factor=np.inf).slip
        edges = np.flatnonzero(np.diff(np.concatenate([[False], slip, [False]]).astype(np.int8))).reshape(-1, 2)
        spells = [(int(a), int(b)) for a, b in edges if b - a >= SHORTEST]
        if spells:
            first, last = max(spells, key=lambda spell: float(worst[spell[0] : spell[1]].max()))
            more = f", and {len(spells) - 1} more such" if len(spells) > 1 else ""
            span = f"from {run.time[first]:g} to {run.time[last - 1]:g} s"
            by = f"by up to {worst[first:last].max():.3g} m/s{more}"
            notes.append(f"run {run.name}: {span} its wheels contradict each other {by}: one of them slips; cut it out")
    return notes


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
