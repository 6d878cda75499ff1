"""Borders of the closed loops: what cannot be meant is refused with what came and what is allowed; nothing moves."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from demo_cell import ARM, HOME
from simulated_bases import BASES, DRIVE

from holonom.closed_loop import ArmLoop, BaseLoop, IdealArm
from holonom.closed_loop.arm_loop import drives_of
from holonom.errors import LevelFault, OutOfLimits, ShapeError, UnknownName
from holonom.machine import ArmServos, BaseController, ControlSettings, Levels, PointBuffer
from holonom.machine.levels import interpolate
from holonom.sim import ArmPlant, BasePlant, Ground

PARTS = ("position", "speed", "acceleration")
NAN = HOME * np.nan


def base() -> BaseLoop:
    return BaseLoop(BaseController(BASES["omni 4"], DRIVE), BasePlant(BASES["omni 4"], DRIVE))


@pytest.mark.parametrize("bad", [(np.nan, 0.0, 0.0), (np.inf, 0.0, 0.0), (0.0, 0.0), "abc", 1j * np.ones(3)])
def test_a_base_is_not_placed_nowhere(bad: object) -> None:
    loop = base()
    loop.place((1.0, 2.0, 0.5), (0.1, 0.0, 0.0))
    for put in (loop.place, loop.plant.place, lambda p: loop.controller.place(p, signals=loop.plant.signals)):
        with pytest.raises(ShapeError, match="pose"):
            put(bad)
    with pytest.raises(ShapeError, match="twist"):
        loop.place((0.0, 0.0, 0.0), bad)
    np.testing.assert_array_equal([*loop.plant.pose, *loop.controller.pose], 2 * [1.0, 2.0, 0.5])
    np.testing.assert_array_equal([*loop.plant.twist, *loop.controller.twist], 2 * [0.1, 0.0, 0.0])


@pytest.mark.parametrize("ticks", [-5, 1.5, "3", None])
def test_time_goes_on_in_whole_ticks(ticks: object) -> None:
    loop, arm, ideal = base(), ArmLoop(ARM, HOME, ControlSettings()), IdealArm(ARM, HOME, ControlSettings())
    points = PointBuffer("above", [0.0], Levels(), speed=[1.0], acceleration=[1.0])
    for advance in (loop.advance, loop.buffer, loop.plant.noise, arm.brake, ideal.brake, points.take):
        with pytest.raises(OutOfLimits, match=re.escape(f"is {ticks!r}; it must be a whole number of at least 0")):
            advance(ticks)
    assert loop.time == arm.time == ideal.time == 0.0
    loop.advance(np.int64(3))
    assert loop.time == pytest.approx(3e-3)


@pytest.mark.parametrize("kind", [ArmLoop, IdealArm])
@pytest.mark.parametrize("shape", [(3, 5, 5), (5, 6), (2, 5, 6), (3, 6)])
def test_a_reference_of_another_shape_is_no_following_error(kind: type, shape: tuple[int, ...]) -> None:
    loop = kind(ARM, HOME, ControlSettings())
    with pytest.raises(ShapeError, match=rf"{re.escape(str(shape))}; it must be \(3, ticks, 6\)"):
        loop.advance(np.zeros(shape))
    assert loop.ticks == 0
    loop.advance(np.zeros((3, 0, 6)))
    assert loop.ticks == 0


@pytest.mark.parametrize("kind", [ArmLoop, IdealArm])
@pytest.mark.parametrize("part", range(3))
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_reference_that_is_not_finite_is_named(kind: type, part: int, value: float) -> None:
    loop = kind(ARM, HOME, ControlSettings())
    reference = np.stack([np.tile(HOME, (5, 1)), np.zeros((5, 6)), np.zeros((5, 6))])
    reference[part, 3, 2] = value
    with pytest.raises(LevelFault, match=f"{PARTS[part]} of {ARM.limits.names[2]} at tick 3 is {value}"):
        loop.advance(reference)
    assert loop.ticks == 0
    np.testing.assert_allclose(loop.position, HOME, atol=1e-3)


STARTS: list[Callable[[np.ndarray], object]] = [
    lambda q: ArmLoop(ARM, q, ControlSettings()),
    lambda q: IdealArm(ARM, q, ControlSettings()),
    lambda q: ArmPlant(ARM, drives_of(ARM), q),
    lambda q: ArmServos(ARM, q),
]


@pytest.mark.parametrize("start", STARTS)
def test_an_arm_stands_somewhere(start: Callable[[np.ndarray], object]) -> None:
    for bad in (NAN, HOME[:5], np.stack([HOME, HOME])):
        with pytest.raises(ShapeError, match="q"):
            start(bad)


def test_other_borders_of_arms() -> None:
    loop = ArmLoop(ARM, HOME, ControlSettings())
    for payload in (NAN[:4], np.zeros(3)):
        with pytest.raises(ShapeError, match="payload"):
            loop.payload = payload
    with pytest.raises(ShapeError, match="5 drives"):
        ArmPlant(ARM, drives_of(ARM)[:5], HOME)
    with pytest.raises(ShapeError, match="hold"):
        loop.servos.start(HOME, NAN, loop.plant.signals)
    for bad in ({"height": np.nan}, {"stiffness": -1.0}, {"damping": np.inf}):
        with pytest.raises(OutOfLimits, match=next(iter(bad))):
            Ground(**bad)


def test_borders_of_levels() -> None:
    for bad in ([np.nan], [[0.0]], 0.0):
        with pytest.raises(ShapeError, match="start"):
            PointBuffer("above", bad, Levels(), speed=[1.0], acceleration=[1.0])
    with pytest.raises(ShapeError, match="speed"):
        PointBuffer("above", [0.0], Levels(), speed=[1.0, 1.0], acceleration=[1.0])
    for limit in (0.0, -1.0, np.nan):
        with pytest.raises(OutOfLimits, match="acceleration"):
            PointBuffer("above", [0.0], Levels(), speed=[1.0], acceleration=[limit])
    with pytest.raises(UnknownName, match="interpolation 'cubical'"):
        interpolate([[0.0], [1.0]], 4, "cubical")
    with pytest.raises(OutOfLimits, match="ratio"):
        interpolate([[0.0], [1.0]], 0)
