"""Counters of every width, and what the index finds of lost pulses."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import (
    HEALTHY,
    INDEX_START,
    Counter,
    Encoder,
    IndexCorrection,
    IndexFault,
    IndexState,
    LineFaults,
    QuadratureEncoder,
    corrected_count,
    index_step,
    line_faults,
    quadrature_step,
    unwrap_count,
    wrap_count,
)
from holonom.errors import ModelError

ENCODER = QuadratureEncoder(500)


@pytest.mark.parametrize("bits", [12, 16, 24, 32])
@given(start=st.integers(-(2**50), 2**50), parts=st.lists(st.floats(-1.0, 1.0, exclude_max=True), max_size=20))
def test_extension_is_exact_below_half_the_counter(bits: int, start: int, parts: list[float]) -> None:
    true = extended = start
    for part in parts:
        true += math.floor(part * 2 ** (bits - 1))
        extended = unwrap_count(bits, extended, wrap_count(bits, true))
        assert 0 <= wrap_count(bits, true) == true % 2**bits
        assert extended == true


@pytest.mark.parametrize("bits", [12, 16, 24, 32])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("part", "right"), [(0.999, True), (1.002, False)])
def test_the_longest_read_interval_is_the_longest(bits: int, sign: float, part: float, right: bool) -> None:
    interval = part * Counter(bits).longest_read_interval(4000, 600.0)
    total = 0
    for k in range(1, 20):
        total = unwrap_count(bits, total, wrap_count(bits, math.floor(sign * 600.0 * interval * k * 4000 / math.tau)))
    assert (total == math.floor(sign * 600.0 * interval * 19 * 4000 / math.tau)) is right


def test_the_published_counter(data_folder: Path) -> None:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    case = next(case for case in cases if case["id"] == "counter")
    given = case["input"]
    expected = case["expected"]["longest_read_interval"]
    interval = Counter(given["counter_bits"]).longest_read_interval(given["counts_per_rev"], given["max_speed"])
    assert interval == pytest.approx(expected, rel=case["tol"])
    assert Encoder(given["counts_per_rev"]).longest_read_interval(given["max_speed"]) == pytest.approx(interval)


def run(
    faults: LineFaults,
    correction: IndexCorrection,
    turns: float,
    encoder: QuadratureEncoder = ENCODER,
) -> tuple[IndexState, int, list[IndexFault]]:
    """State, corrected count and every fault in order, of a shaft that turns at 100 rad/s, sampled at 10 kHz."""
    params, state, index = encoder.params(), encoder.start(0.1), INDEX_START
    faults_seen: list[IndexFault] = []
    steps = math.ceil(abs(turns) * math.tau / 0.01)
    for k in range(1, steps + 1):
        state = quadrature_step(params, faults, state, 0.1 + turns * math.tau * k / steps)
        index = index_step(correction.params(), index, state.counts, state.pulses, state.index_count)
        fault = IndexFault(index.fault)
        if not faults_seen or faults_seen[-1] != fault:
            faults_seen.append(fault)
    return index, corrected_count(index, state.counts), faults_seen


@pytest.mark.parametrize("turns", [6.5, -6.5])
@pytest.mark.parametrize("each", [True, False])
def test_a_healthy_encoder_loses_nothing(turns: float, each: bool) -> None:
    index, count, faults = run(HEALTHY, IndexCorrection(2000, each), turns)
    assert (index.offset, index.total_lost, faults) == (0, 0, [IndexFault.NONE])
    assert abs(count - turns * 2000) <= 1


@pytest.mark.parametrize("turns", [6.5, -6.5])
def test_lost_edges_are_found_and_put_right_at_each_crossing(turns: float) -> None:
    """One edge in 1,000: two a turn; after the first index only those since the last one remain."""
    sign = int(math.copysign(1, turns))
    index, count, faults = run(line_faults(lost=1e-3), IndexCorrection(2000), turns)
    assert faults == [IndexFault.NONE, IndexFault.LOST]
    crossings = abs(index.pulses) - 1
    assert index.lost == 2 * sign
    assert index.total_lost == index.offset == 2 * crossings * sign
    assert abs(count - turns * 2000) <= 4


def test_at_the_reference_run_they_are_only_told() -> None:
    index, count, faults = run(line_faults(lost=1e-3), IndexCorrection(2000, each_crossing=False), 6.5)
    assert faults == [IndexFault.NONE, IndexFault.LOST]
    assert (index.offset, index.total_lost) == (0, 2 * (index.pulses - 1))
    assert 10 < 13000 - count < 16


def test_one_count_is_within_the_tolerance() -> None:
    assert run(line_faults(lost=5e-4), IndexCorrection(2000), 6.5)[2] == [IndexFault.NONE]
    assert IndexFault.LOST in run(line_faults(lost=5e-4), IndexCorrection(2000, tolerance=0), 6.5)[2]


@pytest.mark.parametrize("turns", [3.0, -3.0])
def test_a_stuck_index_is_missing(turns: float) -> None:
    """The first one must have come: before the reference nothing is known."""
    params = IndexCorrection(2000).params()
    index = index_step(params, INDEX_START, 0, 1, 0)
    sign = int(math.copysign(1, turns))
    for count in range(0, 2501 * sign, sign):
        index = index_step(params, index, count, 1, 0)
        assert index.fault == (IndexFault.MISSING if abs(count) > 2500 else IndexFault.NONE)


def test_wrong_counts_per_turn_are_told_by_the_second_index() -> None:
    index, _, faults = run(HEALTHY, IndexCorrection(2000), 2.5, QuadratureEncoder(1024))
    assert faults == [IndexFault.NONE, IndexFault.MISSING, IndexFault.MISPLACED]
    assert index.offset == 0
    assert run(HEALTHY, IndexCorrection(2000), 2.5, QuadratureEncoder(512))[2] == [IndexFault.NONE, IndexFault.LOST]


@given(previous=st.integers(-(10**6), 10**6), turns=st.sampled_from([-1, 0, 1]), lost=st.integers(-499, 499))
def test_the_index_is_a_turn_on_a_turn_back_or_the_same(previous: int, turns: int, lost: int) -> None:
    """Specification 03.3: `previous index count + counts_per_rev * {-1, 0, 1}`."""
    params = IndexCorrection(2000).params()
    first = index_step(params, INDEX_START, previous, 1, previous)
    at = previous + 2000 * turns - lost
    second = index_step(params, first, at, 2, at)
    assert corrected_count(second, at) == previous + 2000 * turns
    assert second.lost == lost
    assert second.fault == (IndexFault.LOST if abs(lost) > 1 else IndexFault.NONE)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Counter(17), "bits is 17; it must be one of 12, 16, 24, 32"),
        (lambda: Counter(64), "bits is 64; it must be 12 to 32"),
        (lambda: Counter().longest_read_interval(4000, 0.0), "max_speed is 0"),
        (lambda: Counter().longest_read_interval(math.nan, 1.0), "counts_per_rev is nan"),
        (lambda: IndexCorrection(2), "counts_per_rev is 2"),
        (lambda: IndexCorrection(2000, tolerance=500), "tolerance is 500 counts; it must be less than largest, 500"),
        (lambda: IndexCorrection(2000, largest=0.6), "largest is 0.6"),
    ],
)
def test_bad_numbers_are_named(make: object, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()  # type: ignore[operator]
