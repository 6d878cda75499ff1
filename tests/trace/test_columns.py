"""Like columns in a loop, and long lines whose results go through memory: every form gives what the equation says."""

import ctypes

import numpy as np
import pytest

from holonom.errors import InputError, ShapeError
from holonom.trace import compile, sin


def _start(a, b):
    """What the columns share, and rows of numbers that they start from."""
    return [2.0 * a[0], a[1] + b[0]], [*(x + 1.0 for x in b), *(a[k % 2] * x for k, x in enumerate(b))]


def _column(shared, own):
    """A column of four numbers, one of them a constant, and a column of one whole number."""
    turned = sin(own[0]) * shared[0]
    return [turned, own[1] - shared[1], own[0] / 3.0, 1.0, turned * own[1]], [7.0]


def _written_out(a, b):
    """The same outputs without a loop."""
    shared, own = _start(a, b)
    columns = [_column(shared, [own[k], own[len(b) + k]]) for k in range(len(b))]
    return [c[0][i] for i in range(5) for c in columns], [c[1][0] for c in columns]


def _kernels(n):
    outputs = {"X": (5, n), "code": n}
    return [
        compile(equation, {"a": 2, "b": n}, outputs, name=f"columns{n}", integers=("code",), columns=columns)
        for equation, columns in ((_start, _column), (_written_out, None))
    ]


def _inputs(count, n):
    rng = np.random.default_rng(n)
    return rng.uniform(-2.0, 2.0, (count, 2)), rng.uniform(-2.0, 2.0, (count, n))


@pytest.mark.parametrize("n", [1, 7, 10, 17])
def test_columns_in_a_loop_are_those_written_out(n):
    """Fewer columns than a vector has lanes, more, and such that the last vector overlaps the one before."""
    loop, plain = _kernels(n)
    a, b = _inputs(20, n)
    expected = [plain(*x) for x in zip(a, b, strict=True)]
    for count in range(1, 21):
        X, number = loop(a[:count], b[:count])
        np.testing.assert_allclose(X, [e[0] for e in expected[:count]], rtol=1e-13, atol=1e-13)
        np.testing.assert_array_equal(number, np.full((count, n), 7))
    for x, e in zip(zip(a, b, strict=True), expected, strict=True):
        out = np.empty((5, n)), np.empty(n, np.int8)
        for X, number in (loop(*x), loop(*x, out=out)):
            np.testing.assert_allclose(X, e[0], rtol=1e-13, atol=1e-13)
            np.testing.assert_array_equal(number, e[1])


def test_behind_a_pointer():
    kernel = compile(lambda a, b: _start(a, b), {"a": 2, "b": 9}, {"X": (5, 9)}, name="columns_c", columns=_first)
    (a,), (b,) = _inputs(1, 9)
    source, target = np.concatenate([a, b]), np.empty(45)
    pointer = ctypes.POINTER(ctypes.c_double)
    call = ctypes.CFUNCTYPE(None, pointer, pointer)(kernel.address)
    call(source.ctypes.data_as(pointer), target.ctypes.data_as(pointer))
    np.testing.assert_array_equal(target.reshape(5, 9), kernel(a, b))


def _first(shared, own):
    return _column(shared, own)[0]


@pytest.mark.parametrize("lanes", [2, 4, 8, 16])
def test_long_lines_of_every_machine(lanes, monkeypatch):
    """A line that is called long from its first operation on, and columns, in vectors of every length."""
    monkeypatch.setattr("holonom.trace.text.emit.lanes_at_once", lambda operations: lanes)
    monkeypatch.setattr("holonom.trace.text.emit.LONG", 0)
    a, b = _inputs(2 * lanes + 1, 7)
    expected = [_written_out(*x) for x in zip(a.tolist(), b.tolist(), strict=True)]
    for kernel in _kernels(7):
        assert "across(" in kernel.block_source
        for count in (1, lanes, 2 * lanes + 1):
            X, number = kernel(a[:count], b[:count])
            np.testing.assert_allclose(X.reshape(count, 35), [e[0] for e in expected[:count]], rtol=1e-13, atol=1e-13)
            assert (number == 7).all()


def test_the_line_of_a_column_is_there_once():
    kernel = _kernels(17)[0]
    assert kernel.source.count("sincos(") == kernel.block_source.count("sincos(") == 1
    assert kernel.operations > 17 * 5


def test_columns_that_do_not_fit_are_refused():
    with pytest.raises(ShapeError, match="last axes"):
        compile(_start, {"a": 2, "b": 3}, {"X": (5, 3), "y": 4}, name="uneven", columns=_column)
    with pytest.raises(ShapeError, match="4 numbers; 5 came"):
        compile(_start, {"a": 2, "b": 3}, {"X": (4, 3), "y": 3}, name="short", columns=_column)


@pytest.mark.parametrize(("given", "found"), [("k", "x"), ("x", "k"), ("n", "i"), ("s", "left")])
def test_names_are_free_in_columns(given, found):
    """As are all that the text of a loop does not use itself."""
    kernel = compile(
        lambda a: ([a[0]], [*range(1, 18)]),
        {given: 1},
        {found: (1, 17)},
        name="named",
        columns=lambda s, own: [s[0] * own[0]],
    )
    a = np.arange(1.0, 21.0)[:, None]
    np.testing.assert_array_equal(kernel(a[2])[0], 3.0 * np.arange(1, 18))
    np.testing.assert_array_equal(kernel(a)[:, 0], a * np.arange(1, 18))
    with pytest.raises(InputError, match="cannot be the name of an input or output"):
        compile(lambda a: a, {"nth": 1}, {"y": 1}, name="taken")
