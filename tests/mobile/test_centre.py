"""Centre of rotation from twists and from axles."""

import numpy as np
import pytest
from bases import presets, twists
from hypothesis import assume, given
from hypothesis import strategies as st

from holonom.errors import InputError, ShapeError
from holonom.mobile import poses
from holonom.mobile.arrangements import ackermann, ackermann_steering, differential, mecanum
from holonom.mobile.base import WheelBase
from holonom.mobile.base.centre import centre_of_axles, centre_of_rotation, centre_of_twist, twist_about
from holonom.mobile.base.wheel import Wheel


@given(twists)
def test_the_centre_does_not_move(v):
    assume(abs(v[2]) > 1e-3)
    x, y = centre_of_twist(v).point
    np.testing.assert_allclose([v[0] - v[2] * y, v[1] + v[2] * x], 0.0, atol=1e-12)


def test_straight_motions_and_rest():
    found = centre_of_twist([[1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [1.0, 0.0, -2.0]])
    np.testing.assert_array_equal(found.at_infinity, [True, True, True, False, False])
    np.testing.assert_allclose(found.direction, [[0, 1], [1, 0], [0, 0], [0, 0], [0, -1]], atol=1e-15)
    np.testing.assert_allclose(found.point[3:], [[0.0, 0.0], [0.0, -0.5]], atol=1e-15)
    assert np.isinf(found.point[:3]).all()
    with pytest.raises(ShapeError, match="twist"):
        centre_of_twist([1.0, 0.0])


@given(twists)
def test_a_twist_is_its_centre_and_its_rate(v):
    assume(abs(v[2]) > 1e-3)
    centre = centre_of_rotation(v)
    np.testing.assert_allclose(twist_about(centre, v[2]), v, atol=1e-9)
    np.testing.assert_allclose(poses.twist_at(v, centre), [0.0, 0.0, v[2]], atol=1e-9)
    turned = poses.moved(np.zeros(3), v, 0.3)  # the base moves, its centre of rotation does not
    c, s = np.cos(turned[2]), np.sin(turned[2])
    np.testing.assert_allclose(turned[:2] + [[c, -s], [s, c]] @ centre, centre, atol=1e-9 * (1.0 + abs(centre).max()))


def test_centres_and_rates_that_are_none():
    assert np.isinf(centre_of_rotation([1.0, 0.0, 0.0])).all()
    assert twist_about([[0.0, 1.0], [2.0, 0.0]], 0.5).tolist() == [[0.5, 0.0, 0.5], [0.0, -1.0, 0.5]]
    for centre, rate in (([np.inf, 0.0], 1.0), ([0.0], 1.0), ([0.0, 1.0], np.nan), ([[0.0, 1.0]] * 2, [1.0] * 3)):
        with pytest.raises(ShapeError, match=r"centre|rate"):
            twist_about(centre, rate)


@given(st.floats(0.5, 4), st.floats(0.3, 2), st.floats(-1.2, 1.2))
def test_the_wheels_of_a_car_share_one_centre(wheelbase, track, bicycle):
    assume(abs(bicycle) > 0.02)
    car = ackermann(wheelbase, track, 0.2)
    steering = ackermann_steering(car, bicycle)
    found = centre_of_axles(car, steering)
    np.testing.assert_allclose(found.point, [0.0, wheelbase / np.tan(bicycle)], atol=1e-6 * wheelbase / abs(bicycle))
    for wheel, angle in zip(car.wheels, [*steering, 0.0, 0.0], strict=True):  # each axle's line meets it
        left = np.array([-np.sin(wheel.heading + angle), np.cos(wheel.heading + angle)])
        off = found.point - [wheel.x, wheel.y]
        assert abs(left[0] * off[1] - left[1] * off[0]) < 1e-6 * np.linalg.norm(off)
    assert found.miss < 1e-6 * (1.0 + np.linalg.norm(found.point))


def test_common_and_parallel_axles():
    found = centre_of_axles(differential(0.3, 0.05))
    np.testing.assert_allclose(found.point, 0.0, atol=1e-9)  # any point of the axle; the nearest one
    found = centre_of_axles(ackermann(2.0, 1.0, 0.2))
    assert found.at_infinity
    np.testing.assert_allclose(np.abs(found.direction), [0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(found.miss, 0.0, atol=1e-9)
    lone = WheelBase([Wheel.at("fixed", 1.0, 2.0, np.pi / 4, radius=0.1, driven=True)])
    np.testing.assert_allclose(centre_of_axles(lone).point, [1.5, 1.5], atol=1e-9)  # foot of the origin on the axle
    with pytest.raises(InputError, match="no axle"):
        centre_of_axles(mecanum(0.4, 0.3, 0.05))


def test_axles_that_miss():
    swerve = presets()["swerve"]
    v = np.array([0.3, 0.1, 0.8])
    good = swerve.steering(v)
    bad = good + np.array([0.02, 0.0, 0.0, 0.0])
    both = centre_of_axles(swerve, np.stack([good, bad]))
    assert both.point.shape == (2, 2)
    assert both.miss[0] < 1e-9
    assert 1e-3 < both.miss[1] < 0.02  # about 0.02 rad times the distance of that wheel
    np.testing.assert_allclose(both.point, np.tile([-0.125, 0.375], (2, 1)), atol=0.02)
