"""Compiled functions that differ in what is around them only: each finds its own machine code, and that only."""

from __future__ import annotations

import math
import os
import time
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest
from kernel_log import compile_seconds
from numba import float64, types

from holonom.trace.code import simd
from holonom.trace.code.loops import _identity, callback, loop
from holonom.trace.code.sources import stamp


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOLONOM_CACHE", str(tmp_path))
    monkeypatch.setenv("HOLONOM_CACHE_LOG", str(tmp_path / "log"))


@loop(float64(float64))
def down(x):
    return 0.0 if x < 1.0 else x + down(x - 1.0)


def pair():
    # fmt: off
    return loop(lambda x: math.floor(x)), loop(lambda x: math.ceil(x)), loop(lambda x: math.ceil(x) + 2.0)
    # fmt: on


def around(helper, shift):
    @loop(error_model="numpy")
    def function(x):
        return helper(x) + shift

    return function


def counts(*functions):
    stats = [function.stats for function in functions]
    return sum(sum(s.cache_hits.values()) for s in stats), sum(sum(s.cache_misses.values()) for s in stats)


def test_functions_on_one_line_and_in_closures_are_told_apart():
    for loaded in (False, True):
        plain = pair()
        nested = [around(helper, shift) for helper in plain[:2] for shift in (1.0, 5.0)]
        assert [function(1.5) for function in plain] == [1, 2, 4.0]
        assert [function(1.5) for function in nested] == [2.0, 6.0, 3.0, 7.0]
        assert counts(*plain, *nested) == ((7, 0) if loaded else (0, 7))


def test_each_type_of_argument_has_its_own_code():
    def make():
        return loop(lambda x: x + x)

    first, second = make(), make()
    values = (2, 2.5, np.ones(2), np.ones((2, 2)), np.ones((2, 2)).T, np.float32(1.0))
    for value in values:
        assert np.array_equal(first(value), second(value))
        assert np.array_equal(first(value), value + value)
    assert counts(first) == (0, len(values))
    assert counts(second) == (len(values), 0)


def test_tuples_of_one_name_are_told_apart_by_their_fields():
    def make():
        return loop(lambda params: params.gain)

    one, other = namedtuple("Params", "gain limit"), namedtuple("Params", "limit gain")
    assert make()(one(1.0, 2.0)) == 1.0
    assert make()(other(1.0, 2.0)) == 2.0
    assert make()(other(1.0, 2.0)._replace(gain=3.0)) == 3.0


def test_a_type_of_ours_brings_the_text_of_its_operators():
    text = stamp("holonom.trace.code.simd", simd.__file__)
    assert text
    assert text in _identity(types.UniTuple(simd.pack, 2))
    assert text not in _identity(types.UniTuple(types.float64, 2))


def test_a_failed_compilation_lets_go_of_the_lock(tmp_path: Path):
    function = loop(lambda x: x.no_such_name)
    for _ in range(2):
        with pytest.raises(Exception, match="no_such_name"):
            function(1.0)
    assert not function._cache._locked
    assert not (tmp_path / "log").exists()


def test_a_function_may_call_itself_while_it_is_compiled_at_once():
    assert down(4.0) == 10.0


def test_a_callback_has_an_address_and_is_kept_apart_from_its_loop(tmp_path: Path):
    def twice(x):
        return 2.0 * x

    for _ in range(2):
        assert callback(float64(float64), error_model="numpy")(twice).ctypes(3.0) == 6.0
        assert loop(float64(float64), error_model="numpy")(twice)(3.0) == 6.0
    lines = [line.split(maxsplit=4) for line in (tmp_path / "log").read_text().splitlines()]
    assert [words[0] for words in lines] == ["compiled", "compiled", "loaded", "loaded"]
    for _, process, begin, end, _ in lines[:2]:
        assert int(process) == os.getpid()
        assert 0.0 < float(end) - float(begin) <= time.process_time()


def test_what_is_compiled_within_another_counts_once():
    spans = [(1, 0.0, 5.0), (1, 1.0, 2.0), (1, 2.5, 5.0), (2, 1.0, 2.0), (1, 7.0, 8.0)]
    assert compile_seconds(reversed(spans)) == pytest.approx(7.0)
    assert compile_seconds([]) == 0.0


def test_a_text_without_a_file_is_compiled_and_not_kept(tmp_path: Path):
    names = {"loop": loop}
    exec("@loop\ndef f(x):\n    return x + 1", names)
    assert names["f"](1) == 2
    assert not list(tmp_path.glob("*.kernel"))
