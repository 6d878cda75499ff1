"""Inputs out of seeds: each is told by the seed of the run, the reader and its number, and by nothing else."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence

__all__ = ["mutant"]

LARGEST = 65_536
"""Bytes of an input: time goes with their number, and a program of so many lines takes most of a second."""
NUMBERS = (
    b"0", b"-0", b"-1", b"1e999", b"-1e999", b"1e-400", b"nan", b"inf", b"-inf", b"9" * 400, b"9" * 6000, b"1_0",
    b"0x1f", b"4294967295", b"-2147483649", b"18446744073709551616", b"1e308", b"1e15", b"3.5", b"1e", b".", b"00", b"",
    "\u0663".encode(),
)  # fmt: skip
BYTES = (b"\0", b"\xff", b"\xfe\xff", b"\xef\xbb\xbf", b"\r", b"\x1b[31m", "\u2028\u202e".encode(), b"\xed\xa0\x80")
OPENED = ((b"[", b"]"), (b"(", b")"), (b"{", b"}"), (b"<a>", b"</a>"), (b"{a=", b"}"), (b'{"a":', b"}"), (b"-", b""))


def mutant(seeds: Sequence[bytes], words: Sequence[bytes], random_seed: str) -> bytes:
    """Return an input: one of the seeds after a few changes; of a thousand one is the seed itself."""
    rng = random.Random(random_seed)
    data = rng.choice(seeds)
    for _ in range(rng.choice((0, 1, 1, 1, 1, 2, 2, 3, 5, 8)) or int(rng.random() > 0.01)):
        data = rng.choice(CHANGES)(data, rng, seeds, words)[:LARGEST]
    return data


Change = Callable[[bytes, random.Random, Sequence[bytes], Sequence[bytes]], bytes]


def _span(data: bytes, rng: random.Random) -> tuple[int, int]:
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + rng.choice((0, 1, 2, 4, 8, 30, 200)))


def _bit(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    if not data:
        return b"\1"
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]


def _cut(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _without(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    start, end = _span(data, rng)
    return data[:start] + data[end:]


def _twice(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    start, end = _span(data, rng)
    return data[:start] + data[start:end] * rng.choice((2, 2, 2, 3, 100, 3000)) + data[end:]


def _word(data: bytes, rng: random.Random, _: Sequence[bytes], words: Sequence[bytes]) -> bytes:
    start, end = _span(data, rng)
    return data[:start] + rng.choice((*words, *BYTES, *NUMBERS)) + data[rng.choice((start, end)) :]


def _number(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    found = list(re.finditer(rb"[-+]?\d+\.?\d*", data))
    if not found:
        return data
    at = rng.choice(found)
    return data[: at.start()] + rng.choice(NUMBERS) + data[at.end() :]


def _nested(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    (before, after), times = rng.choice(OPENED), rng.choice((2, 30, 150, 5000))
    start, end = _span(data, rng)
    return data[:start] + before * times + data[start:end] + after * times + data[end:]


def _swapped(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    lines = data.split(b"\n")
    i, k = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[i], lines[k] = lines[k], lines[i]
    return b"\n".join(lines)


def _line_twice(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    lines = data.split(b"\n")
    k = rng.randrange(len(lines))
    return b"\n".join([*lines[:k], lines[k], *lines[k:]])


def _spliced(data: bytes, rng: random.Random, seeds: Sequence[bytes], _: Sequence[bytes]) -> bytes:
    other = rng.choice(seeds)
    return data[: rng.randrange(len(data) + 1)] + other[rng.randrange(len(other) + 1) :]


def _field(data: bytes, rng: random.Random, *_: Sequence[bytes]) -> bytes:
    """A number of 1 to 8 bytes, as binary formats have them, of an extreme value."""
    size = rng.choice((1, 2, 4, 8))
    value = rng.choice((0, 1, 2 ** (8 * size - 1) - 1, 2 ** (8 * size - 1), 2 ** (8 * size) - 1, rng.randrange(70000)))
    at = rng.randrange(max(1, len(data)))
    return data[:at] + (value % 2 ** (8 * size)).to_bytes(size, rng.choice(("little", "big"))) + data[at + size :]


CHANGES: tuple[Change, ...] = (
    _bit, _cut, _without, _twice, _word, _word, _number, _number, _nested, _swapped, _line_twice, _spliced, _field,
)  # fmt: skip
