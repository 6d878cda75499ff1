"""Rows of every kind of wheel against the velocity of its contact point, derived anew."""

import math

import numpy as np
import pytest
from bases import twists, wheels
from hypothesis import given
from hypothesis import strategies as st

from holonom.errors import ModelError, UnknownName
from holonom.mobile.base import WheelBase
from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.equations.wheels import unit


def velocity_at(twist, x, y):
    """Velocity of a point of the base by the cross product in space."""
    return (np.array([twist[0], twist[1], 0.0]) + np.cross([0.0, 0.0, twist[2]], [x, y, 0.0]))[:2]


def directions(wheel):
    ahead = np.array([math.cos(wheel.heading), math.sin(wheel.heading)])
    return ahead, np.array([-ahead[1], ahead[0]])


def rows(wheel, which):
    function = getattr(KINDS[wheel.kind], which)
    return np.array(function(wheel, math.sin(wheel.axle), math.cos(wheel.axle)), dtype=float).reshape(-1, 3)


@pytest.mark.parametrize("kind", ["fixed", "steered"])
def test_a_standard_wheel_rolls_with_its_contact_and_does_not_slide(kind):
    @given(wheels(kind), twists)
    def check(wheel, twist):
        ahead, left = directions(wheel)
        v = velocity_at(twist, wheel.x, wheel.y)
        np.testing.assert_allclose(rows(wheel, "rolling") @ twist, [ahead @ v], atol=1e-12)
        np.testing.assert_allclose(rows(wheel, "sliding") @ twist, [left @ v], atol=1e-12)

    check()


@given(wheels("swedish", driven=True), twists)
def test_what_a_swedish_wheel_does_not_roll_its_rollers_give(wheel, twist):
    ahead, _ = directions(wheel)
    rim = rows(wheel, "rolling") @ twist * ahead  # the rim carries the contact along the wheel
    axle = np.array([math.cos(wheel.heading + wheel.roller_angle), math.sin(wheel.heading + wheel.roller_angle)])
    slip = velocity_at(twist, wheel.x, wheel.y) - rim
    assert abs(slip @ axle) < 1e-11 * (1 + np.linalg.norm(slip))  # a roller rolls square to its axle only
    assert rows(wheel, "sliding").size == 0


@given(wheels("spherical", driven=True), twists)
def test_a_driven_ball_rolls_without_slip(wheel, twist):
    along, across, spin = rows(wheel, "rolling") @ twist / wheel.radius
    ahead, left = directions(wheel)
    axis = np.array([*(along * left - across * ahead), 0.0])  # rolling ahead is turning about the left
    contact = np.array([*velocity_at(twist, wheel.x, wheel.y), 0.0]) + np.cross(axis, [0.0, 0.0, -wheel.radius])
    np.testing.assert_allclose(contact, 0.0, atol=1e-11)
    np.testing.assert_allclose(spin, twist[2], atol=1e-12)
    assert not rows(Wheel.at("spherical", 0.1, 0.2, radius=0.1), "rolling").size


@given(wheels("castor"), twists)
def test_a_castor_follows_without_sliding(castor, twist):
    base = WheelBase([castor, Wheel.at("swedish", 0.0, 0.0, radius=0.1, driven=True)])
    rates = base.castor_rates(twist)
    h = 1e-6

    def contact(t):
        """Contact point in the world a moment away, the base turned and moved to first order."""
        psi = castor.heading + t * rates.turning[0]
        local = np.array([castor.x, castor.y]) + castor.castor_offset * np.array([math.cos(psi), math.sin(psi)])
        c, s = math.cos(t * twist[2]), math.sin(t * twist[2])
        return t * np.asarray(twist[:2]) + np.array([[c, -s], [s, c]]) @ local

    v = (contact(h) - contact(-h)) / (2 * h)
    ahead, left = directions(castor)
    assert abs(left @ v) < 1e-6
    np.testing.assert_allclose(ahead @ v, castor.radius * rates.rolling[0], atol=1e-6)


def test_castors_trail_and_take_their_angle():
    castor = Wheel.at("castor", -0.3, 0.0, math.pi, radius=0.02, castor_offset=0.03)
    base = WheelBase([castor, Wheel.at("swedish", 0.0, 0.0, radius=0.1, driven=True, name="drive")])
    turned = np.array([[0.0], [0.3], [-0.3]])
    forwards = base.castor_rates([1.0, 0.0, 0.0], turned)
    assert forwards.names == ("wheel 1",)
    np.testing.assert_allclose(forwards.rolling[:, 0], -np.cos([0.0, 0.3, 0.3]) / 0.02)
    assert forwards.turning[1, 0] < 0.0 < forwards.turning[2, 0]  # it comes back behind the base


@given(wheels("fixed"))
def test_polar_and_cartesian_are_the_same_wheel(wheel):
    again = Wheel.at("fixed", wheel.x, wheel.y, wheel.heading, radius=wheel.radius, driven=wheel.driven)
    for field in ("x", "y", "radius"):
        np.testing.assert_allclose(getattr(again, field), getattr(wheel, field), atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * again.heading), np.exp(1j * wheel.heading), atol=1e-12)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"radius": 0.0}, "radius 0.0 m; state one above zero"),
        ({"radius": -0.1}, "radius -0.1"),
        ({"radius": math.nan}, "radius = nan; a finite number"),
        ({"x": math.inf}, "x = inf"),
        ({"heading": math.nan}, "heading = nan"),
        ({"kind": "swedish", "roller_angle": math.pi / 2}, "90 deg"),
        ({"kind": "castor"}, "castor_offset 0"),
        ({"roller_angle": 0.3}, "only swedish wheels"),
        ({"castor_offset": 0.3}, "only castor wheels"),
        ({"max_steering": 0.3}, "only steered wheels"),
        ({"kind": "steered", "max_steering": 2.0}, "0 to pi/2"),
        ({"kind": "steered", "max_steering": math.nan}, "0 to pi/2"),
    ],
)
def test_what_is_no_wheel_is_refused(fields, words):
    stated = {"kind": "fixed", "x": 0.1, "y": 0.2, "radius": 0.05} | fields
    with pytest.raises(ModelError, match="wheel") as problem:
        Wheel.at(**stated)
    assert words in str(problem.value)


def test_unknown_kinds_and_negative_distances_are_refused():
    with pytest.raises(UnknownName, match="did you mean 'swedish'"):
        Wheel.at("sweedish", 0.0, 0.0, radius=0.1)
    with pytest.raises(ModelError, match="turn alpha"):
        Wheel(kind="fixed", l=-0.1, alpha=0.0, beta=0.0, radius=0.1)


def test_what_is_zero_but_for_rounding_is_zero():
    for quarter in range(-4, 5):
        assert unit(quarter * np.pi / 2) == (round(math.sin(quarter * np.pi / 2)), round(math.cos(quarter * np.pi / 2)))
    left = Wheel.at("fixed", 0.0, 0.3, radius=0.1)
    assert (left.x, left.y) == (0.0, 0.3)
    assert Wheel.at("fixed", -0.3, 0.0, radius=0.1).y == 0.0


@given(st.floats(-10.0, 10.0))
def test_sine_and_cosine_of_an_axle_are_those_of_its_angle(angle):
    np.testing.assert_allclose(unit(angle), (math.sin(angle), math.cos(angle)), rtol=0.0, atol=1e-15)
