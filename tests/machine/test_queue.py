"""The supervisor of an arm's path: points far apart are interpolated, and its failure is named."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from holonom import load_arm
from holonom.errors import LevelFault
from holonom.lang import Configuration, Motion
from holonom.machine import Levels, LineSettings
from holonom.machine.arm.queue import MotionQueue
from holonom.mechanics.motion import Trajectory

ARM = load_arm("puma560")
HOME = np.array(ARM.model.poses["nominal"])


def motion(q: np.ndarray) -> Motion:
    return Motion("joint", None, q, 0.5, None, 0.5, Configuration(), True, "fine", 3)


@pytest.mark.parametrize("servo", [5e-4, 1e-3, 2e-3, 5e-3])
@pytest.mark.parametrize("kind", ["joint", "line"])
def test_a_motion_lasts_as_long_whatever_the_servos_period(kind: str, servo: float) -> None:
    """Speeds and accelerations stay within the same limits: the reference is sampled as it is given out."""
    ends = []
    for period in (1e-3, servo):
        levels = Levels(supervisor=period, model=period, servo=period)
        queue = MotionQueue(ARM, HOME, LineSettings(), levels)
        queue.move(dataclasses.replace(motion(HOME + 0.3), kind=kind), idle=True)
        ends.append(period * len(queue.planned.q))
        speed = np.diff(queue.planned.q, axis=0) / period
        assert (np.abs(speed) <= ARM.limits.speed * 0.5 * (1 + 1e-6)).all() or kind == "line"
        np.testing.assert_allclose(speed, 0.5 * (queue.planned.qd[1:] + queue.planned.qd[:-1]), atol=2e-3)
    assert ends[0] == pytest.approx(ends[1], abs=5 * max(servo, 1e-3))  # whole periods of each phase


def path(levels: Levels) -> np.ndarray:
    queue = MotionQueue(ARM, HOME, LineSettings(), levels)
    queue.move(motion(HOME + 0.4), idle=True)
    out = []
    while not queue.empty:
        out.append(queue.take(10)[0])
    return np.concatenate(out)


@pytest.mark.parametrize(("how", "within"), [("hold", 5e-2), ("linear", 2e-3), ("cubic", 5e-4)])
def test_servos_interpolate_what_the_supervisor_gives(how: str, within: float) -> None:
    """Every 50 ms a point; the path is the one that is given every millisecond."""
    fine, coarse = path(Levels()), path(Levels(supervisor=0.05, interpolation=how))
    n = min(len(fine), len(coarse))
    error = np.abs(coarse[: n - 1] - fine[1:n]).max()
    assert error < within
    assert error > 1e-9
    np.testing.assert_allclose(coarse[-1], HOME + 0.4, atol=1e-9)


def test_a_supervisor_that_sends_nonsense_is_named() -> None:
    queue = MotionQueue(ARM, HOME, LineSettings(), Levels(supervisor=0.05))
    queue.move(motion(HOME + 0.4), idle=True)
    for _ in range(30):
        queue.take(10)
    q = queue.planned.q.copy()
    q[queue._used + 100 :] = np.nan
    queue.planned = Trajectory(queue.planned.dt, q, queue.planned.qd, queue.planned.qdd)
    with pytest.raises(LevelFault, match=r"the supervisor sent .*not finite"):
        exhaust(queue)


def exhaust(queue: MotionQueue) -> None:
    for _ in range(200):
        queue.take(10)
