"""Is a table of switching angles right? What it costs, and what it looks like: units, exchange, a sensor's offset."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from holonom.arrays import Array
from holonom.devices.motors.reluctance import AngleTable, SwitchedReluctance
from holonom.devices.motors.sheet_check import CONTRADICTION, WARNING, Finding
from holonom.errors import OutOfLimits

__all__ = ["check_angles"]

ENOUGH = 0.9
"""Part of the best torque from which angles are right."""


def check_angles(motor: SwitchedReluctance, table: AngleTable) -> tuple[Finding, ...]:
    """Check switching angles against the best ones, driving and braking.

    A sensor offset of the motor counts: the table may be right and the sensor turned.

    Returns
    -------
    Nothing where each node makes at least 0.9 of the best torque; else what is wrong, by name, with numbers.
    """
    return (
        *_checked(motor, table, "driving", table.driving, table.braking, 1.0),
        *_checked(motor, table, "braking", table.braking, table.driving, -1.0),
    )


def _checked(
    motor: SwitchedReluctance, table: AngleTable, name: str, angles: Array, others: Array, sign: float
) -> Iterator[Finding]:
    best = _best(motor, table, sign < 0.0)
    if not best:
        return

    def part(read: Array) -> float:
        """Least part of the best torque over the nodes, with other angles."""
        return min(
            sign * motor.cycle(tuple(read[i, k]), table.speeds[i], table.currents[k]).torque / made
            for (i, k), made in best.items()
        )

    now = part(angles)
    if now >= ENOUGH:
        return
    level = CONTRADICTION if now <= 0.0 else WARNING
    readings = {
        "on and off exchanged": angles[:, :, ::-1],
        "degrees read as rad": np.radians(angles),
        "of the shaft, not electrical": angles * motor.rotor_poles,
        "driving and braking exchanged": others,
    }
    fits = {said: part(read) for said, read in readings.items()}
    if max(fits.values()) < ENOUGH:
        fits = {_offset(shift): part(angles + shift) for shift in np.radians(np.arange(-180.0, 180.0, 5.0))}
    said = max(fits, key=lambda text: fits[text])
    what = "at worst" if now > 0.0 else "turns the wrong way:"
    what += f" {now:.2f} of the best torque"
    if fits[said] >= ENOUGH:
        yield Finding(f"{name} angles: {said}", level, f"{what}; so read, {fits[said]:.2f}", now, fits[said])
    else:
        yield Finding(f"{name} angles: wrong", level, f"{what}; no unit, exchange or offset explains it", now, ENOUGH)


def _best(motor: SwitchedReluctance, table: AngleTable, braking: bool) -> dict[tuple[int, int], float]:
    """Best torque at each node where there is any, the sensor right."""
    right = replace(motor, sensor_offset=0.0, sensor_steps=0, sensor="optical")
    found = {}
    for i, speed in enumerate(table.speeds):
        for k, current in enumerate(table.currents):
            try:
                angles = right.best_angles(float(speed), float(current), braking=braking)
            except OutOfLimits:
                continue
            found[i, k] = abs(right.cycle(angles, float(speed), float(current)).torque)
    return {node: made for node, made in found.items() if made > 0.0}


def _offset(shift: float) -> str:
    return f"turned by {-math.degrees(shift):.0f} electrical degrees (sensor offset, or zero at another place)"
