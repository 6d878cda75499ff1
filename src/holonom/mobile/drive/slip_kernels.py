"""Slip of one wheel (or two) from wheel speeds, sample by sample; compiled, nothing is checked or allocated.

Every *hypothesis* is a set of wheels that may slip; row 0 is the empty one. For each, `slip.slip_params` holds the
least-squares inverse that leaves those wheels out, the chi-square bound of what the others may disagree, and how far
its twist may lie from a second source.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.trace.code.loops import loop

__all__ = ["AMBIGUOUS", "NO_SLIP", "SLIP", "UNDETECTABLE", "SlipParams", "SlipSample", "SlipState", "slip_samples",
           "slip_start", "slip_step"]  # fmt: skip

NO_SLIP, SLIP, AMBIGUOUS, UNDETECTABLE = 0, 1, 2, 3
"""Codes of `SlipStatus`."""

LEFT_OUT, BOUND, LINEAR, ANGULAR, RATE, INVERSE = 0, 1, 2, 3, 4, 5
"""Columns of `SlipParams.hypotheses`: set of wheels left out; bound of the weighted square sum of what remains; how far
noise alone carries the twist from the last one (linear, R w) and R w from the gyro's, m/s; then the least-squares
inverse without those wheels, vx, vy, R w per rim speed, wheel after wheel."""

Integers = NDArray[np.int64]


class SlipParams(NamedTuple):
    """What `slip_step` needs of a base, its noise and its limits; made by `slip_params`.

    n wheels, h hypotheses; wheel i is bit `1 << i` of a set. Twists are (vx, vy, R w) in m/s. Two arrays only: each one
    costs compiled calls some nanoseconds.
    """

    dt: float
    radius: float
    rows: Array  # (n, 4): row of D and 1 / noise (s/m) of each wheel
    hypotheses: Array  # (h, 5 + 3 n), columns below
    max_acceleration: float  # m/s2
    max_turning: float  # R times angular acceleration, m/s2
    acceleration_error: float  # where an acceleration is measured, m/s2
    turning_error: float
    suspects: int  # the wheels that a second source can contradict
    redundancy: int  # n - 3
    margin: float  # distance from the second sources, as a share of what is allowed, that a hypothesis is ruled out at
    pivot: int  # n = 4: wheel whose residual shows the sign of what no twist explains; else -1
    persistence: int  # samples until slip is raised, or falls
    confirmation: int  # samples that must agree on a name
    most: int  # wheels that are allowed for slipping at once


class SlipState(NamedTuple):
    """What slip detection carries from sample to sample; `slip_start()` before the first."""

    vx: float  # the last twist trusted, carried along since
    vy: float
    rw: float
    slack: float  # how far limits let it move since, m/s
    angular_slack: float
    held_x: float  # the same of the last sample in which nothing slipped, whatever was named since
    held_y: float
    held_rw: float
    held_slack: float
    held_angular_slack: float
    level: int  # samples above the bound, less those below
    raised: bool
    pending: int  # wheels that the last samples name
    agreed: int  # how many samples did so
    named: int
    doubt: int  # how strongly the last samples speak against the name
    side: int  # n = 4: sign of the residual since slip began
    mixed: bool  # n = 4: more than one wheel must have slipped since


class SlipSample(NamedTuple):
    """What one sample says.

    `status` is NO_SLIP, SLIP, AMBIGUOUS or UNDETECTABLE; `named` the set of wheels known to slip (bit i: wheel i);
    `candidates` the set of those that may; (vx, vy, rw) the twist (vx, vy, R w) in m/s without them; `statistic`
    the weighted square sum of the residual of all wheels.
    """

    status: int
    named: int
    candidates: int
    vx: float
    vy: float
    rw: float
    statistic: float


@loop(error_model="numpy")
def slip_start() -> SlipState:
    """State before the first sample: no twist is trusted yet."""
    inf = math.inf
    return SlipState(0.0, 0.0, 0.0, inf, inf, 0.0, 0.0, 0.0, inf, inf, 0, False, 0, 0, 0, 0, 0, False)


@loop(error_model="numpy")
def slip_step(
    params: SlipParams, state: SlipState, speeds: Array, rate: float, acceleration: Array
) -> tuple[SlipState, SlipSample]:
    """Take one sample of wheel speeds; return the next state and what the sample says (specification 6.2).

    Parameters
    ----------
    params, state
        From `slip_params`; from the last call, at first `slip_start()`.
    speeds
        (n,) rim speeds r phid in m/s, in the order of D's rows.
    rate
        Gyro in rad/s; NaN where there is none.
    acceleration
        (3,) of the base in base_link: ax, ay, R wd in m/s2, from motor currents (`C_alpha f / M`) or accelerometers;
        NaN where it is not known.

    Notes
    -----
    Slip is raised when the residual of all wheels was above its bound `persistence` times more often than below. A
    hypothesis stands if the wheels it keeps agree, its turning rate agrees with the gyro's, and its twist can have
    come of the last trusted one and of that before the slip began. What all standing hypotheses share is named once
    `confirmation` samples in a row say so. A name goes when as many samples say nothing or prefer another one, at
    once when two in a row contradict it. Without redundancy (three wheels) a second source can only contradict.

    Four wheels cannot tell two that slip from one, and the residual has one sign. If that changes, or a name is
    contradicted, more than one wheel slips: nothing is named until the slip is over.
    """
    vx, vy, rw, statistic = _fit(params, 0, speeds)
    if (
        params.redundancy > 0
        and state.level == 0
        and state.held_slack == 0.0
        and statistic <= params.hypotheses[0, BOUND]
    ):
        return _trust(state, vx, vy, rw), SlipSample(NO_SLIP, 0, 0, vx, vy, rw, statistic)
    last = _carry(params, state, rate, acceleration)
    known = math.isfinite(rate) or math.isfinite(last.slack)
    above = params.redundancy > 0 and not statistic <= params.hypotheses[0, BOUND]
    if not above and (params.redundancy == 0 or state.held_slack > 0.0):
        above = not _distance(params, 0, last, vx, vy, rw, rate) <= 1.0
    common, union, best = 0, 0, 0
    if above and params.redundancy > 0:
        common, union, best = _standing(params, last, speeds, rate)
    after = _debounce(params, last, above, common, union if best > 0 else 0, int(params.hypotheses[best, LEFT_OUT]),
                      _side(params, speeds, vx, vy, rw) if above else 0)  # fmt: skip
    if best > 0 and (known or after.named != 0):
        vx, vy, rw, _ = _fit(params, best, speeds)
    if after.level == 0 or (
        after.raised and after.named != 0 and int(params.hypotheses[best, LEFT_OUT]) == after.named
    ):
        after = _trust(after, vx, vy, rw)
    return after, _sample(params, after, union, vx, vy, rw, statistic)


@loop(error_model="numpy")
def slip_samples(
    params: SlipParams, state: SlipState, speeds: Array, rate: Array, acceleration: Array,
    status: Integers, wheels: Integers, twist: Array, statistic: Array,
) -> SlipState:  # fmt: skip
    """`slip_step` over (N, n), (N,), (N, 3); write status (N,), named and candidates (N, 2), twist, statistic."""
    for k in range(speeds.shape[0]):
        state, said = slip_step(params, state, speeds[k], rate[k], acceleration[k])
        status[k], statistic[k] = said.status, said.statistic
        wheels[k, 0], wheels[k, 1] = said.named, said.candidates
        twist[k, 0], twist[k, 1], twist[k, 2] = said.vx, said.vy, said.rw
    return state


@loop(error_model="numpy")
def _sample(
    params: SlipParams, state: SlipState, union: int, vx: float, vy: float, rw: float, statistic: float
) -> SlipSample:
    """Status of the state after this sample."""
    if not state.raised:
        status = NO_SLIP if params.redundancy > 0 else UNDETECTABLE
        return SlipSample(status, 0, 0, vx, vy, rw, statistic)
    if state.named != 0:
        return SlipSample(SLIP, state.named, state.named, vx, vy, rw, statistic)
    return SlipSample(AMBIGUOUS, 0, union if union != 0 else params.suspects, vx, vy, rw, statistic)


@loop(error_model="numpy")
def _carry(params: SlipParams, state: SlipState, rate: float, acceleration: Array) -> SlipState:
    """Last trusted twist in base_link one sample later: the frame turns under it, the base may accelerate."""
    dt = params.dt
    w = rate if math.isfinite(rate) else state.rw / params.radius
    vx, vy, rw = state.vx + dt * w * state.vy, state.vy - dt * w * state.vx, state.rw
    ex, ey = vx, vy
    slack, angular = params.max_acceleration, params.max_turning
    if math.isfinite(acceleration[0]) and math.isfinite(acceleration[1]):
        vx, vy, slack = vx + dt * acceleration[0], vy + dt * acceleration[1], params.acceleration_error
    if math.isfinite(acceleration[2]):
        rw, angular = rw + dt * acceleration[2], params.turning_error
    hx, hy = state.held_x + dt * w * state.held_y, state.held_y - dt * w * state.held_x
    return SlipState(
        vx, vy, rw, state.slack + dt * slack, state.angular_slack + dt * angular,
        hx + vx - ex, hy + vy - ey, state.held_rw + rw - state.rw,
        state.held_slack + dt * slack, state.held_angular_slack + dt * angular,
        state.level, state.raised, state.pending, state.agreed, state.named, state.doubt, state.side, state.mixed,
    )  # fmt: skip


@loop(error_model="numpy")
def _trust(state: SlipState, vx: float, vy: float, rw: float) -> SlipState:
    """Trust a twist; where nothing slips, hold it as the one before the next slip."""
    hx, hy, hr, slack, angular = (
        state.held_x, state.held_y, state.held_rw, state.held_slack, state.held_angular_slack,
    )  # fmt: skip
    if state.level == 0:
        hx, hy, hr, slack, angular = vx, vy, rw, 0.0, 0.0
    return SlipState(vx, vy, rw, 0.0, 0.0, hx, hy, hr, slack, angular, state.level, state.raised, state.pending,
                     state.agreed, state.named, state.doubt, state.side, state.mixed)  # fmt: skip


@loop(error_model="numpy")
def _side(params: SlipParams, speeds: Array, vx: float, vy: float, rw: float) -> int:
    """Sign of the residual where it has one direction only; 0 where it has more."""
    i = params.pivot
    if i < 0:
        return 0
    left = speeds[i] - params.rows[i, 0] * vx - params.rows[i, 1] * vy - params.rows[i, 2] * rw
    return 1 if left > 0.0 else -1 if left < 0.0 else 0


@loop(error_model="numpy")
def _fit(params: SlipParams, h: int, speeds: Array) -> tuple[float, float, float, float]:
    """Twist of hypothesis h, and the weighted square sum of what it leaves of the wheels that it keeps."""
    rows, table = params.rows, params.hypotheses
    n, left_out = speeds.shape[0], int(table[h, LEFT_OUT])
    vx, vy, rw = 0.0, 0.0, 0.0
    for i in range(n):
        if not (left_out >> i) & 1:
            vx += table[h, INVERSE + 3 * i] * speeds[i]
            vy += table[h, INVERSE + 3 * i + 1] * speeds[i]
            rw += table[h, INVERSE + 3 * i + 2] * speeds[i]
    total = 0.0
    for i in range(n):
        if not (left_out >> i) & 1:
            left = rows[i, 3] * (speeds[i] - rows[i, 0] * vx - rows[i, 1] * vy - rows[i, 2] * rw)
            total += left * left
    return vx, vy, rw, total


@loop(error_model="numpy")
def _distance(params: SlipParams, h: int, last: SlipState, vx: float, vy: float, rw: float, rate: float) -> float:
    """How far the twist of hypothesis h is from the second sources, as a share of what noise and limits allow."""
    own, turn = params.hypotheses[h, LINEAR], params.hypotheses[h, ANGULAR]
    linear = math.hypot(vx - last.vx, vy - last.vy) / (own + last.slack)
    farthest = max(linear, abs(rw - last.rw) / (turn + last.angular_slack))
    linear = math.hypot(vx - last.held_x, vy - last.held_y) / (own + last.held_slack)
    farthest = max(farthest, linear, abs(rw - last.held_rw) / (turn + last.held_angular_slack))
    if math.isfinite(rate):
        farthest = max(farthest, abs(rw - params.radius * rate) / params.hypotheses[h, RATE])
    return farthest


@loop(error_model="numpy")
def _standing(params: SlipParams, last: SlipState, speeds: Array, rate: float) -> tuple[int, int, int]:
    """Wheels common to all standing hypotheses, wheels of any of them, and the nearest to the second sources.

    Two wheels are tried where no single wheel will do, or always if `most` is 2. Among the nearest, those that hold
    the wheels named so far come first. Where wheel speeds leave hypotheses but the second sources contradict every
    one, nothing is common, the wheels of all are returned, and 0.
    """
    common, union, possible, best, size = -1, 0, 0, 0, 0
    nearest = math.inf
    for h in range(1, params.hypotheses.shape[0]):
        wheels = int(params.hypotheses[h, LEFT_OUT])
        pair = wheels & (wheels - 1) != 0
        if pair and size == 1 and params.most == 1:
            break
        vx, vy, rw, left = _fit(params, h, speeds)
        if not left <= params.hypotheses[h, BOUND]:
            continue
        possible |= wheels
        size = max(size, 2 if pair else 1)
        distance = _distance(params, h, last, vx, vy, rw, rate)
        if not distance <= (1.0 if last.named != 0 else params.margin):
            continue
        common &= wheels
        if not distance <= 1.0:
            continue
        union |= wheels
        distance += (1.0 if wheels & last.named != last.named else 0.0) + (2.0 if pair else 0.0)
        if distance < nearest:
            nearest, best = distance, h
    if best == 0:
        return 0, possible, 0
    return common, union, best


@loop(error_model="numpy")
def _debounce(
    params: SlipParams, state: SlipState, above: bool, common: int, standing: int, nearest: int, side: int
) -> SlipState:
    """Count this sample: raise and release slip, confirm a name, drop one that no longer stands."""
    level = min(state.level + 1, params.persistence) if above else max(state.level - 1, 0)
    raised = level == params.persistence or (state.raised and level > 0)
    pending, agreed, named, mixed = state.pending, state.agreed, state.named, state.mixed or side * state.side < 0
    doubt = _doubt(params, state, above, common, standing, nearest)
    if above:
        agreed = min(agreed + 1, params.confirmation) if common == pending else 1
        pending = common
    if mixed or doubt >= params.confirmation:
        mixed = mixed or (params.pivot >= 0 and above)
        pending, agreed, named, doubt = 0, 0, 0, 0
    elif agreed == params.confirmation and pending != 0 and (pending & named == named or params.pivot < 0):
        named = pending
    if level == 0:
        pending, agreed, named, doubt, side, mixed = 0, 0, 0, 0, 0, False
    elif side == 0:
        side = state.side
    x, y, r, slack, angular = state.vx, state.vy, state.rw, state.slack, state.angular_slack
    if state.named != 0 and named == 0:  # the twist that was trusted with it, is not
        x, y, r = state.held_x, state.held_y, state.held_rw
        slack, angular = state.held_slack, state.held_angular_slack
    return SlipState(x, y, r, slack, angular, state.held_x, state.held_y, state.held_rw, state.held_slack,
                     state.held_angular_slack, level, raised, pending, agreed, named, doubt, side, mixed)  # fmt: skip


@loop(error_model="numpy")
def _doubt(params: SlipParams, state: SlipState, above: bool, common: int, standing: int, nearest: int) -> int:
    """How strongly this and the last samples speak against the name, in samples; two that contradict it suffice."""
    named = state.named
    if named == 0 or (common != 0 and common & named == named):
        return 0
    if above and standing & named == named:
        return state.doubt + (1 if nearest != named else 0)
    return state.doubt + ((params.confirmation + 1) // 2 if above else 1)
