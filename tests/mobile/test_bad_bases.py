"""Bases that cannot be: what is wrong is named, and what motion is left."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import holonom as hm
from holonom.errors import InputError, ModelError
from holonom.mobile import Wheel, WheelBase, conflicting_wheels


def rear(heading: float = 0.0) -> list[Wheel]:
    return [
        Wheel.at("fixed", 0.0, y, heading, radius=0.05, driven=True, name=name)
        for y, name in ((0.2, "left"), (-0.2, "right"))
    ]


def test_wheels_that_contradict_each_other_and_what_is_left() -> None:
    """Without either of those that are named it could move, as said."""
    skew = [Wheel.at("fixed", 0.4, y, 0.3, radius=0.05, name=f"skew {y:g}") for y in (0.1, -0.1)]
    with pytest.raises(ModelError) as refused:
        WheelBase([*rear(), *skew])
    said = str(refused.value)
    assert re.search(r"wheels 'left', 'skew 0.1', 'skew -0.1' cannot roll together", said) or "'right'" in said
    left = re.findall(r"without '([^']+)' it could only turn about \((\S+), (\S+)\) m", said)
    assert len(left) >= 1
    for name, x, y in left:
        base = WheelBase([wheel for wheel in [*rear(), *skew] if wheel.name != name])
        twist = np.array([float(y), -float(x), 1.0])
        assert np.abs(base.sliding_matrix() @ twist).max() < 0.01, "as said, within what is printed"
        assert hm.mobile.mobility(base).dm == 1
    assert re.search(r"so the base cannot move; without .*; turn an axle to the point where the others meet", said)


def test_what_is_left_is_straight_or_several_ways() -> None:
    cross = Wheel.at("fixed", 0.0, 0.0, math.pi / 2, radius=0.05, name="cross")
    with pytest.raises(ModelError, match=r"without 'cross' it could only move straight on, at 0 deg"):
        WheelBase([*rear(), Wheel.at("fixed", 0.3, 0.0, radius=0.05, name="ahead"), cross])


@pytest.mark.parametrize("radius", [0.0, -0.05, math.nan, math.inf])
def test_a_radius_that_is_none(radius: float) -> None:
    with pytest.raises(InputError, match=r"radius"):
        hm.mobile.differential(0.3, radius)
    with pytest.raises(InputError, match=r"radius"):
        hm.mobile.omni(n=3, radius=radius, wheel_radius=0.05)


@pytest.mark.parametrize("mass", [0.0, -2.0, math.nan])
def test_a_mass_that_is_none(mass: float) -> None:
    with pytest.raises(ModelError, match=r"base 'differential' has mass .*; a number above zero is needed"):
        hm.mobile.differential(0.3, 0.05, mass=mass)


def corner(x: float, y: float, heading: float, limit: float) -> Wheel:
    return Wheel.at(
        "steered", x, y, heading, radius=0.05, driven=True, max_steering=limit, name=f"wheel {x:.3g} {y:.3g}"
    )


def test_steering_limits_that_exclude_each_other() -> None:
    """Named by twos: the third has room for all."""
    wheels = [corner(0.4, 0.2, 0.0, 0.2), corner(0.4, -0.2, math.pi / 2, 0.2), corner(-0.4, 0.2, 0.0, 1.5)]
    aside = Wheel.at("fixed", -0.4, 0.0, radius=0.05, name="fixed")
    with pytest.raises(ModelError) as refused:
        WheelBase([*wheels, aside])
    said = str(refused.value)
    assert "the steering limits of 'wheel 0.4 0.2' (11.5 deg), 'wheel 0.4 -0.2' (11.5 deg)" in said or (
        "the steering limits of 'wheel 0.4 -0.2' (11.5 deg) and what the fixed wheels allow exclude each other" in said
    )
    assert "-0.4 0.2" not in said
    assert WheelBase([*wheels[:1], *wheels[2:], aside]).turning_radius > 0.0


def test_limits_are_refused_where_no_twist_lies_within_all() -> None:
    """Random wheels, against a dense search of directions written here."""
    rng, count = np.random.default_rng(3), [0, 0]
    turn, up = np.meshgrid(np.linspace(-np.pi, np.pi, 361), np.linspace(-np.pi / 2, np.pi / 2, 181))
    twists = np.stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up) / 0.5], axis=-1).reshape(-1, 3)
    for _ in range(60):
        wheels = [
            corner(*rng.uniform(-0.6, 0.6, 2), rng.uniform(-math.pi, math.pi), rng.uniform(0.1, 0.8)) for _ in range(4)
        ]
        spare = np.full(len(twists), np.inf)
        for w in wheels:
            velocity = twists[:, :2] + twists[:, 2:] * [-w.y, w.x]
            away = np.arctan2(velocity[:, 1], velocity[:, 0]) - w.heading
            away = np.abs((away + np.pi / 2) % np.pi - np.pi / 2)
            spare = np.minimum(spare, w.max_steering - away)
        if abs(spare.max()) < 0.03:
            continue  # too near to tell by a search
        movable = bool(spare.max() > 0.0)
        if movable:
            WheelBase(wheels)
        else:
            with pytest.raises(ModelError, match="exclude each other"):
                WheelBase(wheels)
        count[movable] += 1
    assert min(count) >= 5
    assert conflicting_wheels(WheelBase(rear()).layout) == ()


def test_a_centre_of_mass_beyond_the_wheels_is_seen() -> None:
    """A base may be described so; it tips by as much, and a cell refuses it."""
    base = hm.mobile.ackermann(0.4, 0.3, 0.05, mass=8.0, com=(0.45, 0.0))
    assert hm.mobile.static_margin(base) == pytest.approx(-0.05)


def test_a_path_sharper_than_the_base_can_turn() -> None:
    """Where, and the smallest radius."""
    car = hm.mobile.ackermann(0.4, 0.3, 0.05, max_steering=0.5, mass=8.0)
    from holonom.devices import DcMotor, Gear

    motor = DcMotor(
        resistance=1.2, inductance=0.5e-3, torque_constant=0.0255, back_emf_constant=0.0255, rotor_inertia=9e-6,
        max_voltage=14.8, max_current=8.0,
    )  # fmt: skip
    limits = hm.mobile.drive_limits(car, motor, Gear(12.0), friction=0.7)
    way = np.linspace(0.0, 4.0, 401)
    bend = np.where(way > 2.0, 1.0 / 0.6, 0.5)
    with pytest.raises(InputError) as refused:
        hm.mobile.speed_profile(car, way, bend, limits)
    assert f"{car.turning_radius:.3g}" in str(refused.value)
    assert re.search(r"2\.\d* m|at 2", str(refused.value))
