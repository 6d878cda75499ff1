"""Ways to a speed: each is right at constant speed, as fine and as late as it says, and at rest at rest."""

from __future__ import annotations

import json
import math
import operator
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import (
    SPEED_METHODS,
    EdgeReading,
    MMethod,
    MTMethod,
    ObserverMethod,
    PllMethod,
    TMethod,
    capture_edges,
    capture_params,
    equal_resolution_speed,
    first_reading,
)
from holonom.errors import ModelError

COUNTS, INTERVAL, TIMER = 4000, 5e-4, 1e7
TICKS = round(INTERVAL * TIMER)
ALL = list(SPEED_METHODS.own)
METHODS = {name: SPEED_METHODS.make(name, {"counts_per_rev": COUNTS}) for name in ALL}
Q = math.tau / COUNTS


def readings(
    angle: Callable[[float], float], samples: int, edges: int = 1, ticks: int = TICKS, parts: int = 1
) -> list[EdgeReading]:
    """One reading a sample; within each of its parts the shaft turns evenly."""
    params, dt = capture_params(COUNTS, edges), INTERVAL / parts
    found = [first_reading(params, angle(0.0), 0)]
    for k in range(1, samples * parts + 1):
        found.append(capture_edges(params, found[-1], angle((k - 1) * dt), angle(k * dt), k * ticks // parts))
    return found[::parts]


def speeds(method: Any, given: list[EdgeReading]) -> np.ndarray:
    params, state = method.params(), method.start(given[0])
    found = []
    for reading in given[1:]:
        state = method.step(params, state, reading)
        found.append(state.speed)
    return np.array(found)


@given(st.floats(0.3, 900.0), st.floats(0.0, 1.0), st.sampled_from([1, -1]))
def test_edges_are_stamped_when_they_come(speed: float, start: float, sign: int) -> None:
    """Independent: at constant speed edge n comes at (n q - start) / speed."""
    given = readings(lambda t: sign * (start + speed * t), 60)
    for reading in given:
        time = reading.now / TIMER
        assert (
            reading.counts == math.floor(sign * (start + speed * time) / Q)
            or abs((start + speed * time) / Q - round((start + speed * time) / Q)) < 1e-6
        )
        if reading.direction:
            assert reading.direction == sign
            assert reading.stamp == pytest.approx(TIMER * (sign * reading.edge * Q - start) / speed, abs=1.01)
        if reading.period:
            assert reading.period == pytest.approx(TIMER * Q / speed, abs=1.01 + 1e-6 * TIMER * Q / speed)


def test_a_divider_before_the_timer_takes_every_nth_edge() -> None:
    given = readings(lambda t: 40.0 * t, 200, edges=4)
    periods = {reading.period for reading in given if reading.period}
    assert all(abs(period - 4 * TIMER * Q / 40.0) <= 1.01 for period in periods)
    assert given[-1].counts == math.floor(40.0 * 200 * INTERVAL / Q)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("speed", [300.0, 47.3, 5.0, -5.0, -300.0])
def test_a_constant_speed_is_found_within_the_resolution(name: str, speed: float) -> None:
    method = METHODS[name]
    found = speeds(method, readings(lambda t: 0.3 + speed * t, 2000))[400:]
    assert np.abs(found - speed).max() <= 1.05 * method.resolution(speed) + 1e-9
    assert found.mean() == pytest.approx(speed, abs=0.05 * method.resolution(speed) + 2e-4 * abs(speed))


@pytest.mark.parametrize("name", ["m", "t", "m_t"])
@pytest.mark.parametrize("speed", [300.0, 47.3, 5.0])
def test_the_resolution_is_the_step_between_two_values(name: str, speed: float) -> None:
    """At speeds around one, values lie a resolution apart."""
    method = METHODS[name]
    around = (speed * np.linspace(1.0, 1.002, 41)).tolist()
    found = [speeds(method, readings(partial(operator.mul, each), 300))[100:] for each in around]
    steps = np.diff(np.unique(np.concatenate(found)))
    steps = steps[steps > 1e-9 * speed]
    if name == "m":
        np.testing.assert_allclose(steps, method.resolution(speed), rtol=1e-9)
    elif name == "t":
        assert np.median(steps) == pytest.approx(method.resolution(speed), rel=0.05)
    else:  # windows of several lengths lie between each other
        assert np.ptp(np.concatenate(found)) > method.resolution(speed)
        assert steps.min() <= 1.01 * method.resolution(speed)


@pytest.mark.parametrize("bandwidth", [50.0, 400.0, 900.0])
@pytest.mark.parametrize("way", [PllMethod, ObserverMethod])
def test_one_count_moves_a_loop_by_its_resolution(way: Any, bandwidth: float) -> None:
    method = way(COUNTS, INTERVAL, bandwidth)
    rest = EdgeReading(7, 7, 0, 0, 0, 0)
    found = speeds(method, [rest] * 5 + [rest._replace(counts=8)] * 400)
    assert found.max() == pytest.approx(method.resolution(0.0), rel=1e-9)
    part = math.exp(-1.0) if way is PllMethod else 0.8
    assert method.resolution(0.0) == pytest.approx(part * Q * bandwidth, rel=0.3)


def test_a_slow_observer_is_the_continuous_one() -> None:
    for bandwidth in (1.99, 2.01):
        assert ObserverMethod(COUNTS, INTERVAL, bandwidth).resolution(0.0) == pytest.approx(
            0.8 * bandwidth * Q, rel=2e-3
        )


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize(("slow", "fast"), [(100.0, 102.0), (2.0, 2.08)])
def test_the_delay_is_what_a_ramp_lags(name: str, slow: float, fast: float) -> None:
    """Mean lag over the acceleration, over many samples: quantisation averages out.

    Of a tick it does not quite, as the mean of 1/N is not 1 over the mean: the timer is a fast one.
    """
    n, parts = (1000, 50) if name == "t" else (6000, 1)
    method = replace(METHODS[name], timer=1000 * TIMER) if name in ("t", "m_t") else METHODS[name]
    acceleration = (fast - slow) / (n * INTERVAL)
    ramp = readings(lambda t: 0.2 + slow * t + 0.5 * acceleration * t * t, n, ticks=1000 * TICKS, parts=parts)
    found = speeds(method, ramp)[n // 3 :]
    lag = (slow + acceleration * INTERVAL * np.arange(n // 3 + 1, n + 1) - found).mean() / acceleration
    expected = method.delay(0.5 * (slow + fast))
    unsure = 1.5 * Q / (4000 * INTERVAL) / acceleration if name in ("m", "pll", "observer") else 0.02 * expected + 6e-6
    assert lag == pytest.approx(expected, abs=unsure)


@pytest.mark.parametrize("name", ["m", "pll", "observer"])
def test_the_delay_of_the_counting_ways_on_a_hard_ramp(name: str) -> None:
    """So hard that a count is nothing beside it."""
    method, acceleration = METHODS[name], 2e4
    found = speeds(method, readings(lambda t: 0.5 * acceleration * t * t, 1000))[300:]
    true = acceleration * INTERVAL * np.arange(301, 1001)
    assert (true - found).mean() / acceleration == pytest.approx(method.delay(1.0), abs=2e-6)


@pytest.mark.parametrize("name", ALL)
def test_a_shaft_that_stops_stands(name: str) -> None:
    found = speeds(METHODS[name], readings(lambda t: 20.0 * min(t, 0.1), 800))
    assert abs(found[-1]) < 1e-3
    assert found[150] > 15.0


@pytest.mark.parametrize("name", ["t", "m_t"])
def test_without_edges_the_speed_falls_as_it_must(name: str) -> None:
    """After n ticks without an edge it is at most q f_s / n."""
    found = speeds(METHODS[name], readings(lambda t: 20.0 * min(t, 0.1), 300))
    for k in range(202, 300):
        assert abs(found[k]) <= Q / ((k + 1) * INTERVAL - 0.1) * 1.01


@pytest.mark.parametrize("name", ALL)
def test_dithering_over_an_edge_is_no_motion(name: str) -> None:
    """M alone sees a count to and fro; what uses time or smooths stays below it."""
    given = readings(lambda t: Q * (5.0 + 0.2 * math.sin(math.tau * t / (3.7 * INTERVAL))), 800)
    found = speeds(METHODS[name], given)[100:]
    assert np.abs(found.mean()) < 0.05
    assert np.abs(found).max() <= Q / INTERVAL + 1e-9


@pytest.mark.parametrize("name", ALL)
def test_turning_back_turns_the_sign(name: str) -> None:
    method = METHODS[name]
    found = speeds(method, readings(lambda t: -30.0 * abs(t - 0.1), 400))
    assert found[190] == pytest.approx(30.0, abs=1.05 * method.resolution(30.0) + 0.1)
    assert found[-1] == pytest.approx(-30.0, abs=1.05 * method.resolution(30.0) + 0.1)


def test_the_published_speeds(data_folder: Path) -> None:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    case = next(case for case in cases if case["id"] == "velocity methods")
    given, tol = case["input"], case["tol"]
    counts, interval, timer, speed = (given[key] for key in ("counts_per_rev", "Ts", "timer", "speed"))
    t_method = TMethod(counts, timer)
    found = {
        "M_resolution": MMethod(counts, interval).resolution(speed),
        "T_counts": t_method.ticks(speed),
        "T_relative_resolution": t_method.resolution(speed) / speed,
        "equal_resolution_speed": equal_resolution_speed(counts, interval, timer),
    }
    assert found == pytest.approx(case["expected"], rel=tol)


@given(st.integers(4, 100_000), st.floats(1e-5, 1e-2), st.floats(1e5, 1e9))
def test_m_and_t_are_equally_fine_where_it_says(counts: int, interval: float, timer: float) -> None:
    speed = equal_resolution_speed(counts, interval, timer)
    assert MMethod(counts, interval).resolution(speed) == pytest.approx(TMethod(counts, timer).resolution(speed))


def test_at_rest_time_has_no_end() -> None:
    assert TMethod(COUNTS).ticks(0.0) == TMethod(COUNTS).delay(0.0) == MTMethod(COUNTS).delay(0.0) == math.inf
    assert TMethod(COUNTS).resolution(0.0) == MTMethod(COUNTS).resolution(0.0) == 0.0


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: MMethod(0), "counts_per_rev is 0"),
        (lambda: MMethod(COUNTS, 0.0), "interval is 0.0"),
        (lambda: TMethod(COUNTS, math.nan), "timer is nan"),
        (lambda: TMethod(COUNTS, edges=0), "edges is 0"),
        (lambda: MTMethod(COUNTS, longest=0.0), "longest is 0.0"),
        (lambda: PllMethod(COUNTS, bandwidth=-1.0), "bandwidth is -1.0"),
        (lambda: ObserverMethod(COUNTS, bandwidth=math.inf), "bandwidth is inf"),
        (lambda: capture_params(0), "counts_per_rev is 0"),
        (lambda: capture_params(COUNTS, 0), "edges is 0"),
        (lambda: equal_resolution_speed(COUNTS, 0.0, TIMER), "interval is 0.0"),
    ],
)
def test_bad_numbers_are_named(make: Any, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()
