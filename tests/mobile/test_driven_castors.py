"""Castors whose wheel and pivot are driven: every twist at any angle, from rims and swinging rates."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from holonom.errors import InputError, ShapeError
from holonom.mobile import (
    Wheel,
    WheelBase,
    castor_twist,
    degrees_of_freedom,
    drive_limits,
    is_holonomic,
    mobility,
    speed_profile,
    wheel_rates,
)
from holonom.mobile.drive.sized import sized_base_drive
from holonom.mobile.urdf import base_urdf, load_base

Vector = NDArray[np.float64]


def castors(rng: np.random.Generator, count: int = 3) -> WheelBase:
    places = rng.uniform(-0.4, 0.4, (count, 3))
    return WheelBase(
        [
            Wheel.at("castor", x, y, 7.0 * turn, radius=rng.uniform(0.03, 0.1), driven=True,
                     castor_offset=float(rng.choice([-1.0, 1.0]) * rng.uniform(0.02, 0.1)))
            for x, y, turn in places
        ]
    )  # fmt: skip


def loaded(base: WheelBase) -> WheelBase:
    """With a mass amid its wheels, which are alike."""
    alike = [dataclasses.replace(wheel, radius=0.05) for wheel in base.wheels]
    return WheelBase(alike, mass=5.0, com=np.mean([(w.x, w.y) for w in base.wheels], axis=0).tolist())


@pytest.mark.parametrize("count", [2, 3, 4])
def test_they_are_holonomic_and_move_every_way_at_once(count: int) -> None:
    """Campion, Bastin & d'Andrea-Novel 1996: no wheel's sliding constraint holds the base, none steers it."""
    base = castors(np.random.default_rng(count), count)
    assert mobility(base) == (3, 0, 3)
    assert (degrees_of_freedom(base), is_holonomic(base), base.turning_radius) == (3, True, 0.0)
    assert base.steered == base.driven
    assert not base.sliding_names
    aside = [0.0, 1.0, 0.0]
    assert base.feasible(aside) == pytest.approx(aside)


@pytest.mark.parametrize("rows", [1, 400])  # equations as they are, and compiled
def test_the_contact_neither_slides_nor_slips(rows: int) -> None:
    """Its velocity by differences of the contact's place while base and castor turn: only the rim may carry it."""
    rng = np.random.default_rng(7)
    base = castors(rng)
    twist, turned = rng.normal(size=(rows, 3)), rng.uniform(-4.0, 4.0, (rows, 3))
    speeds, rates = base.wheel_speeds(twist, turned), base.castor_rates(twist, turned)
    h = 1e-6
    for k, wheel in enumerate(base.wheels):

        def contact(t: float, k: int = k, wheel: Wheel = wheel) -> Vector:
            """In the world, of a base that starts at its origin and moves straight for a moment."""
            theta = t * twist[:, 2]
            heading = wheel.heading + turned[:, k] + t * rates.turning[:, k]
            px = wheel.x + wheel.castor_offset * np.cos(heading)
            py = wheel.y + wheel.castor_offset * np.sin(heading)
            c, s = np.cos(theta), np.sin(theta)
            return np.array([t * twist[:, 0] + c * px - s * py, t * twist[:, 1] + s * px + c * py])

        velocity = (contact(h) - contact(-h)) / (2.0 * h)
        u = np.array([np.cos(wheel.heading + turned[:, k]), np.sin(wheel.heading + turned[:, k])])
        assert velocity == pytest.approx(u * (wheel.radius * speeds[:, k]), abs=1e-7)


def test_rims_and_swinging_rates_tell_the_whole_twist() -> None:
    rng = np.random.default_rng(8)
    for count in (2, 3, 4):
        base = castors(rng, count)
        twist, turned = rng.normal(size=(50, 3)), rng.uniform(-4.0, 4.0, (50, count))
        rates = base.castor_rates(twist, turned)
        assert castor_twist(base, rates.turning, rates.rolling, turned) == pytest.approx(twist, abs=1e-9)
        if count > 2:  # at most angles the rims alone do, too
            assert base.twist(base.wheel_speeds(twist, turned), turned) == pytest.approx(twist, abs=1e-6)


def test_a_castor_may_stand_at_any_angle() -> None:
    base = castors(np.random.default_rng(9))
    twist, now = [0.3, 0.5, -0.2], [1.0, 2.0, 3.0]
    assert base.steering(twist).tolist() == [0.0] * 3
    assert base.steering(twist, now) == pytest.approx(now)
    assert base.wheel_speeds(twist) == pytest.approx(base.castor_rates(twist).rolling)


def test_rates_are_derivatives_of_angles_and_speeds() -> None:
    """By differences along twists that change, castors from rest on."""
    rng = np.random.default_rng(10)
    base = castors(rng)
    twist, acceleration = rng.normal(size=3), rng.normal(size=3)
    vx, vy, w = twist
    along = acceleration + np.array([w * vy, -w * vx, 0.0])  # how fast its parts along axes that turn change
    found, h = wheel_rates(base, twist, acceleration), 1e-6
    assert found.steering_rates == pytest.approx(base.castor_rates(twist).turning)
    later = base.wheel_speeds(twist + h * along, h * found.steering_rates)
    sooner = base.wheel_speeds(twist - h * along, -h * found.steering_rates)
    assert found.accelerations == pytest.approx((later - sooner) / (2.0 * h), rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("driven", [True, False])
def test_a_file_gives_them_back_whichever_way_they_trail(driven: bool) -> None:
    wheels = [
        Wheel.at("castor", x, y, 1.0, radius=0.05, castor_offset=d, driven=driven, name=f"c{k}")
        for k, (x, y, d) in enumerate(((0.2, 0.0, 0.05), (-0.1, 0.2, -0.05), (-0.1, -0.2, 0.03)))
    ]
    base = WheelBase([*wheels, Wheel.at("swedish", 0.0, 0.0, radius=0.05, driven=True, name="middle")])
    again = load_base(base_urdf(base))
    twist = [0.3, -0.2, 0.5]
    assert again.driven == base.driven
    for one, other in zip(again.castor_rates(twist), base.castor_rates(twist), strict=True):
        assert np.asarray(one).tolist() == pytest.approx(np.asarray(other).tolist())


def test_a_profile_of_speed_is_refused() -> None:
    base = loaded(castors(np.random.default_rng(12)))
    drive = sized_base_drive(base, 1.0, 1.0)
    way, limits = np.linspace(0.0, 1.0, 11), drive_limits(base, drive.motor, drive.gear, 0.8)
    with pytest.raises(InputError, match="driven castors"):
        speed_profile(base, way, 0.0 * way, limits)


def test_what_does_not_determine_the_twist_is_refused() -> None:
    lone = WheelBase(
        [
            Wheel.at("castor", 0.2, 0.0, radius=0.05, castor_offset=0.03, driven=True),
            Wheel.at("spherical", -0.2, 0.1, radius=0.05),
        ]
    )
    with pytest.raises(InputError, match="1 castors do not determine"):
        castor_twist(lone, [0.1], [0.2])
    base = castors(np.random.default_rng(11))
    with pytest.raises(ShapeError, match="turning"):
        castor_twist(base, [0.1], [0.2, 0.1, 0.1])
    ahead = [-wheel.heading for wheel in base.wheels]  # rims that all roll along x never see y
    with pytest.raises(InputError, match="do not determine"):
        base.twist([1.0, 1.0, 1.0], ahead)
    assert math.isfinite(castor_twist(base, [0.1] * 3, [0.2] * 3, ahead).sum())
