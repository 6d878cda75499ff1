"""A differential base beside MuJoCo with a like model: the same motors, mass and friction, contacts of its own."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from bench_base_mujoco import BASE, DRIVE, STEP
from numpy.typing import NDArray
from peers import mujoco_base

from holonom.sim import BasePlant, Floor

pytestmark = pytest.mark.oracle
Vector = NDArray[np.float64]
SETTLING = 400  # steps in which its soft contacts come to rest


def theirs(volts: list[float]) -> tuple[Vector, float]:
    """Pose of base_link after a second from rest, and the way of its origin."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed; pip install -e '.[oracle]'")
    model = mujoco.MjModel.from_xml_string(mujoco_base(BASE, DRIVE, Floor().material.peak, STEP))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, SETTLING)
    start, turned, way, before = data.qpos[:2].copy(), 0.0, 0.0, data.qpos.copy()
    data.ctrl[:] = volts
    for _ in range(100):
        mujoco.mj_step(model, data, round(0.01 / STEP))
        now = data.qpos.copy()
        turned += math.remainder(2.0 * (math.atan2(now[6], now[3]) - math.atan2(before[6], before[3])), 2.0 * math.pi)
        way += math.hypot(*(now[:2] - before[:2]))
        before = now
    return np.array([*(before[:2] - start), turned]), way


@pytest.mark.parametrize("volts", [[5.0, 3.0], [-4.0, -5.0], [6.0, -6.0], [8.0, 2.0], [3.0, 3.0]])
def test_the_pose_after_a_second(volts: list[float]) -> None:
    """Contacts differ (soft and linear there, a slip curve here): 5 % of the way and of the turn."""
    plant = BasePlant(BASE, DRIVE, Floor())
    plant.drive_open(np.tile(volts, (1000, 1)))
    expected, way = theirs(volts)
    assert np.hypot(*(plant.pose - expected)[:2]) < 0.05 * max(way, 0.1)
    assert abs(plant.pose[2] - expected[2]) < 0.05 * max(abs(expected[2]), 0.02)
