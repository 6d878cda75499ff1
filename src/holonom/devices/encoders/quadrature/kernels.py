"""Compiled steps of a quadrature encoder: what its lines carry, and what a decoder makes of every edge.

A quarter is a quarter of a line: the angle between two edges. Levels are bits: A is 1, B is 2, the index is 4.
Forward, A leads: A, B = 00, 10, 11, 01. The index is high in the one quarter a turn that begins at angle 0; A and B are
low there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.trace.code.loops import loop

__all__ = [
    "HEALTHY",
    "LineFaults",
    "QuadratureParams",
    "QuadratureState",
    "decode_levels",
    "fault_levels",
    "healthy_step",
    "line_levels",
    "quadrature_step",
]


class QuadratureParams(NamedTuple):
    """Quarters per radian and per turn; halvings of the count: 0 for 4x decoding, 1 for 2x, 2 for 1x."""

    quarters_per_rad: float
    quarters_per_rev: int
    halvings: int


class LineFaults(NamedTuple):
    """What is wrong with the lines.

    Levels at which A, B, index stick (-1: they do not), whether A and B are swapped, shares of the edges that the
    counter loses and that a glitch on the other channel meets.
    """

    a: int = -1
    b: int = -1
    z: int = -1
    swapped: int = 0
    lost: float = 0.0
    glitches: float = 0.0


HEALTHY = LineFaults()
"""Lines without a fault."""

FARTHEST = 1 << 24
"""Edges that are followed one by one in a step; no shaft makes more, and an angle that is no number hangs no loop."""


class QuadratureState(NamedTuple):
    """Shaft, decoder, counter.

    The shaft's quarter and its place within the turn; levels that the decoder saw last; the count; transitions that no
    shaft makes; edges of A and of B; index pulses, and the count at the last one; parts of the next lost edge, glitch.
    """

    quarter: int
    place: int
    levels: int
    counts: int
    illegal: int
    edges_a: int
    edges_b: int
    pulses: int
    index_count: int
    losing: float
    bouncing: float


@loop(error_model="numpy", forceinline=True)
def line_levels(quarter: int, place: int) -> int:
    """Levels of healthy lines in a quarter (any number), which is number `place` of its turn."""
    phase = quarter & 3
    return (phase ^ (phase >> 1)) | (4 if place == 0 else 0)


@loop
def fault_levels(faults: LineFaults, levels: int) -> int:
    """Levels that arrive of those that were sent."""
    a, b, index = levels & 1, (levels >> 1) & 1, (levels >> 2) & 1
    if faults.swapped:
        a, b = b, a
    if faults.a >= 0:
        a = faults.a
    if faults.b >= 0:
        b = faults.b
    if faults.z >= 0:
        index = faults.z
    return a | (b << 1) | (index << 2)


@loop
def decode_levels(params: QuadratureParams, state: QuadratureState, levels: int, taken: bool) -> QuadratureState:
    """One reading of the lines: the decoder's state machine.

    One channel changed: a quarter on or back, which is a count at each edge (4x), at each edge of A (2x), at the edge
    of A while B is low (1x). Both changed: illegal, an edge was missed, nothing is counted. The rising index latches
    the count. `taken`: whether the counter takes the pulse.
    """
    before, now = state.levels & 3, levels & 3
    first, second = before ^ (before >> 1), now ^ (now >> 1)
    moved = (second - first) & 3
    count, illegal = state.counts, state.illegal
    every = (1 << params.halvings) - 1
    if moved == 2:
        illegal += 1
    elif taken:
        if moved == 1 and first & every == 0:
            count += 1
        elif moved == 3 and second & every == 0:
            count -= 1
    rises = levels & ~state.levels & 4
    return QuadratureState(
        state.quarter,
        state.place,
        levels,
        count,
        illegal,
        state.edges_a + ((before ^ now) & 1),
        state.edges_b + ((before ^ now) >> 1),
        state.pulses + (1 if rises else 0),
        count if rises else state.index_count,
        state.losing,
        state.bouncing,
    )


@loop(error_model="numpy", forceinline=True)
def quadrature_step(
    params: QuadratureParams, faults: LineFaults, state: QuadratureState, angle: float
) -> QuadratureState:
    """The shaft is now at an angle (rad): every edge since the last step reaches the decoder, in order.

    Without a fault, and once the decoder has seen what the lines carry, edges are counted in closed form; the state is
    the same to the bit.
    """
    quarter = math.floor(angle * params.quarters_per_rad)
    wrong = (faults.a & faults.b & faults.z) != -1 or faults.swapped != 0
    rough = faults.lost > 0.0 or faults.glitches > 0.0
    near = -FARTHEST < quarter - state.quarter < FARTHEST
    if near and (wrong or rough or state.levels != line_levels(state.quarter, state.place)):
        return _follow(params, faults, state, quarter)
    if quarter == state.quarter:
        return state
    return _jump(params, state, quarter)


@loop(error_model="numpy", forceinline=True)
def healthy_step(params: QuadratureParams, state: QuadratureState, angle: float) -> QuadratureState:
    """`quadrature_step` after another one without a fault, where there is none now either."""
    quarter = math.floor(angle * params.quarters_per_rad)
    return state if quarter == state.quarter else _jump(params, state, quarter)


@loop(error_model="numpy", forceinline=True)
def _jump(params: QuadratureParams, state: QuadratureState, quarter: int) -> QuadratureState:
    """All edges to a quarter at once, of healthy lines."""
    moved, per_rev, h = quarter - state.quarter, params.quarters_per_rev, params.halvings
    counted = (state.quarter - 1) >> h
    count = state.counts + ((quarter - 1) >> h) - counted
    place, pulses, index_count = state.place + moved, state.pulses, state.index_count
    if moved > 0 and place >= per_rev:
        turns = place // per_rev
        pulses += turns
        place -= turns * per_rev
        index_count = state.counts + ((quarter - place - 1) >> h) - counted
    elif moved < 0 and place <= 0:
        turns = (state.place - 1) // per_rev - (place - 1) // per_rev
        place -= (place // per_rev) * per_rev
        pulses += turns
        if turns > 0:
            to_index = per_rev - place if place > 0 else 0
            index_count = state.counts + ((quarter + to_index - 1) >> h) - counted
    return QuadratureState(
        quarter,
        place,
        line_levels(quarter, place),
        count,
        state.illegal,
        state.edges_a + abs(((quarter + 1) >> 1) - ((state.quarter + 1) >> 1)),
        state.edges_b + abs((quarter >> 1) - (state.quarter >> 1)),
        pulses,
        index_count,
        state.losing,
        state.bouncing,
    )


@loop
def _follow(params: QuadratureParams, faults: LineFaults, state: QuadratureState, quarter: int) -> QuadratureState:
    """Edge by edge."""
    at, place, sign = state.quarter, state.place, 1 if quarter > state.quarter else -1
    losing, bouncing = state.losing, state.bouncing
    state = decode_levels(params, state, fault_levels(faults, line_levels(at, place)), True)
    while at != quarter:
        at += sign
        place += sign
        if place == params.quarters_per_rev:
            place = 0
        elif place < 0:
            place = params.quarters_per_rev - 1
        levels = fault_levels(faults, line_levels(at, place))
        losing += faults.lost
        taken = losing < 1.0
        losing -= 0.0 if taken else 1.0
        bouncing += faults.glitches
        if bouncing >= 1.0:
            bouncing -= 1.0
            other = 3 ^ ((state.levels ^ levels) & 3)  # the channel that has no edge now
            state = decode_levels(params, state, levels ^ other, taken)
        state = decode_levels(params, state, levels, taken)
    return QuadratureState(
        at,
        place,
        state.levels,
        state.counts,
        state.illegal,
        state.edges_a,
        state.edges_b,
        state.pulses,
        state.index_count,
        losing,
        bouncing,
    )
