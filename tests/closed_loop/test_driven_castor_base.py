"""Driven castors in the closed loop: every way at once, wherever the castors look."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from holonom.app.about.drive_bench.bases import BASES
from holonom.app.about.drive_bench.courses import course
from holonom.closed_loop import BaseLoop
from holonom.devices import SteeringMotor
from holonom.machine import BaseController, BaseSettings, Creep
from holonom.mobile import Wheel, WheelBase
from holonom.mobile.drive.sized import sized_base_drive
from holonom.sim import BaseFault, BasePlant, Floor


def castors(offset: float = 0.05, count: int = 3) -> WheelBase:
    return WheelBase(
        [
            Wheel.at("castor", 0.2 * math.cos(a), 0.2 * math.sin(a), math.pi, radius=0.05, castor_offset=offset,
                     driven=True)
            for a in 2.0 * math.pi / count * np.arange(count)
        ],
        mass=8.0, com=(0.01, 0.02), com_height=0.05,
    )  # fmt: skip


def make(
    base: WheelBase, *, ideal: bool = False, steering: SteeringMotor | None = None, faults: Sequence[BaseFault] = ()
) -> BaseLoop:
    floor, drive = Floor(), sized_base_drive(base, 2.0, 2.0)
    drive = drive if steering is None else replace(drive, steering=steering)
    settings = BaseSettings().without_motors() if ideal else BaseSettings()
    controller = BaseController(base, drive, settings, creep=Creep(floor.material.creep, floor.material.peak))
    loop = BaseLoop(controller, BasePlant(base, drive, floor, rng=np.random.default_rng(1), ideal=ideal, faults=faults))
    loop.place((0.0, 0.0, 0.0))
    return loop


def run(loop: BaseLoop, twist: tuple[float, float, float], seconds: float) -> np.ndarray:
    """Drive by velocities; the true twists, one each 10 ms."""
    found = []
    for _ in range(round(100 * seconds)):
        loop.controller.follow_velocity(twist)
        loop.advance(10)
        found.append(loop.plant.twist)
    return np.array(found)


@pytest.mark.parametrize(("offset", "count"), [(0.05, 3), (-0.05, 3), (0.03, 4), (0.05, 2)])
def test_an_eight_at_a_metre_per_second(offset: float, count: int) -> None:
    """Castors that trail, and such that start ahead of their pivots and swing round."""
    base = castors(offset, count)
    path, loop = course("eight", base), make(base)
    assert path is not None
    loop.plant.place(path.pose[0])
    loop.controller.place(path.pose[0], signals=loop.plant.signals)
    loop.controller.follow_path(np.hstack([path.pose, path.twist, path.acceleration]))
    away = []
    for k in range(99, len(path.pose) - 1, 100):
        loop.advance(100)
        away.append(loop.plant.pose - path.pose[k + 1])
    error = np.array(away)
    assert math.sqrt((error[:, :2] ** 2).sum(axis=1).mean()) < 0.02
    assert np.abs(error[:, 2]).max() < 0.02
    assert np.hypot(*(loop.controller.pose - loop.plant.pose)[:2]) < 0.02  # rims and swinging rates: honest odometry


@pytest.mark.parametrize("kind", ["dead", "blocked"])
def test_a_wheels_motor_that_breaks(kind: str) -> None:
    """The others drive on without a dead one, and all stop for one that is jammed."""
    base = castors()
    path, loop = course("eight", base), make(base, faults=[BaseFault(3.0, "wheel 1", kind)])
    assert path is not None
    loop.controller.follow_path(np.hstack([path.pose, path.twist, path.acceleration]))
    away = 0.0
    for k in range(99, 9000, 100):
        loop.advance(100)
        away = max(away, float(np.hypot(*(loop.plant.pose - path.pose[k + 1])[:2])))
    assert loop.controller.state["dead"][0] == 1
    if kind == "dead":
        assert away < 0.02
    else:
        assert np.abs(loop.plant.twist).max() < 0.01
    assert np.hypot(*(loop.controller.pose - loop.plant.pose)[:2]) < 0.03


def test_sideways_back_and_on_the_spot() -> None:
    loop = make(castors())
    for twist in ((0.0, 0.8, 0.0), (0.0, -0.8, 0.0), (0.8, 0.0, 0.0), (0.0, 0.0, 2.0), (0.4, 0.4, 1.0)):
        reached = run(loop, twist, 2.0)[-1]
        assert reached == pytest.approx(twist, abs=0.02)
    run(loop, (0.0, 0.0, 2.0), 1.0)
    about = loop.plant.pose
    for _ in range(10):
        run(loop, (0.0, 0.0, 2.0), 0.1)
        assert np.hypot(*(loop.plant.pose - about)[:2]) < 3e-3  # the centre of rotation
    assert np.hypot(*(loop.controller.pose - loop.plant.pose)[:2]) < 0.02


def test_motors_that_swing_slowly_hold_the_base_back() -> None:
    """It goes the way that it is asked to all the same, never faster than they can follow."""
    slow = SteeringMotor(max_rate=3.0)
    loop = make(castors(), steering=slow)
    run(loop, (0.6, 0.0, 0.0), 2.0)
    start = loop.plant.pose
    turned = run(loop, (0.0, 0.6, 0.0), 2.0)
    assert turned[-1] == pytest.approx([0.0, 0.6, 0.0], abs=0.02)
    assert np.hypot(*turned[:, :2].T).max() < 0.65
    assert abs(loop.plant.pose[2] - start[2]) < 0.05
    assert np.hypot(*(loop.controller.pose - loop.plant.pose)[:2]) < 0.02


def test_ideal_castors_do_what_they_are_told() -> None:
    loop = make(castors(), ideal=True, steering=SteeringMotor(max_rate=60.0))
    for twist in ((0.0, 0.8, 0.0), (0.5, 0.0, 0.0), (0.0, 0.0, 2.0)):
        assert run(loop, twist, 2.0)[-1] == pytest.approx(twist, abs=5e-3)
    assert loop.controller.pose == pytest.approx(loop.plant.pose, abs=5e-3)


def test_a_swerve_turns_on_the_spot() -> None:
    """Its tightest curve has no radius: a twist without any speed of base_link is driven, too."""
    loop = make(BASES["swerve"]())
    assert run(loop, (0.0, 0.0, 1.5), 2.0)[-1] == pytest.approx([0.0, 0.0, 1.5], abs=0.02)
