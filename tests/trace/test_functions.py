"""The branch-free elementary functions against NumPy, over all quadrants and large angles."""

import numpy as np
import pytest

from holonom import trace
from holonom.errors import InputError, ShapeError


@pytest.fixture(scope="module")
def elementary():
    def equation(a):
        x, y = a
        return [
            trace.sin(x),
            trace.cos(x),
            trace.atan2(y, x),
            trace.sqrt(trace.absolute(x)),
            trace.minimum(x, y),
            trace.maximum(x, y),
            trace.select(trace.less(x, y) & trace.less(0.0, y), x / (y * y + 1.0), y),
        ]

    return trace.compile(equation, {"a": 2}, {"y": 7}, name="test_elementary"), equation


def samples() -> np.ndarray:
    rng = np.random.default_rng(5)
    special = [0.0, -0.0, 1.0, -1.0, 0.66, np.pi, -np.pi, np.pi / 2, 1e-300, 1e-9, 1e4, -1e4]
    grid = np.array([(x, y) for x in special for y in special])
    return np.concatenate([grid, rng.normal(size=(2000, 2)), rng.uniform(-1e4, 1e4, (2000, 2))])


def test_compiled_equals_numpy(elementary):
    kernel, _ = elementary
    a = samples()
    x, y = a.T
    found = kernel(a)
    assert np.abs(found[:, 0] - np.sin(x)).max() < 1e-14
    assert np.abs(found[:, 1] - np.cos(x)).max() < 1e-14
    plus_zero = (x == 0) & np.signbit(x) & (y == 0)  # at the origin every quadrant gives +-0
    assert np.abs(found[:, 2] - np.arctan2(y, x))[~plus_zero].max() < 1e-15
    assert np.abs(found[plus_zero, 2]).max() == 0.0
    np.testing.assert_array_equal(found[:, 3], np.sqrt(np.abs(x)))
    np.testing.assert_array_equal(found[:, 4], np.minimum(x, y))
    np.testing.assert_array_equal(found[:, 5], np.maximum(x, y))


def test_compiled_equals_floats_in_every_form(elementary):
    kernel, equation = elementary
    a = samples()[::7]
    floats = np.array([equation(row) for row in a.tolist()])
    batch = kernel(a)
    single = np.array([kernel(row) for row in a])
    assert np.allclose(batch, floats, rtol=1e-12, atol=1e-12)
    assert np.allclose(single, floats, rtol=1e-12, atol=1e-12)


def test_batches_of_every_size_and_threads(elementary, monkeypatch):
    """Also those that are not worth a second thread."""
    monkeypatch.setattr("holonom.trace.kernel.WORTH", 1)
    kernel = trace.compile(elementary[1], {"a": 2}, {"y": 7}, name="test_elementary")
    a = samples()[:300]
    whole = kernel(a)
    for count in (0, 1, 2, 7, 8, 9, 15, 16, 17, 31, 33, 63, 64, 65, 128, 300):
        np.testing.assert_array_equal(kernel(a[:count]), whole[:count])
        np.testing.assert_array_equal(kernel(a[:count], threads=3), whole[:count])


@pytest.mark.parametrize("count", [1, 16, 37])
def test_a_result_may_overwrite_what_it_comes_from(count):
    """Also in rows of its own that another one has yet to read; what is not finite is found all the same."""
    kernel = trace.compile(lambda a: [2.0 * a[1], a[1]], {"a": 2}, {"y": 2}, name="in_place")
    a = np.random.default_rng(1).normal(size=(count + 1, 2))
    shifted = a.copy()
    kernel(shifted[:-1], out=shifted[1:])
    np.testing.assert_array_equal(shifted[1:], kernel(a[:-1]))
    same = a.copy()
    kernel(same, out=same)
    np.testing.assert_array_equal(same, kernel(a))
    a[count // 2, 0] = np.nan
    with pytest.raises(ShapeError, match=rf"a\[0\] is nan in row \({count // 2},\)"):
        kernel(a, out=a)


def test_leading_axes_broadcast_and_out_is_used(elementary):
    kernel, _ = elementary
    a = samples()[:24].reshape(2, 3, 4, 2)
    out = np.empty((2, 3, 4, 7))
    assert kernel(a, out=out) is out
    np.testing.assert_array_equal(out.reshape(24, 7), kernel(a.reshape(24, 2)))
    one = np.empty(7)
    assert kernel(a[0, 0, 0], out=one) is one


def test_other_layouts_are_taken(elementary):
    kernel, _ = elementary
    a = samples()[:32]
    wanted = kernel(a)
    np.testing.assert_array_equal(kernel(np.asfortranarray(a)), wanted)
    np.testing.assert_array_equal(kernel(a.tolist()), wanted)
    np.testing.assert_array_equal(kernel(np.repeat(a, 2, axis=0)[::2]), wanted)
    frozen = a.copy()
    frozen.flags.writeable = False
    np.testing.assert_array_equal(kernel(frozen), wanted)
    np.testing.assert_array_equal(kernel([1, 2]), kernel([1.0, 2.0]))
    np.testing.assert_array_equal(kernel(a.astype(">f8")), wanted)
    np.testing.assert_array_equal(kernel(unaligned(a)), wanted)
    np.testing.assert_array_equal(kernel(unaligned(a[0])), wanted[0])
    np.testing.assert_array_equal(kernel(a.view(np.matrix).reshape(32, 2)), wanted)


def unaligned(a: np.ndarray) -> np.ndarray:
    """The same numbers, one byte further on than numbers lie."""
    memory = np.empty(a.nbytes + 9, np.int8)
    start = (1 - memory.ctypes.data) % 8
    moved = memory[start : start + a.nbytes].view(a.dtype).reshape(a.shape)
    moved[:] = a
    assert not moved.flags.aligned
    return moved


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        (np.zeros(3), "shape"),
        (np.zeros((4, 3)), "shape"),
        ([1.0, np.nan], r"a\[1\] is nan"),
        ([[1.0, 2.0], [np.inf, 1.0]], r"a\[0\] is inf in row \(1,\)"),
        (["x", 1.0], "not a number"),
        (np.zeros(2, complex), "a holds complex numbers"),
        (np.zeros((3, 2), complex), "a holds complex numbers"),
        ([1.0, 2j], "a holds complex numbers"),
    ],
)
def test_bad_input_is_named(elementary, bad, says):
    kernel, _ = elementary
    with pytest.raises(ShapeError, match=says):
        kernel(bad)


def test_bad_out_and_count_are_named(elementary):
    kernel, _ = elementary
    with pytest.raises(ShapeError, match="out= for y"):
        kernel(np.zeros((5, 2)), out=np.zeros((5, 6)))
    with pytest.raises(ShapeError, match=r"out= for y .* aligned"):
        kernel(np.zeros((5, 2)), out=unaligned(np.zeros((5, 7))))
    with pytest.raises(ShapeError, match="out= takes 1 arrays"):
        kernel(np.zeros((5, 2)), out=(np.zeros((5, 7)), np.zeros((5, 7))))
    with pytest.raises(ShapeError, match="out= for y"):
        kernel(np.zeros((5, 2)), out=[0.0] * 5)
    frozen = np.zeros((5, 7))
    frozen.flags.writeable = False
    with pytest.raises(ShapeError, match="out= for y must be a writeable"):
        kernel(np.zeros((5, 2)), out=frozen)
    with pytest.raises(ShapeError, match="takes 1 arrays"):
        kernel(np.zeros(2), np.zeros(2))


@pytest.mark.parametrize("threads", [0, -1, 2.0, 1.5, np.nan, "2", None])
def test_a_number_of_threads_is_whole_and_positive(elementary, threads):
    kernel, _ = elementary
    for a in (np.zeros(2), np.zeros((3, 2)), [0.0, 0.0]):
        with pytest.raises(InputError, match=r"threads is .*whole number of at least 1"):
            kernel(a, threads=threads)
    np.testing.assert_array_equal(kernel(np.zeros(2), threads=np.int64(3)), kernel(np.zeros(2)))
    np.testing.assert_array_equal(kernel(np.zeros((3, 2)), threads=10**30), kernel(np.zeros((3, 2))))


@pytest.mark.parametrize("name", ["first", "start", "check", "np", "back", "lambda", "_x", "x y", "range"])
def test_names_of_the_generated_text_are_refused(name):
    with pytest.raises(InputError, match=f"'{name}' cannot be the name of an input or output"):
        trace.compile(lambda a: a, {name: 1}, {"y": 1}, name="taken")


@pytest.mark.parametrize("name", ["s0", "t1", "sum", "found", "lane", "x_0", "block"])
def test_names_like_those_of_values_are_fine(name):
    kernel = trace.compile(
        lambda a, b: [trace.sin(a[0] + b[1]) * b[0]], {name: 1, "b": 2}, {"y": 1}, name=f"named_{name}"
    )
    a, b = np.array([0.3]), np.array([0.5, 0.2])
    assert kernel(a, b)[0] == pytest.approx(0.5 * np.sin(0.5), abs=1e-15)
    assert kernel(np.tile(a, (20, 1)), np.tile(b, (20, 1)))[19, 0] == pytest.approx(0.5 * np.sin(0.5), abs=1e-15)
