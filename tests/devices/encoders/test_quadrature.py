"""Two channels and an index, every edge: the closed form against edges one by one, decodings, faults."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import HEALTHY, QuadratureEncoder, QuadratureState, decode_levels, line_faults, quadrature_step
from holonom.errors import ModelError

LINES = 8
"""Few, so that a random walk passes the index often."""
ENCODER = QuadratureEncoder(LINES)
QUARTER = 2.0 * math.pi / (4 * LINES)
WALK = st.lists(st.integers(-100, 100), min_size=1, max_size=40)


def levels_of(quarter: int) -> int:
    """Levels by the picture: A is high in quarters 1, 2 of a line, B in 2, 3, the index in one a turn."""
    phase = quarter % 4
    return (1 if phase in (1, 2) else 0) + (2 if phase in (2, 3) else 0) + (4 if quarter % (4 * LINES) == 0 else 0)


def angle_of(quarter: int) -> float:
    return (quarter + 0.5) * QUARTER


@pytest.mark.parametrize("decoding", [1, 2, 4])
@given(start=st.integers(-50, 50), moves=WALK)
def test_the_closed_form_is_every_edge_one_by_one(decoding: int, start: int, moves: list[int]) -> None:
    encoder = QuadratureEncoder(LINES, decoding)
    params = encoder.params()
    jumps = edges = encoder.start(angle_of(start))
    at = start
    for move in moves:
        for quarter in range(at + 1, at + move + 1) if move > 0 else range(at - 1, at + move - 1, -1):
            edges = decode_levels(params, edges, levels_of(quarter), True)
        at += move
        jumps = quadrature_step(params, HEALTHY, jumps, angle_of(at))
        assert jumps[2:9] == edges[2:9]
        assert (jumps.quarter, jumps.place, jumps.illegal) == (at, at % (4 * LINES), 0)


@pytest.mark.parametrize("decoding", [1, 2, 4])
@given(start=st.integers(-50, 50), moves=WALK)
def test_faults_that_do_nothing_change_nothing(decoding: int, start: int, moves: list[int]) -> None:
    """The way of the faults, edge by edge, ends in the state of the closed form; what follows does, too."""
    encoder = QuadratureEncoder(LINES, decoding)
    faint = line_faults(glitches=1e-30)
    one = other = encoder.start(angle_of(start))
    at = start
    for k, move in enumerate(moves):
        at += move
        one = quadrature_step(encoder.params(), HEALTHY, one, angle_of(at))
        other = quadrature_step(encoder.params(), HEALTHY if k % 3 == 2 else faint, other, angle_of(at))
        assert one[:10] == other[:10]


@given(WALK)
def test_a_closed_walk_counts_nothing(moves: list[int]) -> None:
    for decoding in (1, 2, 4):
        encoder = QuadratureEncoder(LINES, decoding)
        state, at = encoder.start(angle_of(3)), 3
        for move in [*moves, -sum(moves)]:
            at += move
            state = quadrature_step(encoder.params(), HEALTHY, state, angle_of(at))
        assert state.counts == 0


@pytest.mark.parametrize("decoding", [1, 2, 4])
@pytest.mark.parametrize("turns", [1, -1, 7, -7])
def test_a_turn_has_its_counts_and_one_index(decoding: int, turns: int) -> None:
    encoder = QuadratureEncoder(500, decoding)
    state = encoder.start(0.1)
    steps = 97 * abs(turns)
    for k in range(1, steps + 1):
        state = quadrature_step(encoder.params(), HEALTHY, state, 0.1 + 2.0 * math.pi * turns * k / steps)
    assert (
        state.counts
        == turns * 500 * decoding
        == turns * encoder.counts_per_rev
        == turns * encoder.counted().counts_per_rev
    )
    assert state.pulses == abs(turns)
    assert state.edges_a == state.edges_b == abs(turns) * 1000


def test_the_index_latches_the_same_count_from_both_sides() -> None:
    for decoding in (1, 2, 4):
        encoder = QuadratureEncoder(LINES, decoding)
        state, seen = encoder.start(angle_of(-6)), []
        for quarter in (5, -7, 9, -2, 3):
            state = quadrature_step(encoder.params(), HEALTHY, state, angle_of(quarter))
            seen.append(state.index_count)
        assert state.pulses == 5
        assert len(set(seen)) == 1


def run(
    faults: object, speed: float = 100.0, time: float = 0.02, encoder: QuadratureEncoder = QuadratureEncoder(500)
) -> QuadratureState:
    """An encoder of 2,000 counts, 10 kHz: 3.2 edges a sample at 100 rad/s."""
    state = encoder.start(0.0)
    for k in range(round(time / 1e-4)):
        state = quadrature_step(encoder.params(), faults, state, speed * 1e-4 * (k + 1))
    return state


@pytest.mark.parametrize("level", ["low", "high"])
@pytest.mark.parametrize("channel", ["a", "b"])
def test_a_stuck_channel_counts_to_and_fro(channel: str, level: str) -> None:
    state = run(line_faults(a=level) if channel == "a" else line_faults(b=level))
    assert -1 <= state.counts <= 1
    stuck, alive = (state.edges_a, state.edges_b) if channel == "a" else (state.edges_b, state.edges_a)
    assert stuck <= 1
    assert alive > 300


def test_a_dead_encoder_says_nothing() -> None:
    state = run(line_faults(dead=True))
    assert (state.counts, state.edges_a, state.edges_b, state.pulses) == (0, 0, 0, 0)


@pytest.mark.parametrize("speed", [100.0, -100.0])
def test_swapped_channels_count_the_other_way(speed: float) -> None:
    assert run(line_faults(swapped=True), speed).counts == -run(HEALTHY, speed).counts != 0


@pytest.mark.parametrize("lost", [1e-3, 0.25, 1.0])
def test_the_share_that_is_lost_is_lost(lost: float) -> None:
    whole, less = run(HEALTHY, time=0.2), run(line_faults(lost=lost), time=0.2)
    assert abs(whole.counts * (1.0 - lost) - less.counts) <= 1.0
    assert (less.illegal, less.edges_a, less.edges_b, less.pulses) == (0, whole.edges_a, whole.edges_b, whole.pulses)


def test_a_glitch_on_an_edge_is_an_illegal_transition() -> None:
    whole, rough = run(HEALTHY, time=0.2), run(line_faults(glitches=0.01), time=0.2)
    assert rough.illegal == whole.counts // 100
    assert rough.counts == whole.counts - 2 * rough.illegal


@given(st.integers(0, 3), st.sampled_from([1, 2]), st.integers(1, 9))
def test_a_glitch_between_edges_counts_nothing(phase: int, channel: int, pulses: int) -> None:
    for decoding in (1, 2, 4):
        encoder = QuadratureEncoder(LINES, decoding)
        state = encoder.start(angle_of(phase))
        for _ in range(pulses):
            state = decode_levels(encoder.params(), state, state.levels ^ channel, True)
            state = decode_levels(encoder.params(), state, state.levels ^ channel, True)
        assert (state.counts, state.illegal) == (0, 0)


def test_both_channels_at_once_are_illegal() -> None:
    for before in range(4):
        state = ENCODER.start(angle_of(before))
        after = decode_levels(ENCODER.params(), state, state.levels ^ 3, True)
        assert (after.counts, after.illegal) == (0, 1)


@pytest.mark.parametrize("level", ["low", "high"])
def test_a_stuck_index_never_comes(level: str) -> None:
    state, whole = run(line_faults(index=level), time=0.5), run(HEALTHY, time=0.5)
    assert state.pulses == 0
    assert whole.pulses == 7
    assert state.counts == whole.counts


def test_other_counts_per_turn_count_by_their_own() -> None:
    other = run(HEALTHY, time=0.5, encoder=QuadratureEncoder(512))
    assert other.counts / run(HEALTHY, time=0.5).counts == pytest.approx(1.024, rel=1e-4)
    assert other.index_count == 7 * 2048


def test_a_fault_that_ends_leaves_what_it_cost() -> None:
    """Where the stuck level and the true one differ by then, the first healthy reading is one edge more."""
    params, state = ENCODER.params(), ENCODER.start(angle_of(0))
    state = quadrature_step(params, line_faults(a="low"), state, angle_of(9))
    back = quadrature_step(params, HEALTHY, state, angle_of(9))
    assert back.levels == levels_of(9)
    on = quadrature_step(params, HEALTHY, back, angle_of(20))
    assert on.counts - back.counts == 11


@pytest.mark.parametrize("angle", [math.nan, math.inf, -math.inf, 1e12, -1e12])
def test_an_angle_that_no_shaft_has_hangs_no_loop(angle: float) -> None:
    for faults in (HEALTHY, line_faults(a="low"), line_faults(lost=0.5)):
        for start in (0.0, 0.5, -0.5):
            quadrature_step(ENCODER.params(), faults, ENCODER.start(start), angle)


def test_random_walk_by_numpy() -> None:
    """Independent: counts from the signs of two square waves sampled finely."""
    angles = np.cumsum(np.random.default_rng(3).uniform(-0.09, 0.1, 3000))
    state = ENCODER.start(0.0)
    for angle in angles:
        state = quadrature_step(ENCODER.params(), HEALTHY, state, float(angle))
    assert state.counts == math.floor(angles[-1] / QUARTER)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: QuadratureEncoder(0), "lines is 0; it must be 1 to 268,435,456"),
        (lambda: QuadratureEncoder(500, 3), "decoding is 3; it must be 1, 2 or 4"),
        (lambda: ENCODER.start(math.nan), "angle is nan"),
        (lambda: line_faults(a="up"), 'a is \'up\'; it must be None, "low" or "high"'),
        (lambda: line_faults(lost=1.1), "lost is 1.1; it must be finite and at least 0 and at most 1"),
        (lambda: line_faults(glitches=math.nan), "glitches is nan"),
    ],
)
def test_bad_numbers_are_named(make: object, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()  # type: ignore[operator]
