"""Support polygon, margins, tipping and wheel loads."""

import numpy as np
import pytest
from bases import presets
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import linprog, nnls

from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError
from holonom.mobile.arrangements import ackermann, differential, mecanum, omni, sphere
from holonom.mobile.base import WheelBase
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.stability import (
    acceleration_limit,
    contact_points,
    dynamic_margin,
    lateral_limit,
    static_margin,
    support_polygon,
    turning_speed,
    wheel_loads,
    zero_moment_point,
)

CAR = ackermann(2.5, 1.5, 0.3, mass=1200.0, com=(1.2, 0.1), com_height=0.6)
spots = st.tuples(*2 * [st.integers(-100, 100).map(lambda cm: 0.01 * cm)])


def on(points, **options):
    return WheelBase([Wheel.at("spherical", x, y, radius=0.05, driven=True) for x, y in points], **options)


def test_polygon_of_a_car_and_of_a_castor_that_turns():
    corners = support_polygon(CAR)
    assert {tuple(c) for c in np.round(corners, 12)} == {(0.0, 0.75), (0.0, -0.75), (2.5, 0.75), (2.5, -0.75)}
    ahead, back = corners, np.roll(corners, 1, axis=0)
    assert 0.5 * np.sum(back[:, 0] * ahead[:, 1] - ahead[:, 0] * back[:, 1]) == pytest.approx(2.5 * 1.5)
    base = differential(0.3, 0.06, castor=(-0.2, 0.0), castor_offset=0.03)
    np.testing.assert_allclose(contact_points(base)[2], [-0.23, 0.0], atol=1e-15)
    np.testing.assert_allclose(contact_points(base, [[0.0], [np.pi]])[:, 2], [[-0.23, 0.0], [-0.17, 0.0]], atol=1e-15)
    swung = static_margin(base, [-0.1, 0.0], castors=[np.pi])
    assert swung < static_margin(base, [-0.1, 0.0])


@given(st.lists(spots, min_size=3, max_size=7, unique=True), spots)
def test_margin_is_the_distance_to_the_nearest_side(points, com):
    p = np.array(points)
    assume(np.linalg.svd(p - p.mean(axis=0), compute_uv=False)[1] > 0.05)
    base = on(points)
    corners = support_polygon(base)
    sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    signed = []
    for a, b in sides:
        t = b - a
        signed.append((t[0] * (com[1] - a[1]) - t[1] * (com[0] - a[0])) / np.linalg.norm(t))
    np.testing.assert_allclose(static_margin(base, com), min(signed), atol=1e-12)
    for point in points:  # no contact lies outside
        assert static_margin(base, point) > -1e-12


@given(st.floats(-np.pi, np.pi))
def test_at_its_limit_a_base_is_about_to_tip(direction):
    limit = acceleration_limit(CAR, direction)
    a = limit * np.array([np.cos(direction), np.sin(direction)])
    np.testing.assert_allclose(dynamic_margin(CAR, a), 0.0, atol=1e-9)
    loads = wheel_loads(CAR, a)
    np.testing.assert_allclose(loads.sum(), 1200.0 * 9.81, rtol=1e-12)
    assert dynamic_margin(CAR, 1.01 * a) < 0.0 < dynamic_margin(CAR, 0.99 * a)


def test_limits_of_a_car_by_hand():
    g, h = 9.81, 0.6
    np.testing.assert_allclose(acceleration_limit(CAR), g * 1.2 / h)  # forwards it sits back on the rear axle
    np.testing.assert_allclose(acceleration_limit(CAR, np.pi), g * 1.3 / h)
    np.testing.assert_allclose(lateral_limit(CAR), g * 0.65 / h)  # to the right it leans on its left wheels
    np.testing.assert_allclose(acceleration_limit(CAR, [-np.pi / 2, np.pi / 2]), [g * 0.65 / h, g * 0.85 / h])
    np.testing.assert_allclose(turning_speed(CAR, [10.0, -10.0]), np.sqrt(10.0 * g * 0.65 / h))
    np.testing.assert_allclose(zero_moment_point(CAR, [1.0, 0.0]), [1.2 - h / g, 0.1])
    assert np.isinf(acceleration_limit(CAR, com_height=0.0))
    assert static_margin(CAR) == pytest.approx(0.65)
    assert dynamic_margin(CAR, np.zeros((4, 2))).shape == (4,)


def test_braking_shifts_the_load_forwards():
    still, braking = wheel_loads(CAR), wheel_loads(CAR, [-3.0, 0.0])
    moved = 1200.0 * 3.0 * 0.6 / 2.5  # m a h / wheelbase
    np.testing.assert_allclose(braking[:2].sum() - still[:2].sum(), moved)
    np.testing.assert_allclose(still[:2].sum(), 1200.0 * 9.81 * 1.2 / 2.5)
    left = still[0] + still[2]
    np.testing.assert_allclose(left - (still.sum() - left), 1200.0 * 9.81 * 0.1 / 0.75)


@given(st.lists(spots, min_size=3, max_size=6, unique=True), spots)
def test_loads_balance_force_and_moments(points, com):
    p = np.array(points)
    assume(np.linalg.svd(p - p.mean(axis=0), compute_uv=False)[1] > 0.05)
    base = on(points, mass=10.0, com=com)
    if static_margin(base) < -1e-9:
        with pytest.raises(OutOfLimits, match="tips over"):
            wheel_loads(base)
        return
    loads = wheel_loads(base)
    assert loads.min() >= 0.0
    np.testing.assert_allclose(loads.sum(), 98.1, rtol=1e-9)
    np.testing.assert_allclose(loads @ p, 98.1 * np.array(com), atol=1e-6)


def test_what_cannot_stand_or_has_no_mass_is_refused():
    with pytest.raises(ModelError, match="has to balance"):
        support_polygon(sphere(0.1))
    in_line = on([(0.1, 0.1), (0.2, 0.2), (0.3, 0.3)], mass=1.0)
    for ask in (support_polygon, static_margin, wheel_loads):
        with pytest.raises(ModelError, match="span no area"):
            ask(in_line)
    with pytest.raises(InputError, match="no mass"):
        wheel_loads(omni(n=3, radius=0.2, wheel_radius=0.05))
    with pytest.raises(OutOfLimits, match="tips at rest"):
        acceleration_limit(CAR, com=[-0.1, 0.0])
    with pytest.raises(OutOfLimits, match="com_height"):
        acceleration_limit(CAR, com_height=-1.0)
    with pytest.raises(ShapeError, match="acceleration"):
        wheel_loads(CAR, [1.0, 0.0, 0.0])
    with pytest.raises(ShapeError, match=r"com\[0\] is nan"):
        static_margin(CAR, [np.nan, 0.0])
    with pytest.raises(ShapeError, match="direction holds nan"):
        acceleration_limit(CAR, np.nan)
    with pytest.raises(ShapeError, match="curve holds nan"):
        turning_speed(CAR, np.nan)
    with pytest.raises(ShapeError, match="castors"):
        support_polygon(presets()["differential"], [0.0, 0.0])


def test_even_bases_share_the_load_evenly():
    base = mecanum(0.4, 0.3, 0.05, mass=8.0, com_height=0.1)
    np.testing.assert_allclose(wheel_loads(base), 8.0 * 9.81 / 4)
    assert wheel_loads(base, np.zeros((5, 2))).shape == (5, 4)


SIX = [(0.5, 0.3), (0.5, -0.3), (0.0, 0.3), (0.0, -0.3), (-0.5, 0.3), (-0.5, -0.3)]


def test_wheels_only_push():
    """Braking at 8 m/s2 the rear wheels have lifted: by hand, front pair N1 and middle pair N2 carry it all."""
    base = on(SIX, mass=100.0, com_height=0.5)
    loads = wheel_loads(base, [-8.0, 0.0])
    # the force passes 0.5 * 8 / 9.81 m ahead of the middle: N1 * 0.5 = 981 * 0.40775, the rear pair would have to pull
    front = 981.0 * 8.0 * 0.5 / 9.81 / 0.5 / 2.0
    np.testing.assert_allclose(loads, [front, front, 490.5 - front, 490.5 - front, 0.0, 0.0], atol=1e-6)


@given(st.integers(0, 10**6), st.integers(3, 8))
def test_loads_are_those_of_nonnegative_least_squares(seed, n):
    """Lawson & Hanson's algorithm with the balance as heavy rows; a linear program says where none balance."""
    rng = np.random.default_rng(seed)
    p, a = rng.uniform(-1.0, 1.0, (n, 2)), rng.uniform(-12.0, 12.0, 2)
    assume(np.linalg.svd(p - p.mean(axis=0), compute_uv=False)[1] > 0.1)
    base = on([tuple(q) for q in p], mass=10.0, com_height=0.4)
    A, b = np.vstack([np.ones(n), p.T]), 98.1 * np.array([1.0, *(-0.4 / 9.81 * a)])
    stands = linprog(np.zeros(n), A_eq=A, b_eq=b, bounds=(0.0, None)).status == 0
    assume(abs(dynamic_margin(base, a)) > 1e-6)
    if not stands:
        with pytest.raises(OutOfLimits, match="tips over"):
            wheel_loads(base, a)
        return
    heavy = 1e6
    expected, _ = nnls(np.vstack([heavy * A, np.eye(n)]), np.concatenate([heavy * b, np.zeros(n)]))
    np.testing.assert_allclose(wheel_loads(base, a), expected, atol=1e-3)
