"""Packs against NumPy, lane by lane; the branch-free functions that take packs against mpmath."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from numba.core.errors import TypingError

from holonom.trace.code.compiled import arctan, select, sincos_half_turn
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import any_of, chosen, largest, load, packed, spread, store, total

RECORD = np.dtype(
    [("a", np.float64, (4,)), ("count", np.int64, (4,)), ("part", [("b", np.float64, (4,))]), ("c", np.float64, (4,))]
)
SPECIAL = [0.0, -0.0, 1.0, -1.0, 2.5, -1e-300, 1e300, np.inf, -np.inf, np.nan]
A, B = (grid.reshape(-1, 4) for grid in np.meshgrid(SPECIAL, SPECIAL))
THRESHOLDS = [math.tan(math.pi / 8.0), math.tan(3.0 * math.pi / 8.0)]

OPERATIONS = {
    "+": (lambda a, b: a + b, np.add),
    "-": (lambda a, b: a - b, np.subtract),
    "*": (lambda a, b: a * b, np.multiply),
    "/": (lambda a, b: a / b, np.divide),
    "neg": (lambda a, b: -a, lambda a, b: -a),
    "abs": (lambda a, b: abs(a), lambda a, b: np.abs(a)),
    "sqrt": (lambda a, b: math.sqrt(a), lambda a, b: np.sqrt(a)),
    "floor": (lambda a, b: np.floor(a), lambda a, b: np.floor(a)),
    "copysign": (lambda a, b: math.copysign(a, b), np.copysign),
    "min": (lambda a, b: min(a, b), lambda a, b: np.where(b < a, b, a)),
    "max": (lambda a, b: max(a, b), lambda a, b: np.where(b > a, b, a)),
    "<": (lambda a, b: select(a < b, 1.0, 0.0), np.less),
    "<=": (lambda a, b: select(a <= b, 1.0, 0.0), np.less_equal),
    ">": (lambda a, b: select(a > b, 1.0, 0.0), np.greater),
    ">=": (lambda a, b: select(a >= b, 1.0, 0.0), np.greater_equal),
    "&": (lambda a, b: select((a < b) & (b > 0.5), a, b), lambda a, b: np.where((a < b) & (b > 0.5), a, b)),
    "|": (lambda a, b: select((a < b) | (b > 0.5), a, b), lambda a, b: np.where((a < b) | (b > 0.5), a, b)),
}


@pytest.mark.parametrize("name", OPERATIONS)
def test_a_pack_is_four_floats(name: str) -> None:
    """Each operation, over all pairs of special values: as NumPy's, bit by bit, NaN where it has NaN."""
    function, expected = OPERATIONS[name]
    operation = loop(function)

    @loop(error_model="numpy")
    def over(a: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
        for k in range(len(a) // 4):
            store(out, k, operation(load(a, k), load(b, k)))

    found = np.full(A.size, 7.0)
    over(A.ravel(), B.ravel(), found)
    with np.errstate(all="ignore"):
        wanted = np.asarray(expected(A, B), float).ravel()
    np.testing.assert_array_equal(found, wanted)
    known = ~np.isnan(wanted)
    np.testing.assert_array_equal(np.signbit(found[known]), np.signbit(wanted[known]))


def test_a_number_counts_for_all_lanes_and_a_field_is_set_in_place() -> None:
    @loop
    def step(records: np.ndarray) -> tuple[float, float, bool, bool]:
        for k in range(len(records)):
            own = packed(records[k])
            own.c = 2 * own.a - 0.5 + own.part.b / 2
            own.c += 1.0
            own.part.b = 3.0
            records[k].count[2] += 1
        last = packed(records[0])
        return total(last.c), largest(last.c), any_of(last.c > 9.0), any_of(last.c > 10.0)

    records = np.zeros(2, RECORD)
    records["a"] = np.arange(8.0).reshape(2, 4)
    records["part"]["b"] = [[1.0, 2.0, 3.0, 7.0], [4.0, 4.0, 0.0, -6.0]]
    expected = 2.0 * records["a"] + 0.5 + records["part"]["b"] / 2.0
    said = step(records)
    np.testing.assert_array_equal(records["c"], expected)
    np.testing.assert_array_equal(records["part"]["b"], 3.0)
    np.testing.assert_array_equal(records["count"], [[0, 0, 1, 0]] * 2)
    np.testing.assert_array_equal(records["a"], np.arange(8.0).reshape(2, 4))
    assert said == (expected[0].sum(), 10.0, True, False)


def test_nothing_branches_on_a_pack() -> None:
    @loop
    def branch(a: np.ndarray) -> float:
        return 1.0 if load(a, 0) > 0.0 else 0.0

    with pytest.raises(TypingError):
        branch(np.ones(4))


def _evaluate(function: object, x: np.ndarray) -> np.ndarray:
    """(N, 2) results (the second 0 where there is one only), by packs; as of floats, to rounding."""

    @loop(error_model="numpy")
    def over(x: np.ndarray, packs: np.ndarray, floats: np.ndarray) -> None:
        for k in range(len(x) // 4):
            a, b = function(load(x, k))  # type: ignore[operator]
            store(packs[0], k, a)
            store(packs[1], k, b)
        for k in range(len(x)):
            floats[0, k], floats[1, k] = function(x[k])  # type: ignore[operator]

    packs, floats = np.zeros((2, 2, len(x)))
    over(x, packs, floats)
    np.testing.assert_allclose(packs, floats, rtol=0.0, atol=5e-16)
    return packs


def test_arctangent() -> None:
    """Relative error over all magnitudes, at the borders of its intervals and beyond; signs, infinity, NaN."""

    @loop
    def pair(x: float) -> tuple[float, float]:
        y = arctan(x)
        return y, y

    x = np.concatenate([np.logspace(-300, 300, 2000), np.linspace(0.0, 4.0, 2000)[1:], [1.0], SPECIAL, [0.0, 0.0]])
    x = np.concatenate([x, *(np.nextafter(t, [0.0, t, 9.0, t]) for t in THRESHOLDS)])
    x = np.concatenate([x, -x])
    found = _evaluate(pair, x)[0]
    finite = np.isfinite(x) & (x != 0.0)
    exact = np.array([float(mpmath.atan(value)) for value in x[finite]])
    np.testing.assert_allclose(found[finite], exact, rtol=3e-16, atol=0.0)
    np.testing.assert_array_equal(found[np.isinf(x)], np.copysign(np.pi / 2, x[np.isinf(x)]))
    assert np.isnan(found[np.isnan(x)]).all()
    assert (found[x == 0.0] == 0.0).all()
    assert (np.signbit(found) == np.signbit(x))[~np.isnan(x)].all()


def test_sine_and_cosine_of_a_half_turn() -> None:
    x = np.concatenate([np.linspace(0.0, np.pi, 4000), np.logspace(-300, 0, 1000), [np.nan, np.pi / 2, np.pi, 0.0]])
    sine, cosine = _evaluate(sincos_half_turn, x)
    known = ~np.isnan(x)
    for found, function in ((sine, mpmath.sin), (cosine, mpmath.cos)):
        exact = np.array([float(function(value)) for value in x[known]])
        np.testing.assert_allclose(found[known], exact, rtol=0.0, atol=5e-16)
        assert np.isnan(found[~known]).all()
    small = x < 1.6
    np.testing.assert_allclose(sine[small], np.sin(x[small]), rtol=7e-16, atol=0.0)
    assert (sine[x == 0.0] == 0.0).all()
    assert (cosine[x == 0.0] == 1.0).all()


def test_lanes_of_two_packs_are_chosen_by_number() -> None:
    @loop
    def over(a: np.ndarray, out: np.ndarray) -> None:
        store(out, 0, chosen(load(a, 0), load(a, 1), 0, 6, 5, 3))
        store(out, 1, chosen(load(a, 0), load(a, 1), 7, 7, 1, 0))
        store(out, 2, spread(a[2]))

    out = np.empty(12)
    over(np.arange(8.0), out)
    np.testing.assert_array_equal(out, [0, 6, 5, 3, 7, 7, 1, 0, 2, 2, 2, 2])
