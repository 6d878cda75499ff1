"""The one-sample form reads arrays where NumPy keeps them: what it takes, and what it leaves alone."""

import pickle

import numpy as np
import pytest

from holonom.errors import ShapeError
from holonom.trace import compile


def _sum(a, b):
    return [a[0] + b[k] for k in range(4)], [a[1]]


KERNEL = compile(_sum, {"a": 2, "b": (2, 2)}, {"y": (2, 2), "code": 1}, name="direct_sum", integers=("code",))


def _given():
    return np.array([1.0, 2.0]), np.arange(4.0).reshape(2, 2), np.zeros((2, 2)), np.zeros(1, np.int8)


def test_arrays_of_the_declared_kind_are_read_and_written_in_place():
    a, b, y, code = _given()
    assert KERNEL.single(a, b, y, code) == 0
    assert np.array_equal(y, a[0] + b)
    assert code == 2


def test_inputs_may_be_views_read_only_or_unpickled():
    a, b, y, code = _given()
    whole = np.array([[7.0, 7.0], [1.0, 2.0]])
    a.setflags(write=False)
    for first in (whole[1], a, pickle.loads(pickle.dumps(a))):
        y[:] = 0.0
        assert KERNEL.single(first, b, y, code) == 0
        assert np.array_equal(y, 1.0 + b)


class Own(np.ndarray):
    """A subclass may lie to its reader; the general way converts it."""


def _read_only(a):
    a.setflags(write=False)
    return a


@pytest.mark.parametrize(
    ("place", "wrong"),
    [
        (0, [1.0, 2.0]),
        (0, None),
        (0, 3),
        (0, np.float64(1.0)),
        (0, np.zeros(3)),
        (0, np.zeros((2, 1))),
        (0, np.zeros(2, np.int64)),
        (0, np.zeros(2, np.float32)),
        (0, np.zeros(2, ">f8")),
        (0, np.zeros(4)[::2]),
        (0, np.zeros(2).view(Own)),
        (1, np.zeros((2, 2), order="F")),
        (1, np.zeros((2, 3))),
        (2, _read_only(np.zeros((2, 2)))),
        (3, np.zeros(1)),
        (3, np.zeros(1, np.uint8)),
    ],
)
def test_anything_else_is_refused_untouched(place, wrong):
    arrays = list(_given())
    arrays[place] = wrong
    assert KERNEL.single(*arrays) == 1


def test_not_finite_is_a_status_of_its_own():
    a, b, y, code = _given()
    b[1, 1] = np.nan
    assert KERNEL.single(a, b, y, code) == 2
    assert not y.any()


def test_a_wrong_number_of_arrays_is_named():
    with pytest.raises(ShapeError, match="takes 2 arrays"):
        KERNEL(np.zeros(2))
    with pytest.raises(TypeError):
        KERNEL.single(np.zeros(2))


def test_the_general_way_takes_what_the_direct_one_does_not():
    y, _ = KERNEL([1, 2], np.arange(4.0, dtype=np.float32).reshape(2, 2))
    assert np.array_equal(y, 1.0 + np.arange(4.0).reshape(2, 2))
