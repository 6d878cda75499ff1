"""Gray code, turns, and frames: round trips, published frames, and exactly the errors that a CRC cannot see."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import FRAMES, crc, decode_frame, encode_frame, gray_decode, gray_encode, join_turns, split_turns
from holonom.errors import OutOfLimits, ShapeError, UnknownName

OPTIONS = {"ssi": ("gray", "even_parity"), "endat": ("alarm",), "biss": ("n_error", "n_warning")}


def case(folder: Path, name: str) -> dict[str, Any]:
    cases = json.loads((folder / "control" / "open_cases.json").read_text("utf-8"))
    return next(case for case in cases if case["id"].startswith(name))


@st.composite
def positions(draw: st.DrawFn) -> tuple[int, int]:
    bits = draw(st.integers(1, 64))
    return bits, draw(st.integers(0, 2**bits - 1))


@pytest.mark.parametrize("kind", ["ssi", "endat", "biss"])
def test_published_frames(kind: str, data_folder: Path) -> None:
    for row in case(data_folder, f"frames {kind}")["expected"]["frames"]:
        flags = {name: row[name] for name in OPTIONS[kind]} if kind != "ssi" else {}
        assert encode_frame(kind, row["position"], bits=row["bits"], **flags) == row["frame"]
        decoded = decode_frame(kind, row["frame"], bits=row["bits"])
        assert decoded.ok
        assert decoded.position == row["position"]
        for name in (*OPTIONS[kind], *(["crc"] if "crc" in row else [])):
            assert getattr(decoded, name) == row[name]


@pytest.mark.parametrize("parity", ["none", "even", "odd"])
@given(positions())
def test_ssi_round_trip(parity: str, given: tuple[int, int]) -> None:
    bits, position = given
    frame = encode_frame("ssi", position, bits=bits, parity=parity)
    decoded = decode_frame("ssi", frame, bits=bits, parity=parity)
    assert (decoded.position, decoded.ok, decoded.fault) == (position, True, "")
    if parity != "none":
        assert frame.count("1") % 2 == (parity == "odd")


@given(positions(), st.integers(0, 1), st.integers(0, 1))
def test_round_trips_with_flags(given: tuple[int, int], first: int, second: int) -> None:
    bits, position = given
    decoded = decode_frame("endat", encode_frame("endat", position, bits=bits, alarm=first), bits=bits)
    assert (decoded.position, decoded.alarm, decoded.ok) == (position, first, True)
    frame = encode_frame("biss", position, bits=bits, n_error=first, n_warning=second)
    decoded = decode_frame("biss", frame, bits=bits)
    assert (decoded.position, decoded.n_error, decoded.n_warning, decoded.ok) == (position, first, second, True)


def flipped(frame: str, places: tuple[int, ...]) -> str:
    return "".join(str(1 - int(bit)) if k in places else bit for k, bit in enumerate(frame))


def undetected(kind: str, frame: str, bits: int, patterns: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    return [places for places in patterns if decode_frame(kind, flipped(frame, places), bits=bits).ok]


def test_undetected_errors_of_the_published_frame(data_folder: Path) -> None:
    """Every error in alarm, position and CRC; the start bit is seen anyhow."""
    expected = case(data_folder, "undetected errors")
    bits, known = expected["input"]["bits"], expected["expected"]
    frame = encode_frame("endat", 0x155_5555 & (2**bits - 1), bits=bits)
    places = range(1, len(frame))
    pairs = list(itertools.combinations(places, 2))
    missed = undetected("endat", frame, bits, pairs)
    assert len(pairs) == 465
    assert len(missed) == known["double_of_465"]
    assert {b - a for a, b in missed} == {15, 30}
    assert len(undetected("endat", frame, bits, [(k,) for k in places])) == known["single"]
    assert len(undetected("endat", frame, bits, list(itertools.combinations(places, 3)))) == known["triple"]
    bursts = [
        (k, *(k + j for j in inner), k + length - 1) if length > 1 else (k,)
        for length in range(1, 6)
        for k in range(1, len(frame) - length + 1)
        for n in range(max(length - 1, 1))
        for inner in itertools.combinations(range(1, length - 1), n)
    ]
    assert len(undetected("endat", frame, bits, bursts)) == known["bursts_to_5"]


def test_a_crc_6_sees_every_double_error_within_63_bits() -> None:
    """x^6 + x + 1 is primitive: the order of x is 63."""
    frame = encode_frame("biss", 0x2AAAA, bits=18)
    pairs = list(itertools.combinations(range(2, len(frame)), 2))
    assert undetected("biss", frame, 18, pairs) == []


def test_a_parity_bit_sees_odd_errors_only() -> None:
    frame = encode_frame("ssi", 77, bits=13, parity="even")
    seen = [decode_frame("ssi", flipped(frame, tuple(range(n))), bits=13, parity="even").ok for n in range(6)]
    assert seen == [True, False] * 3


@given(st.text("01", min_size=1, max_size=40), st.integers(1, 63), st.integers(0, 63))
def test_the_register_is_the_remainder_of_a_long_division(message: str, polynomial: int, start: int) -> None:
    """Independent: the message as a number, its first bits xor the start value, divided in one go."""
    whole = 1 << 6 | polynomial
    number = int(message, 2) << 6 ^ start << len(message)
    for k in range(len(message) + 5, 5, -1):
        if number >> k & 1:
            number ^= whole << (k - 6)
    assert crc(message, polynomial=polynomial, width=6, start=start) == number


@pytest.mark.parametrize("bits", [1, 2, 5, 10])
def test_gray_neighbours_differ_in_one_bit_round_the_circle(bits: int) -> None:
    codes = [gray_encode(value, bits=bits) for value in range(2**bits)]
    assert sorted(codes) == list(range(2**bits))
    assert all((a ^ b).bit_count() == 1 for a, b in itertools.pairwise([*codes, codes[0]]))


@given(st.integers(1, 300).flatmap(lambda bits: st.tuples(st.just(bits), st.integers(0, 2**bits - 1))))
def test_gray_round_trip_of_any_number_of_bits(given: tuple[int, int]) -> None:
    bits, value = given
    assert gray_decode(gray_encode(value, bits=bits), bits=bits) == value
    by_hand = value
    for k in range(bits - 1):
        by_hand ^= (value >> (k + 1) & 1) << k
    assert gray_encode(value, bits=bits) == by_hand


@given(st.integers(-2048, 2047), st.integers(0, 8191))
def test_turns_round_trip(turn: int, step: int) -> None:
    position = join_turns(turn % 4096, step, bits=13, turn_bits=12)
    assert split_turns(position, bits=13, turn_bits=12, signed=True) == (turn, step)
    assert split_turns(position, bits=13, turn_bits=12) == (turn % 4096, step)
    assert decode_frame("endat", encode_frame("endat", position, bits=25), bits=25).position == position


def test_damage_is_told_with_what_came_and_what_was_due() -> None:
    frame = encode_frame("endat", 4660, bits=13)
    decoded = decode_frame("endat", flipped(frame, (len(frame) - 1,)), bits=13)
    assert (decoded.ok, decoded.crc) == (False, (decoded.due or 0) ^ 1)
    assert decoded.fault == f"CRC is {decoded.crc}; the bits that came make {decoded.due}"
    assert decode_frame("endat", "0" + frame[1:], bits=13).fault == "start bit is 0; it must be 1"
    biss = encode_frame("biss", 5, bits=18)
    assert decode_frame("biss", "11" + biss[2:], bits=18).fault == "a frame begins with 11; it must begin with 10"
    assert "CRC is" in decode_frame("biss", flipped(biss, (7,)), bits=18).fault
    ssi = encode_frame("ssi", 1, bits=13, parity="even")
    assert decode_frame("ssi", flipped(ssi, (13,)), bits=13, parity="even").fault == (
        "parity bit is 0; 1 ones and even parity make 1"
    )


def test_the_table_lists_the_kinds() -> None:
    assert set(FRAMES.own) == set(OPTIONS)


@pytest.mark.parametrize(
    ("make", "error", "named"),
    [
        (lambda: encode_frame("can", 1, bits=13), UnknownName, "no kind of frame 'can'; there is biss, endat, ssi"),
        (
            lambda: encode_frame("ssi", 8192, bits=13),
            OutOfLimits,
            "8192; it must be a whole number from 0 to 8191",
        ),
        (lambda: encode_frame("endat", -1, bits=13), OutOfLimits, "position is -1"),
        (lambda: encode_frame("biss", cast(int, 1.5), bits=13), OutOfLimits, "position is 1.5"),
        (lambda: encode_frame("endat", 1, bits=0), OutOfLimits, "bits is 0; it must be 1 to 64"),
        (lambda: encode_frame("endat", 1, bits=13, alarm=2), OutOfLimits, "alarm is 2; it must be 0 or 1"),
        (
            lambda: encode_frame("biss", 1, bits=13, alarm=1),
            OutOfLimits,
            "alarm is no option of biss",
        ),
        (lambda: encode_frame("endat", 1, bits=13, parity="odd"), OutOfLimits, "parity is no option of endat"),
        (lambda: encode_frame("ssi", 1, bits=13, parity="mark"), UnknownName, "'mark'; there is even, none, odd"),
        (
            lambda: decode_frame("endat", "101", bits=13),
            ShapeError,
            "3 bits; one of endat has 20: start, alarm, 13",
        ),
        (lambda: decode_frame("biss", "10" * 3, bits=18), ShapeError, "frame has 6 bits; one of biss has 28"),
        (lambda: decode_frame("ssi", "2" * 13, bits=13), ShapeError, "it must be a string of 0 and 1"),
        (lambda: gray_encode(4, bits=2), OutOfLimits, "value is 4; it must be a whole number from 0 to 3"),
        (lambda: gray_decode(True, bits=2), OutOfLimits, "code is True"),
        (lambda: gray_encode(1, bits=2000), OutOfLimits, "bits is 2000; it must be a whole number from 1 to 1024"),
        (lambda: join_turns(4096, 0, bits=13, turn_bits=12), OutOfLimits, "turn is 4096"),
        (lambda: crc("1", polynomial=64, width=6), OutOfLimits, "polynomial is 64"),
    ],
)
def test_bad_input_is_named(make: object, error: type[Exception], named: str) -> None:
    with pytest.raises(error, match=named):
        make()  # type: ignore[operator]
