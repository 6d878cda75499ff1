"""Results that compiled code makes: ordinary arrays and tuples, nothing leaked, nothing shared."""

import gc
import resource
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest

from holonom.errors import ShapeError
from holonom.trace import compile


class Pair(NamedTuple):
    y: np.ndarray
    positive: np.ndarray
    names: tuple


NAMES = ("a", "b")
SUM = compile(lambda a, b: [x + y for x, y in zip(a, b, strict=True)], {"a": 2, "b": 2}, {"y": 2}, name="sum")
PAIR = compile(
    lambda a: ([2.0 * x for x in a], [a[0] * a[0]]),
    {"a": 3},
    {"y": (3, 1), "positive": ()},
    name="pair",
    integers=("positive",),
    result=lambda y, positive: Pair(y, positive.view(bool), NAMES),
)


def test_an_array_is_one_like_any_other():
    y, plain = SUM(np.ones(2), np.ones(2)), np.empty(2)
    assert type(y) is np.ndarray
    assert (y.dtype, y.shape, y.strides, y.base) == (np.float64, (2,), (8,), None)
    assert y.flags.owndata
    assert y.flags.writeable
    assert y.flags.carray
    assert sys.getrefcount(y) == sys.getrefcount(plain)
    assert y.tolist() == [2.0, 2.0]
    y.resize(3)


@pytest.mark.parametrize("a", [np.ones(3), np.ones((5, 3)), [1, 1, 1], np.ones((2, 0, 3))])
def test_a_named_tuple_of_views_and_constants_is_made_in_every_way_of_calling(a):
    found = PAIR(a)
    lead = np.shape(a)[:-1]
    assert type(found) is Pair
    assert found.names is NAMES
    assert (found.y.shape, found.positive.shape, found.positive.dtype) == ((*lead, 3, 1), lead, bool)
    assert found.positive.all()
    assert (found.y == 2.0).all()
    assert gc.is_tracked(found)


def test_every_call_has_its_own_arrays():
    first, second, plain = PAIR(np.ones(3)), PAIR(np.zeros(3)), Pair(np.ones(3), None, None)
    assert not np.shares_memory(first.y, second.y)
    assert first.y[0] == 2.0
    assert sys.getrefcount(first) == sys.getrefcount(plain)
    assert sys.getrefcount(first[0]) == sys.getrefcount(plain[0])


def test_a_result_is_written_into_given_arrays():
    y, positive = np.empty((3, 1)), np.empty((), np.int8)
    found = PAIR(np.ones(3), out=(y, positive))
    assert found.y is y
    assert positive[()] == 1
    with pytest.raises(ShapeError, match="out="):
        PAIR(np.ones(3), out=y)


def test_calls_do_not_keep_memory():
    a, b = np.ones(2), np.ones(3)
    kept = sys.getrefcount(NAMES), sys.getrefcount(Pair), sys.getrefcount(None)

    def calls(count):
        for _ in range(count):
            SUM.call(a, a)
            PAIR.call(b)
            PAIR.call.__globals__["made"](a, None)  # refused

    calls(1000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    calls(300_000)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 4096  # KiB; a leak of 16 B a call is more
    assert np.abs(np.subtract((sys.getrefcount(NAMES), sys.getrefcount(Pair), sys.getrefcount(None)), kept)).max() < 100


def test_without_memory_there_is_an_error_and_nothing_half_made():
    """A pattern whose second array is larger than any memory stands for a machine that has none left."""
    rest = NAMES, ("c",)
    large = np.lib.stride_tricks.as_strided(np.empty(1), (2**58,), (0,))
    made = PAIR.made
    kept = [sys.getrefcount(x) for x in rest]
    for _ in range(1000):
        with pytest.raises(MemoryError):
            made(np.ones(3), (np.empty((3, 1)), large, *rest))
    assert [sys.getrefcount(x) for x in rest] == kept


FALLBACK = """
import numba, numpy as np
np.__version__ = "3.0.0"
import holonom as hm
from holonom.mechanics import dynamics
arm = hm.load_arm("puma560")
q = np.linspace(0.1, 0.6, 6)
assert arm.kernel("inverse_dynamics").single(q, q, q, np.empty(6)) == 1
print(repr([arm.inverse_dynamics(q, q, q).tolist(), type(dynamics.energy(arm, q, q)).__name__]))
"""


def test_another_layout_of_arrays_is_met_by_the_general_way():
    """Machine code from the cache of this process, under a NumPy that it was not made for."""
    results = []
    for text in (FALLBACK, FALLBACK.replace('np.__version__ = "3.0.0"', "").replace("== 1", "== 0")):
        results.append(eval(subprocess.run([sys.executable, "-c", text], check=True, capture_output=True).stdout))
    for ours, general in zip(*results, strict=True):
        assert ours == general if isinstance(ours, str) else np.allclose(ours, general, rtol=0.0, atol=1e-12)
