"""Parameters derived from any wheel set: increments as `WheelBase.twist` has them, derivatives as differences have."""

from __future__ import annotations

import numpy as np
import pytest

import holonom as hm
from holonom.errors import CalibrationError, UnknownName
from holonom.mobile.calibration import Run
from holonom.mobile.calibration.derived import derived_parameters

m = hm.mobile
BASES = {
    "differential": m.differential(0.3, 0.05),
    "tricycle": m.tricycle(0.4, 0.3, 0.05),
    "bicycle": m.bicycle(0.4, 0.05),
    "ackermann": m.ackermann(0.4, 0.3, 0.05),
    "dual_ackermann": m.dual_ackermann(0.4, 0.3, 0.05),
    "synchro": m.synchro(0.2, 0.05),
    "omni": m.omni([0.1, 1.3, 2.6, 3.8, 5.1], radius=0.2, wheel_radius=0.05),
    "mecanum": m.mecanum(0.4, 0.3, 0.05),
    "swerve": m.swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05),
    "skid_steer": m.skid_steer(0.4, 0.3, 0.05),
}


def _run(base: hm.mobile.WheelBase) -> Run:
    twists = base.feasible(np.random.default_rng(1).normal(size=(50, 3)) * [1.0, 1.0, 3.0])
    steering = base.steering(twists)
    turns = 0.02 * base.wheel_speeds(twists, steering, tolerance=np.inf)
    return Run("random", np.arange(50.0), turns, np.empty((0, 3)), steering)


@pytest.mark.parametrize("kind", BASES)
@pytest.mark.parametrize("set_name", ["physical", "extended"])
def test_increments_are_those_of_the_base_and_slopes_those_of_differences(kind: str, set_name: str) -> None:
    base, run = BASES[kind], _run(BASES[kind])
    found = derived_parameters(base, set_name)
    increments, slopes, strain, _ = found.sampled(run, found.nominal)
    assert strain == pytest.approx(np.zeros_like(strain), abs=1e-7)
    assert increments == pytest.approx(base.twist(run.turns, run.steering), abs=1e-8)
    rng = np.random.default_rng(2)
    for step in 1e-6 * rng.normal(size=(3, len(found.names))) * found.scale:
        more, less = (found.sampled(run, found.nominal + sign * step).increments for sign in (1.0, -1.0))
        assert 0.5 * (more - less) == pytest.approx(slopes @ step, abs=2e-9)


def test_what_cannot_be_derived_is_refused() -> None:
    with pytest.raises(UnknownName):
        derived_parameters(BASES["omni"], "all")
    ball = m.WheelBase([m.Wheel.at("spherical", 0.0, 0.0, radius=0.1, driven=True)])
    with pytest.raises(CalibrationError, match="drives a ball about three axes"):
        derived_parameters(ball)
