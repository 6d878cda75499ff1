"""Wheels that are lost are named by what they push, on any base; those of healthy ones never, however it drives."""

from __future__ import annotations

import numpy as np
import pytest

from holonom.app.about.drive_bench.bases import BASES
from holonom.closed_loop import BaseLoop, simulate_base
from holonom.machine import PATHS, BaseSettings, PathLimits, plan_path
from holonom.machine.base.controller import BaseController
from holonom.machine.base.settings import Creep
from holonom.mobile import WheelBase, omni
from holonom.mobile.base.drivable import moves_sideways
from holonom.mobile.drive.sized import sized_base_drive
from holonom.sim import BaseFault, BasePlant, Floor

STANDING = [name for name in BASES if name != "segway"]


def loop_of(base: WheelBase, rng: np.random.Generator, *faults: BaseFault) -> BaseLoop:
    floor = Floor()
    drive = sized_base_drive(base, rng.uniform(1.0, 2.5), rng.uniform(0.5, 2.5))
    creep = Creep(floor.material.creep, floor.material.peak)
    loop = BaseLoop(
        BaseController(base, drive, BaseSettings(), creep=creep), BasePlant(base, drive, floor, faults=faults, rng=rng)
    )
    loop.place((0.0, 0.0, 0.0))
    return loop


def harsh(rng: np.random.Generator) -> np.ndarray:
    """A twist beyond what motors do at once, along any of its parts or ahead."""
    if rng.random() < 0.5:
        return np.array([rng.choice([-2.0, 2.0]), 0.0, rng.choice([0.0, rng.uniform(-3.0, 3.0)])])
    return np.sign(rng.uniform(-1.0, 1.0, 3)) * [2.0, 2.0, 6.0] * rng.choice([0.0, 1.0], 3)


@pytest.mark.parametrize("name", STANDING)
def test_nothing_is_lost_where_nothing_is_broken_however_it_drives(name: str) -> None:
    """Heavy wheels, light ones, 4 to 25 kg, motors that are strong and weak, velocities that change at once."""
    make = BASES[name]
    for seed in range(8):
        rng = np.random.default_rng(seed)
        kept = make.keywords  # type: ignore[attr-defined]
        radius = kept["wheel_radius"] * rng.uniform(0.6, 2.0)
        base = make.func(**{**kept, "mass": rng.uniform(4.0, 25.0), "wheel_radius": radius})  # type: ignore[attr-defined]
        loop = loop_of(base, rng)
        for _ in range(6):
            twist = harsh(rng)
            for _ in range(rng.choice([1, 3, 6, 10])):
                loop.controller.follow_velocity(twist)
                loop.advance(100)
            lost = loop.controller.states["lost"].ravel()[: len(base.driven)]
            assert not lost.any(), (seed, loop.time, lost)


@pytest.mark.parametrize("name", ["ackermann", "omni", "skid_steer"])
def test_what_a_wheel_pushes_is_what_the_floor_gets(name: str) -> None:
    """The controller's force, of current and turning of the wheel alone, against the plant's, sample by sample."""
    base = BASES[name]()
    loop = loop_of(base, np.random.default_rng(3))
    seen, true = [], []
    for k in range(200):
        loop.controller.follow_velocity((np.sign(np.sin(0.05 * k)), 0.0, 0.5))
        loop.advance(8)
        seen.append(loop.controller.states["pushed"].ravel()[: len(base.driven)].copy())
        true.append(loop.plant.states["along"].ravel()[: len(base.driven)].copy())
    left, size = np.std(np.subtract(seen, true)), np.std(true)
    assert left < 0.35 * size
    assert np.corrcoef(np.ravel(seen), np.ravel(true))[0, 1] > 0.9


@pytest.mark.parametrize("name", ["differential", "ackermann", "synchro", "omni5", "mecanum", "swerve", "skid_steer"])
def test_a_wheel_that_comes_off_is_named_on_any_base(name: str) -> None:
    base = BASES[name]() if name in BASES else omni(n=5, radius=0.2, wheel_radius=0.05, mass=8.0, com_height=0.05)
    sideways = moves_sideways(base)
    path = plan_path(
        PATHS.make("figure_of_eight", {"size": 4.0}), PathLimits(1.0, 1.0), heading="fixed" if sideways else "tangent"
    )
    for wheel in (0,) if name in ("differential", "skid_steer") else (0, len(base.driven) - 1):
        drive = sized_base_drive(base, 2.0, 2.0)
        log = simulate_base(base, drive, path, faults=[BaseFault(4.0, wheel, "off")], rng=np.random.default_rng(1))
        (text, *_) = [event.text for event in log.events if event.source == "motor watch"]
        assert text.startswith(f"{base.driven[wheel]} pushes nothing, it is off or spins")
        assert log.ended == ("stopped" if name in ("differential", "skid_steer") else "done")
        if log.ended == "done":
            assert log.path_error.max() < 0.1
