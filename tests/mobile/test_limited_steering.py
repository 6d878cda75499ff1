"""Limited steering: the nearest twist that a base can drive, and its tightest curve, against searches and by hand."""

from __future__ import annotations

import numpy as np
import pytest
from bases import twists
from hypothesis import given, settings

from holonom.mobile import Wheel, WheelBase, arrangements

CAR = arrangements.ackermann(0.3, 0.2, 0.03, max_steering=np.radians(30.0))
TRICYCLE = arrangements.tricycle(1.2, 0.8, 0.16, max_steering=np.radians(40.0))
MODULES = WheelBase([
    Wheel.at("steered", x, y, radius=0.05, driven=True, max_steering=np.radians(60.0), name=f"{x} {y}")
    for x, y in ((0.2, 0.15), (0.2, -0.15), (-0.2, 0.0))
])  # fmt: skip


def scaled(base: WheelBase, v: np.ndarray) -> np.ndarray:
    return np.asarray(v * np.array([1.0, 1.0, base.radius]))


@pytest.mark.parametrize("base", [CAR, TRICYCLE], ids=["car", "tricycle"])
@given(v=twists)
def test_the_nearest_twist_of_a_car_is_on_the_rays_of_its_curves(base: WheelBase, v: np.ndarray) -> None:
    """All twists of a car are (s, 0, s k) with |k| up to one over its tightest curve: a search over k."""
    k = np.linspace(-1.0, 1.0, 20001) / base.turning_radius
    rays = scaled(base, np.stack([np.ones_like(k), np.zeros_like(k), k], axis=1))
    along = rays @ scaled(base, v) / (rays**2).sum(axis=1)
    least = np.linalg.norm(along[:, None] * rays - scaled(base, v), axis=1).min()
    near = base.feasible(v)
    far = np.linalg.norm(scaled(base, near - v))
    assert least - 1e-4 * (1.0 + np.linalg.norm(v)) <= far <= least + 1e-9  # the search is no finer
    base.wheel_speeds(near)  # drags none, and none steers too far
    np.testing.assert_allclose(base.feasible(near), near, atol=1e-8)


@settings(max_examples=15)
@given(v=twists)
def test_no_drivable_twist_of_modules_is_nearer(v: np.ndarray) -> None:
    near = MODULES.feasible(v)
    MODULES.steering(near)
    least = np.linalg.norm(scaled(MODULES, near - v))
    rng = np.random.default_rng(3)
    others = v + rng.uniform(-1.2, 1.2, (4000, 3)) * least / np.array([1.0, 1.0, MODULES.radius])
    velocity = others[:, None, :2] + others[:, None, 2:] * [[-w.y, w.x] for w in MODULES.wheels]
    held = (np.abs(velocity[..., 1]) <= np.tan(np.radians(60.0)) * np.abs(velocity[..., 0])).all(axis=1)
    far = np.linalg.norm(scaled(MODULES, others - v), axis=1)
    assert (far[held] >= least - 1e-6).all()


def test_batches_and_what_can_be_driven_stay_as_they_are() -> None:
    v = np.array([[0.5, 0.0, 0.4], [0.5, 0.0, 9.0], [0.0, 1.0, 0.0]])
    near = CAR.feasible(v)
    np.testing.assert_allclose(near[0], v[0], atol=1e-12)
    np.testing.assert_allclose(near[2], 0.0, atol=1e-12)
    np.testing.assert_allclose(near, [CAR.feasible(row) for row in v], atol=1e-12)


def test_the_tightest_curve_by_hand() -> None:
    """The inner front wheel binds a car: wheelbase cot(30 deg) + half a track; the front wheel a tricycle."""
    assert CAR.turning_radius == pytest.approx(0.3 / np.tan(np.radians(30.0)) + 0.1, rel=1e-7)
    assert TRICYCLE.turning_radius == pytest.approx(1.2 / np.tan(np.radians(40.0)), rel=1e-7)
    assert arrangements.differential(0.3, 0.05).turning_radius == 0.0
    assert arrangements.omni(n=3, radius=0.1, wheel_radius=0.03).turning_radius == 0.0
    assert np.isinf(arrangements.synchro(0.2, 0.05).turning_radius)
    assert MODULES.turning_radius > 0.0
