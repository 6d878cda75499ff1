"""The GPU form, run by Numba's simulator on the CPU: the same numbers, NaN said, wrong shapes refused."""

import os
import subprocess
import sys

import numpy as np
import pytest

from holonom import trace
from holonom.errors import RunError
from holonom.trace.cuda import emit_cuda, launch

PRELUDE = """
import numpy as np
from numba import cuda
from holonom import load_arm, trace
from holonom.errors import ShapeError
from holonom.trace.cuda import launch

def run(kernel, *columns):
    count = columns[0].shape[1]
    out = [cuda.device_array((f.width, count), np.int8 if f.integer else np.float64) for f in kernel.outputs]
    bad = launch(kernel, [cuda.to_device(c) for c in columns], out).copy_to_host()[0]
    return bad, [o.copy_to_host() for o in out]
"""


def simulate(code, tmp_path):
    environment = os.environ | {"NUMBA_ENABLE_CUDASIM": "1", "HOLONOM_CACHE": str(tmp_path), "HOLONOM_CACHE_LOG": ""}
    done = subprocess.run(
        [sys.executable, "-c", PRELUDE + code], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_straight_line_is_the_same(tmp_path):
    """Every operation, an output of integers, more samples than a thread block; the values themselves."""
    code = """
def equation(x):
    a, b = x
    low = trace.less(a, b) & trace.less_equal(a, 0.3) | trace.less(1.5, a)
    near = trace.select(low, trace.atan2(a, b), trace.sqrt(a * a + b))
    first = trace.sin(a) * trace.cos(a) - near / (b + 3.0)
    return [first, -trace.absolute(a)], [trace.select(low, 1.0, 0.0)]

kernel = trace.compile(equation, {"x": 2}, {"y": 2, "s": 1}, name="operations", integers=("s",))
x = np.random.default_rng(0).uniform(-2.0, 2.0, (2, 300)); x[1] = abs(x[1])
bad, (y, s) = run(kernel, x)
a, b = x
low = (a < b) & (a <= 0.3) | (a > 1.5)
near = np.where(low, np.arctan2(a, b), np.sqrt(a * a + b))
np.testing.assert_allclose(y, [np.sin(a) * np.cos(a) - near / (b + 3.0), -abs(a)], atol=1e-14)
np.testing.assert_array_equal(s[0], low)
assert s.dtype == np.int8 and bad == 0
x[1, 7] = np.nan
assert run(kernel, x)[0] == 1
try:
    run(kernel, x[:1])
except ShapeError as error:
    print(error)
"""
    assert "operations takes x (2, N), y (2, N), s (1, N)" in simulate(code, tmp_path)


def test_dynamics_of_an_arm(tmp_path):
    code = """
from holonom.mechanics.equations.dynamics import newton_euler
from holonom.mechanics.kernels.table import bodies_of
arm = load_arm("puma560")
x = np.random.default_rng(1).uniform(-2.0, 2.0, (3, 6, 3))
bad, (tau,) = run(arm.kernel("inverse_dynamics"), *x)
bodies = bodies_of(arm.model)
for k in range(3):
    q, qd, qdd = x[:, :, k].tolist()
    expected = newton_euler.inverse_dynamics(arm.model, bodies, q, qd, qdd, friction=True)
    np.testing.assert_allclose(tau[:, k], expected, rtol=1e-12, atol=1e-11)
"""
    simulate(code, tmp_path)


def test_columns_are_a_loop_there_too(tmp_path):
    code = """
def line(a, b):
    return [a[0] * a[1], a[1]], [x + a[0] for x in b] + [x * x for x in b]

def column(shared, own):
    return [own[0] * shared[0], own[1] - shared[1]], [own[0] * own[1]]

kernel = trace.compile(line, {"a": 2, "b": 3}, {"X": (2, 3), "y": 3}, name="columns_gpu", columns=column)
a, b = np.random.default_rng(0).uniform(-2.0, 2.0, (2, 5)), np.random.default_rng(1).uniform(-2.0, 2.0, (3, 5))
bad, (X, y) = run(kernel, a, b)
np.testing.assert_allclose(X, [*((b + a[0]) * a[0] * a[1]), *(b * b - a[1])], atol=1e-14)
np.testing.assert_allclose(y, (b + a[0]) * b * b, atol=1e-14)
assert bad == 0
"""
    simulate(code, tmp_path)


def test_text_without_a_gpu():
    """The text needs no GPU; asking for one says what to do."""
    from numba import cuda

    kernel = trace.compile(lambda a: [trace.sin(a[0]) * a[1]], {"a": 2}, {"y": 1}, name="gpu_text")
    text = kernel.text(emit_cuda)
    assert "def rows(a, y, bad):" in text
    assert "y[0, i] = t" in text
    if not cuda.is_available():
        with pytest.raises(RunError, match="CUDASIM"):
            launch(kernel, [np.zeros((2, 3))], [np.zeros((1, 3))])
