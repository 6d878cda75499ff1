"""What every verb asks of the arrays that come in."""

import numpy as np
import pytest

from holonom.arrays import angles, finite, finite_array, vectors
from holonom.errors import NotFinite, OutOfLimits, ShapeError
from holonom.mobile import mecanum


def test_what_is_wrong_is_named_with_its_place():
    rows = np.zeros((3, 2))
    for value, error, said in (
        (np.nan, NotFinite, "nan"),
        (-np.inf, NotFinite, "-inf"),
        (1e200, OutOfLimits, r"1e\+200"),
    ):
        rows[2, 1] = value
        with pytest.raises(error, match=rf"v\[1\] \(right\) is {said} in row \(2,\)"):
            vectors("v", rows, 2, ["left", "right"])
        with pytest.raises(error, match=rf"v\[2, 1\] is {said}"):
            finite_array("v", rows, ("N", 2))
        with pytest.raises(error, match=rf"v holds {said}"):
            finite("v", rows)
    with pytest.raises(OutOfLimits, match=r"q\[0\] is 2e\+15: beyond 1e\+15 whole turns"):
        angles("q", [2e15, 0.0], 2)
    assert vectors("v", [1e99, -1e99], 2).tolist() == [1e99, -1e99]
    with pytest.raises(ShapeError, match="v has shape"):
        vectors("v", rows, 3)


def test_a_base_gives_no_infinite_speed():
    base = mecanum(0.4, 0.3, 0.05)
    with pytest.raises(OutOfLimits, match=r"twist\[0\] is 1e\+308: beyond 1e\+100 products of it overflow"):
        base.wheel_speeds([1e308, 0.0, 0.0])
    with pytest.raises(NotFinite, match=r"speeds\[2\] is nan"):
        base.twist([0.0, 0.0, np.nan, 0.0])
