"""Laws of patterns that do nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from omni_bases import scattered, symmetric

from holonom.devices import DcMotor, Gear
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.drive.coupling import base_acceleration, omni_coupling, rim_speeds
from holonom.mobile.drive.patterns import copper_loss, idle_patterns, readable_patterns, split_pattern

MOTOR = DcMotor(1.2, 0.56e-3, 0.0255, 0.0255, 92.5e-7, 24.0, 4.0, 0.1)


@given(st.integers(0, 10**6), st.integers(2, 9))
def test_idle_patterns_are_all_that_do_nothing(seed, n):
    base = scattered(np.random.default_rng(seed), n)
    for N in (idle_patterns(base), readable_patterns(base)):
        assert N.shape == (n, max(n - 3, 0))
        assert np.linalg.matrix_rank(N) == N.shape[1] if N.size else True
        np.testing.assert_allclose(base_acceleration(base, N.T, 1.0), 0.0, atol=1e-8)
        np.testing.assert_allclose(rim_speeds(base, [0.3, -1.0, 2.0]) @ N, 0.0, atol=1e-10)  # no power either
    np.testing.assert_allclose(idle_patterns(base).T @ idle_patterns(base), np.eye(max(n - 3, 0)), atol=1e-12)
    assert ((np.abs(readable_patterns(base)) > 0).sum(axis=0) <= 4).all()


@pytest.mark.parametrize("degrees", [20.0, 37.5, 45.0, 70.0])
def test_four_symmetric_wheels_fight_in_turn(degrees):
    base = symmetric(degrees)
    np.testing.assert_allclose(readable_patterns(base), np.array([[1, -1, 1, -1]]).T, atol=1e-12)
    np.testing.assert_allclose(np.abs(idle_patterns(base)), 0.5, atol=1e-12)


def test_dependent_wheels_fight_too():
    base = omni_coupling([0.0, 0.0, np.pi])  # all along y
    assert idle_patterns(base).shape == (3, 1)
    np.testing.assert_allclose(readable_patterns(base)[:, 0], [1.0, -1.0, 0.0], atol=1e-12)


@given(st.integers(0, 10**6), st.integers(3, 8))
def test_heat_of_the_parts_adds_up(seed, n):
    rng = np.random.default_rng(seed)
    base, f = scattered(rng, n), rng.normal(size=(4, n))
    parts = split_pattern(base, f)
    np.testing.assert_allclose(parts.useful + parts.fighting, f, atol=1e-12)
    np.testing.assert_allclose(base_acceleration(base, parts.useful, 1.0), base_acceleration(base, f, 1.0), atol=1e-8)
    heat = [copper_loss(p, MOTOR, Gear(4.5, 0.9), 0.027) for p in (parts.useful, parts.fighting, f)]
    np.testing.assert_allclose(heat[0] + heat[1], heat[2], rtol=1e-9)
    np.testing.assert_allclose(parts.lost, heat[1] / heat[2], atol=1e-12)


def test_heat_is_resistance_times_current_squared():
    # 1 N at 27 mm behind 4.5 : 1 at 90 % takes 6.67 mN m, 0.261 A
    current = 0.027 / (4.5 * 0.9 * 0.0255)
    assert copper_loss([1.0, 0.0, 0.0, -1.0], MOTOR, Gear(4.5, 0.9), 0.027) == pytest.approx(2 * 1.2 * current**2)
    assert split_pattern(symmetric(), np.zeros(4)).lost == 0.0
    assert split_pattern(symmetric(), [2.0, 0.0, 2.0, 0.0]).lost == pytest.approx(0.5)


def test_errors_name_the_cause():
    with pytest.raises(ShapeError, match="the 4 wheels"):
        split_pattern(symmetric(), np.zeros(3))
    with pytest.raises(OutOfLimits, match="wheel radius"):
        copper_loss(np.zeros(4), MOTOR, Gear(1.0), 0.0)
    for forces in ([np.nan, 0, 0, 0], ["a", 0, 0, 0]):
        with pytest.raises(ShapeError, match="forces holds"):
            split_pattern(symmetric(), forces)
        with pytest.raises(ShapeError, match="forces holds"):
            copper_loss(forces, MOTOR, Gear(1.0), 0.1)
    with pytest.raises(OutOfLimits, match="wheel radius is True"):
        copper_loss(np.zeros(4), MOTOR, Gear(1.0), True)
