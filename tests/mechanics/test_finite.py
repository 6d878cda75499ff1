"""Finite in, finite out: what is not, or what makes numbers overflow, is named."""

import numpy as np
import pytest

from holonom.errors import NotFinite, OutOfLimits
from holonom.mechanics import IkStatus, load_arm
from holonom.mechanics.numerical_inverse import solve_inverse
from holonom.trace import compile, cos

Q = np.array([0.2, 0.7, -2.9, 0.3, 0.6, -0.4])


def spoilt(value, k=2):
    q = Q.copy()
    q[k] = value
    return q


@pytest.fixture(scope="module")
def arm():
    return load_arm("puma560")


@pytest.mark.parametrize("angle", [1.1e15, -1e18, 1e300])
def test_an_angle_whose_turns_cannot_be_told_is_refused(arm, angle):
    rows = np.tile(Q, (3, 1))
    rows[1] = spoilt(angle)
    for verb in (arm.fk, arm.jacobian, arm.gravity, arm.mass_matrix):
        with pytest.raises(OutOfLimits, match=r"q\[2\] is .*e\+.*beyond 1e\+15 whole turns"):
            verb(spoilt(angle))
        with pytest.raises(OutOfLimits, match=r"q\[2\] .* in row \(1,\)"):
            verb(rows)
    T = arm.fk(Q)
    with pytest.raises(OutOfLimits, match=r"q0\[2\] \(joint 'elbow'\)"):
        arm.ik_nearest(T, spoilt(angle))
    with pytest.raises(OutOfLimits, match=r"q0\[2\]"):
        solve_inverse(arm, T, spoilt(angle), limits=False)


def test_an_input_that_comes_through_an_arctangent_is_no_angle(arm):
    """sin(atan2(y, x)) = y / hypot(x, y), whatever their size: a far pose is out of reach, and no lost revolution."""
    T = arm.fk(Q)
    T[0, 3] = 1e18
    assert (arm.ik(T).status != IkStatus.OK).all()
    T[0, 3] = 1e300
    with pytest.raises(OutOfLimits, match=r"T\[3\] is 1e\+300: beyond 1e\+100 products of it overflow"):
        arm.ik(T)


def test_an_angle_of_many_turns_is_what_it_is(arm):
    """NumPy's sine and cosine reduce any double exactly."""
    for angle in (1e6, 1e10, 9e14):
        turned = arm.fk(spoilt(np.arctan2(np.sin(angle), np.cos(angle))))
        np.testing.assert_allclose(arm.fk(spoilt(angle)), turned, atol=1e-9)


def test_what_would_overflow_is_named(arm):
    rest = np.zeros(6)
    for speed in (1e150, 1e200, 1e308):
        with pytest.raises(OutOfLimits, match=r"qd\[1\] is 1e\+.* beyond 1e\+100 products of it overflow"):
            arm.inverse_dynamics(Q, np.where(np.arange(6) == 1, speed, 0.0), rest)
    with pytest.raises(OutOfLimits, match=r"tau\[0\]"):
        arm.forward_dynamics(Q, rest, 1e120 * np.eye(6)[0])
    assert np.isfinite(arm.inverse_dynamics(Q, np.full(6, 1e99), rest)).all()
    assert np.isfinite(arm.forward_dynamics(Q, rest, np.full(6, 1e99))).all()


def test_nan_has_its_own_name(arm):
    for value in (np.nan, np.inf, -np.inf):
        for call in (arm.fk, arm.gravity, lambda q: arm.ik_nearest(arm.fk(Q), q)):
            with pytest.raises(NotFinite, match=r"\[2\].* is (nan|-?inf)"):
                call(spoilt(value))


def test_any_kernel_asks_what_its_sines_are_taken_of():
    kernel = compile(lambda a, b: [cos(a[0] * 2.0) * b[0]], {"a": 1, "b": 1}, {"y": 1}, name="bounded")
    assert kernel(np.array([1.0]), np.array([1e90]))[0] == pytest.approx(1e90 * np.cos(2.0))
    with pytest.raises(OutOfLimits, match=r"a\[0\] is 2e\+15"):
        kernel(np.array([2e15]), np.array([1.0]))
    with pytest.raises(OutOfLimits, match=r"b\[0\] is 1e\+101"):
        kernel(np.array([1.0]), np.array([1e101]))
