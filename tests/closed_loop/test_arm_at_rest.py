"""Joint friction holds an arm: without current it stands, for as long as its load stays below breakaway."""

from __future__ import annotations

import numpy as np
import pytest

import holonom as hm
from holonom.closed_loop.arm_loop import ArmLoop
from holonom.errors import DriveFault
from holonom.machine.arm.kernels import CURRENT
from holonom.machine.arm.servos import ControlSettings

ARM = hm.load_arm("puma560")
UPRIGHT = np.array([0.3, -np.pi / 2 - 0.2, np.pi / 2 + 0.1, 0.2, 0.5, -0.4])


def without_current(q: np.ndarray, seconds: float, push: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Joints 1 s after the motors let go, and at the end; `push` are speeds (n,), rad/s, that it starts with."""
    loop = ArmLoop(ARM, q, ControlSettings(following_error=1.0))
    loop.plant.states["speed"] = push
    loop.servos.states["current_reference"] = 0.0
    reference = np.zeros((3, 1000, ARM.n))
    reference[0] = q
    loop._advance(CURRENT, reference)
    settled = loop.truth.position
    reference = np.repeat(reference[:, :1], int(1000 * (seconds - 1.0)), axis=1)
    loop._advance(CURRENT, reference)
    return settled, loop.truth.position


@pytest.mark.parametrize("push", [0.0, 0.05])
def test_below_breakaway_an_arm_stands_for_a_minute(push: float) -> None:
    friction = [joint.friction for joint in ARM.model.joints]
    load = np.abs(ARM.gravity(UPRIGHT))
    assert all(g < min(f.coulomb_positive, f.coulomb_negative) for g, f in zip(load, friction, strict=True) if f)
    assert load.max() > 5.0
    settled, end = without_current(UPRIGHT, 60.0, np.full(ARM.n, push))
    assert np.abs(end - settled).max() < 1e-9
    assert np.abs(settled - UPRIGHT).max() < 0.05


def test_beyond_breakaway_it_falls() -> None:
    stretched = np.zeros(ARM.n)
    assert abs(ARM.gravity(stretched)[1]) > 30.0
    with pytest.raises(DriveFault, match="shoulder"):
        without_current(stretched, 1.2, np.zeros(ARM.n))
