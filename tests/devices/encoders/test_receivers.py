"""Line receivers: every broken or exchanged wire is told in the sample in which it shows, a healthy one never."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import (
    LINE_RECEIVERS,
    LineFault,
    LineReceiver,
    drive_pair,
    index_misplaced,
    line_receiver,
    receive_pair,
    receive_pairs,
)
from holonom.errors import ModelError, UnknownName

KINDS = sorted(LINE_RECEIVERS)


def wires(receiver: LineReceiver, phase: float) -> list[float]:
    """A+, A-, B+, B- at a phase of the line (rad)."""
    waves = math.sin(phase), math.cos(phase)
    if not receiver.analogue:
        waves = math.copysign(1.0, waves[0]), math.copysign(1.0, waves[1])
    return [w for wave in waves for w in drive_pair(receiver.params(), receiver.amplitude * wave)]


@pytest.mark.parametrize("kind", KINDS)
@given(phase=st.floats(0.0, 7.0), gain=st.floats(0.8, 1.1), noise=st.integers(0, 2**16))
def test_healthy_lines_are_healthy(kind: str, phase: float, gain: float, noise: int) -> None:
    receiver = line_receiver(kind)
    params = receiver.params()
    rough = 0.02 * receiver.amplitude * np.random.default_rng(noise).uniform(-1.0, 1.0, 4)
    middle = receiver.middle
    lines = [middle + gain * (w - middle) + r for w, r in zip(wires(receiver, phase), rough.tolist(), strict=True)]
    first, second, fault = receive_pairs(params, *lines)
    assert fault == LineFault.NONE
    assert abs(first - gain * (wires(receiver, phase)[0] - wires(receiver, phase)[1])) <= 0.05 * receiver.amplitude
    assert math.isfinite(second)


@pytest.mark.parametrize("wire", range(4))
@pytest.mark.parametrize("kind", KINDS)
@given(phase=st.floats(0.0, 7.0))
def test_a_broken_wire_is_told_in_the_same_sample(kind: str, wire: int, phase: float) -> None:
    receiver = line_receiver(kind)
    lines = wires(receiver, phase)
    lines[wire] = receiver.pull
    assert receive_pairs(receiver.params(), *lines)[2] == LineFault.BROKEN
    assert receive_pair(receiver.params(), *lines[wire // 2 * 2 : wire // 2 * 2 + 2])[1] == LineFault.BROKEN
    lines[wire] = math.nan
    assert receive_pairs(receiver.params(), *lines)[2] == LineFault.BROKEN


@pytest.mark.parametrize("phase", [0.3, 2.0, 3.5, 5.0])
def test_an_open_wire_that_follows_its_partner_through_the_termination_is_broken(phase: float) -> None:
    receiver = line_receiver("rs422")
    lines = wires(receiver, phase)
    lines[1] = lines[0]
    assert receive_pairs(receiver.params(), *lines)[2] == LineFault.BROKEN


@pytest.mark.parametrize("kind", KINDS)
def test_a_cable_that_is_pulled_is_broken(kind: str) -> None:
    receiver = line_receiver(kind)
    fault = receive_pairs(receiver.params(), *[receiver.pull] * 4)[2]
    assert fault == (LineFault.BROKEN if receiver.analogue else LineFault.WEAK)


@pytest.mark.parametrize("pair", [(0, 2), (0, 3), (1, 2), (1, 3)])
def test_exchanged_wires_of_two_pairs_are_told_where_they_differ(pair: tuple[int, int]) -> None:
    """RS-422: two of the four states of a line."""
    receiver = line_receiver("rs422")
    faults = []
    for phase in (0.25 * math.pi, 0.75 * math.pi, 1.25 * math.pi, 1.75 * math.pi):
        lines = wires(receiver, phase)
        a, b = pair
        same = lines[a] == lines[b]
        lines[a], lines[b] = lines[b], lines[a]
        fault = receive_pairs(receiver.params(), *lines)[2]
        assert fault == (LineFault.NONE if same else LineFault.SWAPPED)
        faults.append(fault)
    assert faults.count(LineFault.SWAPPED) == 2


def test_exchanged_wires_of_sines_are_told_within_a_line() -> None:
    receiver = line_receiver("sine_1vpp")
    faults = set()
    for phase in np.linspace(0.0, 2.0 * math.pi, 64):
        a_plus, a_minus, b_plus, b_minus = wires(receiver, float(phase))
        faults.add(receive_pairs(receiver.params(), a_plus, b_minus, b_plus, a_minus)[2])
    assert LineFault.SWAPPED in faults
    assert LineFault.BROKEN not in faults


@pytest.mark.parametrize("gain", [0.5, 1.4])
def test_signals_of_the_wrong_size_are_weak(gain: float) -> None:
    receiver = line_receiver("sine_1vpp")
    for phase in np.linspace(0.0, 6.0, 20):
        lines = [receiver.middle + gain * (w - receiver.middle) for w in wires(receiver, float(phase))]
        assert receive_pairs(receiver.params(), *lines)[2] == LineFault.WEAK


def test_levels_that_hardly_differ_are_weak() -> None:
    """TIA/EIA-422: 0.2 V."""
    params = line_receiver("rs422").params()
    assert receive_pair(params, 2.59, 2.41)[1] == LineFault.WEAK
    assert receive_pair(params, 2.61, 2.39)[1] == LineFault.NONE


def test_an_inverted_index_is_told_at_once_but_where_it_is_due() -> None:
    healthy = [levels | (4 if levels == 0 else 0) for levels in range(4)]
    assert not any(index_misplaced(levels) for levels in healthy)
    inverted = [levels ^ 4 for levels in healthy]
    assert [index_misplaced(levels) for levels in inverted] == [False, True, True, True]


def test_an_inverted_channel_is_told_at_the_index() -> None:
    assert index_misplaced(4 | 1)
    assert index_misplaced(4 | 2)


@pytest.mark.parametrize(
    ("make", "error", "named"),
    [
        (
            lambda: line_receiver("rs485"),
            UnknownName,
            "'rs485'; there is current_11ua, rs422, sine_1vpp",
        ),
        (lambda: LineReceiver(amplitude=0.1), ModelError, "amplitude is 0.1; it must lie within least 0.2 and most 10"),
        (lambda: LineReceiver(pull=4.0), ModelError, "an open wire goes to 4, 0.5 from where a healthy one may be"),
        (lambda: LineReceiver(middle=math.nan), ModelError, "middle is nan"),
    ],
)
def test_bad_receivers_are_named(make: object, error: type[Exception], named: str) -> None:
    with pytest.raises(error, match=named):
        make()  # type: ignore[operator]
