"""Laws of slip detection: false alarms, the right name or none, the twist without the wheel, the same by streaming."""

import numpy as np
import pytest
from omni_bases import NOISE, RATE_NOISE, burst, log, scattered, soccer, symmetric
from scipy import stats

from holonom.errors import ModelError, OutOfLimits, ShapeError
from holonom.mobile import arrangements
from holonom.mobile.drive.coupling import Coupling, base_twist, coupling_of, omni_coupling, rim_speeds
from holonom.mobile.drive.slip import SlipSettings, SlipStatus, detect_slip, separable_wheels, slip_params
from holonom.mobile.drive.slip_kernels import slip_start, slip_step

PLAIN = SlipSettings(noise=NOISE, rate_noise=RATE_NOISE)
LIMITED = SlipSettings(noise=NOISE, rate_noise=RATE_NOISE, max_acceleration=8.0, max_angular_acceleration=60.0)
N = 500


@pytest.mark.parametrize("n", [4, 5, 8])
def test_noise_alone_raises_nothing(n):
    rng = np.random.default_rng(n)
    base = scattered(rng, n)
    _, m, _ = log(rng, base, 100_000, {})
    seen = detect_slip(base, m, SlipSettings(noise=NOISE, false_alarm=0.01))
    # the square sum is chi-square with n - 3 degrees of freedom, so the bound is crossed as often as stated
    assert stats.kstest(seen.statistic, stats.chi2(n - 3).cdf).pvalue > 1e-4
    assert 0.008 < (seen.statistic > seen.threshold).mean() < 0.012
    assert (seen.status == SlipStatus.NO_SLIP).all()
    one_sample = detect_slip(base, m, SlipSettings(noise=NOISE, false_alarm=0.01, persistence=1e-3))
    assert 0.0 < (one_sample.status != SlipStatus.NO_SLIP).mean() < 0.025  # raised, and one sample to fall


@pytest.mark.parametrize("n", [4, 5, 6, 7, 8])
@pytest.mark.parametrize("sources", ["wheels", "gyro", "limits", "both"])
def test_a_name_is_right_or_not_given(n, sources):
    rng = np.random.default_rng(100 * n + len(sources))
    named = 0
    for _ in range(40):
        base = scattered(rng, n)
        wheel, size, rise = int(rng.integers(n)), rng.choice([-1, 1]) * rng.uniform(0.1, 2.0), int(rng.integers(1, 60))
        _, m, gyro = log(rng, base, N, {wheel: burst(N, 200, 400, size, rise)})
        rate = gyro if sources in ("gyro", "both") else None
        seen = detect_slip(base, m, LIMITED if sources in ("limits", "both") else PLAIN, rate=rate)
        told = seen.status == SlipStatus.SLIP
        assert not told[:200].any()
        assert (seen.wheel[told] == wheel).all()
        assert (seen.wheel[~told] == -1).all()
        settled = (seen.status == SlipStatus.AMBIGUOUS) & (np.arange(N) > 200 + rise) & (np.arange(N) < 400)
        assert seen.candidates[settled, wheel].sum() >= 0.98 * settled.sum() - 1
        named += bool(told[200:400].any())
    assert named >= {"wheels": 0 if n == 4 else 25, "gyro": 20, "limits": 20, "both": 25}[sources]


@pytest.mark.parametrize("n", [4, 6])
def test_slip_is_named_within_50_ms_and_left_out_of_the_twist(n):
    rng = np.random.default_rng(n)
    base = soccer(radius=0.09) if n == 4 else scattered(rng, n)
    for wheel in range(n):
        twist, m, gyro = log(rng, base, N, {wheel: burst(N, 200, 400, 1.0)})
        seen = detect_slip(base, m, PLAIN, rate=gyro)
        first = int(np.argmax(seen.status == SlipStatus.SLIP))
        assert 200 <= first < 220
        assert (seen.wheel[first:400] == wheel).all()
        assert (seen.status[430:] == SlipStatus.NO_SLIP).all()
        wrong = np.abs(seen.twist - twist)[first:400].mean(axis=0)
        np.testing.assert_array_less(wrong, [0.05, 0.05, 0.4])
        blind = np.abs(base_twist(base, m[first:400]) - twist[first:400])
        assert (blind.mean(axis=0) > 3.0 * wrong).any()


def test_four_wheels_alone_are_ambiguous():
    rng = np.random.default_rng(1)
    base = soccer(radius=0.09)
    _, m, _ = log(rng, base, N, {2: burst(N, 200, 400, 1.0)})
    seen = detect_slip(base, m, PLAIN)
    assert (seen.status[215:400] == SlipStatus.AMBIGUOUS).all()
    assert seen.candidates[215:400].all()
    assert not separable_wheels(base)[~np.eye(4, dtype=bool)].any()
    assert separable_wheels(base).diagonal().all()


@pytest.mark.parametrize("wheel", range(4))
@pytest.mark.parametrize("make", [lambda: symmetric(radius=0.09), lambda: arrangements.mecanum(0.3, 0.3, 0.05)])
def test_a_gyro_that_cannot_separate_opposite_wheels_names_none(make, wheel):
    # with four symmetric wheels, slip of opposite wheels turns the estimate the same way
    rng = np.random.default_rng(wheel)
    base = make()
    _, m, gyro = log(rng, coupling_of(base), N, {wheel: burst(N, 200, 400, 1.0)})
    seen = detect_slip(base, m, PLAIN, rate=gyro)
    assert (seen.status[215:400] == SlipStatus.AMBIGUOUS).all()
    pair = seen.candidates[215:400].mean(axis=0)
    assert pair[wheel] > 0.99
    assert sorted(np.round(pair)) == [0, 0, 1, 1]
    with_limits = detect_slip(base, m, LIMITED, rate=gyro)
    assert (with_limits.wheel[215:400] == wheel).all()


def test_measured_acceleration_separates_too():
    rng = np.random.default_rng(3)
    base = symmetric(radius=0.09)
    twist, m, gyro = log(rng, base, N, {1: burst(N, 200, 400, 0.6, 30)})
    v = np.gradient(twist, 1e-3, axis=0)
    v[:, 0] -= twist[:, 2] * twist[:, 1]
    v[:, 1] += twist[:, 2] * twist[:, 0]
    settings = SlipSettings(noise=NOISE, rate_noise=RATE_NOISE, acceleration_error=0.5, angular_acceleration_error=5.0)
    seen = detect_slip(base, m, settings, rate=gyro, acceleration=v)
    assert (seen.wheel[240:400] == 1).all()
    assert not (detect_slip(base, m, settings, rate=gyro).status == SlipStatus.SLIP).any()


def test_the_last_velocity_turns_against_the_base():
    # a straight line at 3 m/s, the base spinning at 25 rad/s: no acceleration, but its twist turns in base_link
    rng = np.random.default_rng(6)
    base, t = symmetric(radius=0.09), 1e-3 * np.arange(N)
    twist = np.column_stack([3.0 * np.cos(-25.0 * t), 3.0 * np.sin(-25.0 * t), np.full(N, 25.0)])
    settings = SlipSettings(noise=NOISE, rate_noise=RATE_NOISE, acceleration_error=1.0, angular_acceleration_error=10.0)
    for wheel in range(4):
        m = rim_speeds(base, twist) + NOISE * rng.standard_normal((N, 4))
        m[:, wheel] += burst(N, 200, 400, 1.0)
        seen = detect_slip(base, m, settings, rate=twist[:, 2], acceleration=np.zeros((N, 3)))
        assert (seen.wheel[215:400] == wheel).all()
        assert np.abs(seen.twist - twist)[215:400, :2].max() < 0.15


def test_three_wheels_cannot_tell_unless_a_second_source_contradicts():
    rng = np.random.default_rng(2)
    base = omni_coupling(np.deg2rad([90, 210, 330]), radius=0.1)
    _, m, gyro = log(rng, base, N, {0: burst(N, 200, 400, 1.0)})
    assert (detect_slip(base, m, PLAIN).status == SlipStatus.UNDETECTABLE).all()
    seen = detect_slip(base, m, PLAIN, rate=gyro)
    assert (seen.status[:200] == SlipStatus.UNDETECTABLE).all()
    assert (seen.status[215:400] == SlipStatus.AMBIGUOUS).all()
    assert seen.candidates[215:400].all()


@pytest.mark.parametrize(("n", "most"), [(5, 2), (6, 2), (7, 1), (8, 1)])
def test_two_wheels_at_once_are_never_named_wrong(n, most):
    # with most=1 two wheels may look like a third alone: often with n = 5, seldom with n = 6
    rng = np.random.default_rng(n)
    both = 0
    for _ in range(30):
        base = scattered(rng, n)
        pair = rng.choice(n, 2, replace=False)
        slips = {
            int(i): burst(N, 200 + int(rng.integers(30)), 400, s)
            for i, s in zip(pair, rng.uniform(0.3, 2.0, 2), strict=True)
        }
        _, m, _ = log(rng, base, N, slips)
        seen = detect_slip(base, m, SlipSettings(noise=NOISE, most=most))
        assert (seen.status[250:400] != SlipStatus.NO_SLIP).all()
        innocent = np.setdiff1d(np.arange(n), pair)
        assert not seen.named[:, innocent].any()
        both += bool(seen.named[300, pair].all())
    assert both >= (0 if n == 5 else 10)  # five wheels alone cannot: any two explain everything


def test_one_pass_leave_one_out_agrees_with_least_squares():
    rng = np.random.default_rng(8)
    base = scattered(rng, 6)
    _, m, _ = log(rng, base, 300, {4: burst(300, 0, 300, 0.15)})
    seen = detect_slip(base, m, SlipSettings(noise=NOISE, persistence=1e-3, confirmation=1e-3))
    D = base.velocity
    for k in range(300):
        rest = [np.linalg.lstsq(np.delete(D, i, 0), np.delete(m[k], i), rcond=None)[1][0] / NOISE**2 for i in range(6)]
        fits = np.flatnonzero(np.array(rest) <= stats.chi2.isf(1e-4, 2))
        if seen.statistic[k] > seen.threshold and (k == 0 or seen.status[k - 1] == SlipStatus.NO_SLIP):
            if len(fits) == 1:
                assert seen.wheel[k] == fits[0]
            elif len(fits) > 1:
                assert seen.status[k] == SlipStatus.AMBIGUOUS
                np.testing.assert_array_equal(np.flatnonzero(seen.candidates[k]), fits)
    np.testing.assert_allclose(seen.residual @ D, 0.0, atol=1e-12)
    np.testing.assert_allclose((seen.residual**2).sum(axis=1) / NOISE**2, seen.statistic, rtol=1e-9)


def test_one_sample_at_a_time_is_the_same():
    rng = np.random.default_rng(9)
    base = soccer(radius=0.09)
    _, m, gyro = log(rng, base, N, {0: burst(N, 200, 400, 1.0)})
    seen = detect_slip(base, m, LIMITED, rate=gyro)
    params, state, unknown = slip_params(base, LIMITED), slip_start(), np.full(3, np.nan)
    for k in range(N):
        state, said = slip_step(params, state, m[k], gyro[k], unknown)
        assert said.status == seen.status[k]
        assert said.named == (1 << seen.wheel[k] if seen.wheel[k] >= 0 else 0)
        np.testing.assert_array_equal([said.vx, said.vy, said.rw / base.radius], seen.twist[k])


def test_an_encoder_that_gives_no_number_is_named_and_left_out():
    params, state, unknown = slip_params(symmetric(), LIMITED), slip_start(), np.full(3, np.nan)
    for _ in range(3):
        state, _ = slip_step(params, state, np.zeros(4), 0.0, unknown)
    for _ in range(20):
        state, said = slip_step(params, state, np.array([0.0, np.nan, 0.0, 0.0]), 0.0, unknown)
    assert said.status == SlipStatus.SLIP
    assert said.named == 1 << 1
    assert (said.vx, said.vy, said.rw) == (0.0, 0.0, 0.0)
    assert np.isfinite([state.vx, state.vy, state.rw, state.slack]).all()
    for _ in range(20):
        state, said = slip_step(params, state, np.zeros(4), 0.0, unknown)
    assert said.status == SlipStatus.NO_SLIP


def test_wheels_that_no_other_checks_are_known():
    # three of four wheels drive along x: only the fourth gives vy
    D = np.array([[1, 0, 1], [1, 0, -1], [1, 0, 0.5], [0, 1, 0]], float)
    apart = separable_wheels(D)
    np.testing.assert_array_equal(apart.diagonal(), [True, True, True, False])
    # five wheels in two groups that check only themselves
    rows = np.array([[1, 0, 1], [1, 0, -1], [1, 0, 0.5], [0, 1, 0.5], [0, 1, 0.5]], float)
    np.testing.assert_array_equal(separable_wheels(rows)[3], [True, True, True, True, False])
    rng = np.random.default_rng(4)
    _, m, _ = log(rng, Coupling(rows, 0.1), N, {4: burst(N, 200, 400, 1.0)})
    seen = detect_slip(Coupling(rows, 0.1), m, PLAIN)
    assert (seen.status[215:400] == SlipStatus.AMBIGUOUS).all()
    np.testing.assert_allclose(seen.candidates[215:400].mean(axis=0), [0, 0, 0, 1, 1], atol=0.02)


def test_noise_may_differ_by_wheel():
    rng = np.random.default_rng(5)
    base = scattered(rng, 6)
    sigma = np.array([0.01, 0.01, 0.01, 0.2, 0.01, 0.01])
    m = rim_speeds(base, np.zeros((20_000, 3))) + sigma * rng.standard_normal((20_000, 6))
    seen = detect_slip(base, m, SlipSettings(noise=tuple(sigma), false_alarm=0.01))
    assert stats.kstest(seen.statistic, stats.chi2(3).cdf).pvalue > 1e-4


def test_errors_name_the_cause():
    base = soccer()
    with pytest.raises(ModelError, match="rank below 3"):
        detect_slip(base.velocity[:2], np.zeros((1, 2)), PLAIN)
    with pytest.raises(ModelError, match="omni or mecanum"):
        detect_slip(arrangements.differential(0.3, 0.05), np.zeros((1, 2)), PLAIN)
    with pytest.raises(ShapeError, match="speeds"):
        detect_slip(base, np.zeros((5, 3)), PLAIN)
    with pytest.raises(ShapeError, match=r"speeds\[3, 0\] is nan"):
        detect_slip(base, np.where(np.arange(5)[:, None] == 3, np.nan, np.zeros((5, 4))), PLAIN)
    with pytest.raises(ShapeError, match="rate"):
        detect_slip(base, np.zeros((5, 4)), PLAIN, rate=np.zeros(4))
    with pytest.raises(ShapeError, match="acceleration"):
        detect_slip(base, np.zeros((5, 4)), PLAIN, acceleration=np.zeros((5, 2)))
    with pytest.raises(ShapeError, match="3 wheels"):
        slip_params(base, SlipSettings(noise=(0.1, 0.1, 0.1)))
    for bad in ({"noise": 0.0}, {"dt": -1.0}, {"false_alarm": 0.7}, {"most": 3}, {"rate_bias": -1.0}):
        with pytest.raises(OutOfLimits, match=next(iter(bad))):
            SlipSettings(**bad)
