"""Branches side by side: the one-sample form of like rows computes what the equation says."""

import numpy as np
import pytest

from holonom.trace import absolute, atan2, compile, cos, less, minimum, select, sin, sqrt

INPUT = np.array([0.3, -1.2, 0.8])


def _branches(x):
    """Eight rows: signs that fold, sums whose terms change places, a truth of all rows, and one of each."""
    square = x[0] * x[0] + x[1] * x[1]
    shared = less(square, x[2])
    numbers, codes = [], []
    for first in (1.0, -1.0):
        c, s = cos(x[0]), first * sin(x[0])
        for second in (1.0, -1.0):
            a, b = x[1] * c - s * (second * x[2]), s * x[2] + c
            for third in (1.0, -1.0):
                turn = atan2(b + third * sqrt(square), a)
                late = turn * a + sin(turn) if third > 0.0 else sin(turn) + a * turn
                far = less(late, a)
                numbers += [select(shared, late, -late), minimum(absolute(turn), 1.0), third * x[2]]
                codes.append(select(far, 1.0, select(shared, 2.0, 3.0)))
    return numbers, codes


def _compiled(equation, rows, branches=True):
    outputs = {"y": (rows, 3), "code": rows}
    return compile(equation, {"x": 3}, outputs, name=f"lanes_{rows}", integers=("code",), branches=branches)


@pytest.mark.parametrize("x", [INPUT, -INPUT, 3.0 * INPUT, np.array([0.1, 0.2, 5.0])])
def test_branches_side_by_side_agree_with_the_equation(x):
    kernel = _compiled(_branches, 8)
    assert "branch(buf)" in kernel.source
    y, code = kernel(x)
    numbers, codes = _branches(x)
    assert y.ravel() == pytest.approx(numbers, abs=1e-14)
    assert code.tolist() == codes
    rows, row_codes = kernel(x[None])
    assert y == pytest.approx(rows[0], abs=1e-14)
    assert code.tolist() == row_codes[0].tolist()


def test_like_rows_are_written_once():
    kernel = _compiled(_branches, 8)
    lanes = kernel._parts()
    assert sum("arctan2" in line for line in lanes.branch) == 1
    assert not any("arctan2" in line for line in lanes.shared)


def test_rows_that_have_nothing_in_common_are_right_too():
    def unlike(x):
        return [sin(x[0]), x[1], 2.0, x[0] * x[1], cos(x[2]), 1.0, -x[0], x[1] - x[2], x[0] / x[1], 0.0, 0.0, x[1]], [
            0.0,
            1.0,
            select(less(x[0], x[1]), 2.0, 1.0),
            3.0,
        ]

    y, code = _compiled(unlike, 4)(INPUT)
    numbers, codes = unlike(INPUT)
    assert y.ravel() == pytest.approx(numbers, abs=1e-15)
    assert code.tolist() == codes


def test_two_rows_stay_as_they_are():
    def two(x):
        return [x[0], x[1], x[2], -x[0], -x[1], -x[2]], [0.0, 1.0]

    kernel = _compiled(two, 2)
    assert kernel._parts() is None
    assert kernel(INPUT)[0].tolist() == [INPUT.tolist(), (-INPUT).tolist()]
