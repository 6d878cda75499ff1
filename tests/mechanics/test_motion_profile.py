from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.errors import OutOfLimits, UnknownName
from holonom.mechanics.motion import PROFILES, Law, on_grid, sample, time_law

NAMES = sorted(PROFILES)
SMOOTH = [name for name in NAMES if np.isfinite(PROFILES.make(name).curvature)]
size = st.floats(1e-3, 1e3)


@given(st.sampled_from(NAMES), size, size, size)
def test_a_law_keeps_its_limits_and_uses_at_least_one_of_them(
    name: str, distance: float, speed: float, acceleration: float
) -> None:
    law = time_law(distance, speed, acceleration, profile=name)
    s, ds, dds = sample(law, np.linspace(0.0, law.duration, 2001))
    assert s[0] == 0.0
    assert s[-1] == 1.0
    assert ds[0] == ds[-1] == 0.0
    used = max(np.max(distance * ds) / speed, np.max(distance * np.abs(dds)) / acceleration)
    assert 0.999 < used <= 1.0 + 1e-9


@given(st.sampled_from(SMOOTH), size, size, size, size)
def test_a_law_keeps_a_jerk_limit(name: str, distance: float, speed: float, acceleration: float, jerk: float) -> None:
    law = time_law(distance, speed, acceleration, jerk, profile=name)
    t = np.linspace(0.0, law.duration, 4001)
    _, ds, dds = sample(law, t)
    measured = np.max(np.abs(np.diff(dds) / np.diff(t))) * distance
    assert np.max(distance * ds) <= speed * (1 + 1e-9)
    assert np.max(distance * np.abs(dds)) <= acceleration * (1 + 1e-9)
    assert measured <= jerk * (1 + 1e-6)
    uses = (np.max(distance * ds) / speed, np.max(distance * np.abs(dds)) / acceleration, measured / jerk)
    assert max(uses) > 0.99


@pytest.mark.parametrize("name", NAMES)
def test_speed_and_acceleration_are_the_derivatives(name: str) -> None:
    law = time_law(2.0, 1.3, 4.0, profile=name)
    corners = np.array([0.0, law.ramp, law.duration - law.ramp, law.duration])
    t = np.linspace(0.0, law.duration, 777)
    h = 1e-6
    t = t[np.abs(t[:, None] - corners).min(axis=1) > 2 * h]
    s, ds, dds = sample(law, t)
    after, before = sample(law, t + h), sample(law, t - h)
    np.testing.assert_allclose((after.s - before.s) / (2 * h), ds, atol=1e-8)
    np.testing.assert_allclose((after.ds - before.ds) / (2 * h), dds, atol=1e-7)
    assert (np.diff(s) > 0).all()


@given(st.sampled_from(NAMES), size, size, size)
def test_time_reversal(name: str, distance: float, speed: float, acceleration: float) -> None:
    law = time_law(distance, speed, acceleration, profile=name)
    (s, ds, dds), _ = on_grid(law, law.duration / 97)
    np.testing.assert_allclose(s + s[::-1], 1.0, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(ds, ds[::-1])
    np.testing.assert_array_equal(dds, -dds[::-1])


@given(size, size, size)
def test_trapezoid_lasts_as_the_closed_form_says(distance: float, speed: float, acceleration: float) -> None:
    full = speed**2 / acceleration
    closed = distance / speed + speed / acceleration if distance > full else 2 * sqrt(distance / acceleration)
    assert time_law(distance, speed, acceleration, profile="trapezoid").duration == pytest.approx(closed)


@given(size, size, size)
def test_quintic_is_the_textbook_polynomial(distance: float, speed: float, acceleration: float) -> None:
    law = time_law(distance, speed, acceleration, profile="quintic")
    closed = max(15 / 8 * distance / speed, sqrt(10 / sqrt(3) * distance / acceleration))
    assert law.duration == pytest.approx(closed)
    u = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(sample(law, u * law.duration).s, 10 * u**3 - 15 * u**4 + 6 * u**5, atol=1e-12)


@given(st.sampled_from(["trapezoid", "scurve"]), st.integers(1, 60), st.integers(0, 60))
def test_the_fall_of_one_and_the_rise_of_the_next_sum_to_the_top_speed(name: str, ramp: int, cruise: int) -> None:
    (_, ds, dds), brake = on_grid(Law(PROFILES.make(name), float(ramp), float(cruise)), 1.0)
    assert brake == ramp + cruise
    np.testing.assert_allclose(ds[brake:] + ds[: ramp + 1], ds[brake], rtol=1e-12)
    np.testing.assert_allclose(dds[brake:] + dds[: ramp + 1], 0.0, atol=1e-12)


@given(st.sampled_from(NAMES), size, size, size, st.floats(1e-4, 1.0))
def test_the_grid_keeps_the_limits_and_wastes_at_most_four_samples(
    name: str, distance: float, speed: float, acceleration: float, dt: float
) -> None:
    law = time_law(distance, speed, acceleration, profile=name)
    dt = max(dt, law.duration / 5000)
    (s, ds, dds), brake = on_grid(law, dt)
    assert s[0] == 0.0
    assert s[-1] == 1.0
    assert ds[-1] == 0.0
    assert np.max(distance * ds) <= speed * (1 + 1e-8)
    assert np.max(distance * np.abs(dds)) <= acceleration * (1 + 1e-8)
    assert -1e-9 <= (s.size - 1) - law.duration / dt <= 4.0
    assert (dds[brake + 1 :] <= 0.0).all()
    assert (dds[1:brake] >= 0.0).all()


def test_no_distance_takes_no_time() -> None:
    law = time_law(0.0, 1.0, 1.0)
    (s, ds, dds), brake = on_grid(law, 1e-3)
    assert law.duration == 0.0
    assert (s.tolist(), ds.tolist(), dds.tolist(), brake) == ([1.0], [0.0], [0.0], 0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((-1.0, 1.0, 1.0), "distance -1"),
        ((inf, 1.0, 1.0), "distance inf"),
        ((1.0, 0.0, 1.0), "speed limit 0"),
        ((1.0, 1.0, inf), "acceleration limit inf"),
        ((1.0, float("nan"), 1.0), "speed limit nan"),
        ((1.0, 1.0, 1.0, 0.0), "jerk limit 0"),
    ],
)
def test_bad_limits_are_named(arguments: tuple[float, ...], words: str) -> None:
    with pytest.raises(OutOfLimits, match=words):
        time_law(*arguments)


def test_a_trapezoid_keeps_no_jerk_limit() -> None:
    with pytest.raises(OutOfLimits, match="use scurve, quintic"):
        time_law(1.0, 1.0, 1.0, 5.0, profile="trapezoid")


def test_unknown_profile() -> None:
    with pytest.raises(UnknownName, match="did you mean 'scurve'"):
        time_law(1.0, 1.0, 1.0, profile="s-curve")
