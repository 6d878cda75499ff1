"""Each wheel has a friction of its own beside the floor's."""

from __future__ import annotations

import numpy as np
import pytest

from holonom.devices import DcMotor, Encoder, Gear
from holonom.errors import OutOfLimits, UnknownName
from holonom.mobile import BaseDrive, differential
from holonom.sim import ICE, BasePlant, Floor, Material, RoundPatch

MOTOR = DcMotor(
    resistance=1.0, inductance=1e-3, torque_constant=0.03, back_emf_constant=0.03, rotor_inertia=1e-5,
    max_voltage=24.0, max_current=20.0,
)  # fmt: skip
DRIVE = BaseDrive(MOTOR, Gear(10.0), Encoder(4096), wheel_inertia=2e-4)
BASE = differential(0.3, 0.05, mass=10.0, com=(-0.05, 0.0))
FLOOR = Material(peak=0.8, sliding=0.6, slip_at_peak=0.05)


def test_a_worn_tyre_holds_less_on_every_floor() -> None:
    """Its share of the load times the friction of the material under it, on ice too; the base turns towards it."""
    ice = RoundPatch((0.0, 0.0), 0.5, ICE)
    for floor, peak in ((Floor(FLOOR), 0.8), (Floor(FLOOR, (ice,)), ICE.peak)):
        plant = BasePlant(BASE, DRIVE, floor, grips={"left": 0.5})
        log = plant.drive_open(np.tile([20.0, 20.0], (100, 1)))
        left, right = log.friction_limits[50] / log.loads[50]
        assert (left, right) == (pytest.approx(0.5 * peak), pytest.approx(peak))
    assert log.pose[-1, 2] > 1e-3


def test_grips_that_are_none() -> None:
    with pytest.raises(UnknownName, match="did you mean 'left'"):
        BasePlant(BASE, DRIVE, grips={"lefd": 1.0})
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(OutOfLimits, match="above 0"):
            BasePlant(BASE, DRIVE, grips={"left": wrong})
