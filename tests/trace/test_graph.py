"""Simplification of the expression graph: what must vanish vanishes, and values never change."""

import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom import trace
from holonom.trace.line.graph import Graph, Scalar, live_nodes
from holonom.trace.line.straight import operand, straight_line
from holonom.trace.text.generated import load_module


@pytest.fixture
def xy():
    graph = Graph()
    return graph.input("x", 0), graph.input("x", 1)


def same(a, b) -> bool:
    return isinstance(a, Scalar) and isinstance(b, Scalar) and a.i == b.i


def test_equal_expressions_are_one_node(xy):
    x, y = xy
    assert same(x + y, y + x)
    assert same(x * y, y * x)
    assert same(trace.sin(x + y), trace.sin(y + x))
    assert not same(x - y, y - x)


def test_zeros_ones_and_signs_vanish(xy):
    x, y = xy
    assert same(x + 0.0, x)
    assert same(0.0 + x, x)
    assert same(x * 1, x)
    assert same(1.0 * x, x)
    assert (x * 0.0).value == 0.0
    assert (x - x).value == 0.0
    minus = -x
    assert same(-minus, x)
    assert same((-x) * y, -(x * y))
    assert same((-x) * (-y), x * y)
    assert same(x - (-y), x + y)
    assert same((-x) + y, y - x)
    assert same(0.5 * (4.0 * x), 2.0 * x)
    assert same(x / 2.0, 0.5 * x)


def test_constants_fold(xy):
    x, _ = xy
    two = x.graph.constant(2.0)
    assert (two * 3.0 + 1.0).value == 7.0
    assert trace.sin(two) == math.sin(2.0)
    assert trace.less(two, 3.0) is True
    assert same(trace.select(trace.less(two, 3.0), x, two), x)


def test_dead_code_is_dropped(xy):
    x, y = xy
    wanted = x * y
    trace.sin(wanted)
    assert len(live_nodes(x.graph, [wanted])) == 3


def test_python_branches_are_refused(xy):
    x, y = xy
    with pytest.raises(TypeError, match="select"):
        bool(trace.less(x, y))
    with pytest.raises(TypeError, match="math"):
        math.sin(x)
    with pytest.raises(ValueError, match="finite"):
        x + math.nan


OPERATIONS = st.sampled_from(["+", "-", "*", "neg", "sin", "cos", "atan2", "sqrt", "select", "const"])


@given(
    st.lists(st.tuples(OPERATIONS, st.integers(0, 30), st.integers(0, 30)), min_size=1, max_size=40), st.integers(0, 99)
)
def test_graph_evaluates_like_floats(program, seed):
    """Random expressions: the simplified straight line gives what the plain floats give."""
    inputs = np.random.default_rng(seed).uniform(-2.0, 2.0, 2).tolist()
    graph = Graph()
    traced = [graph.input("a", 0), graph.input("a", 1)]
    plain = list(inputs)
    for op, i, j in program:
        for values in (traced, plain):
            a, b = values[i % len(values)], values[j % len(values)]
            values.append(
                {
                    "+": lambda a, b: a + b,
                    "-": lambda a, b: a - b,
                    "*": lambda a, b: trace.sin(a) * b,
                    "neg": lambda a, _: -a,
                    "sin": lambda a, _: trace.sin(a),
                    "cos": lambda a, _: trace.cos(a),
                    "atan2": lambda a, b: trace.atan2(a, b * b + 0.1),
                    "sqrt": lambda a, _: trace.sqrt(trace.absolute(a)),
                    "select": lambda a, b: trace.select(trace.less(a, b + 0.123), a, b),
                    "const": lambda a, _: a * 0.5 - 1.0,
                }[op](a, b)
            )
    scope: dict[str, object] = {
        "a_0": inputs[0],
        "a_1": inputs[1],
        "math": math,
        "arctan2": math.atan2,
        "select": lambda c, a, b: a if c else b,
        "sqrt": math.sqrt,
        "sincos": lambda x: (math.sin(x), math.cos(x)),
    }
    last = traced[-1] if isinstance(traced[-1], Scalar) else graph.constant(traced[-1])
    exec("\n".join([*straight_line(graph, [last]), f"result = {operand(graph, last.i)}"]), scope)
    assert scope["result"] == pytest.approx(plain[-1], rel=1e-9, abs=1e-9)


def test_second_process_finds_the_machine_code(tmp_path: Path):
    """The cache lives across processes: the second one writes nothing new."""
    script = (
        "import numpy as np\nfrom holonom import trace\n"
        "k = trace.compile(lambda a: [trace.sin(a[0]) * a[1]], {'a': 2}, {'y': 1}, name='cached')\n"
        "print(k(np.array([0.5, 2.0]))[0], k(np.full((3, 2), 0.5))[2, 0], k.address != 0)\n"
    )
    environment = os.environ | {"HOLONOM_CACHE": str(tmp_path), "HOLONOM_CACHE_LOG": ""}
    first = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    before = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*") if p.is_file()}
    second = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    after = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*") if p.is_file()}
    assert first.stdout == second.stdout
    assert before == after
    assert any(p.suffix == ".kernel" for p in after)


def test_threads_that_load_a_module_at_once_all_find_the_whole_of_it(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("HOLONOM_CACHE", str(tmp_path))
    source = "import time\n\ntime.sleep(0.2)\nvalue = 1\n"
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda _: load_module("slow", source).value, range(4))) == [1] * 4


def test_generated_source_is_readable(xy):
    kernel = trace.compile(lambda a: [a[0] * a[0] + 1.0], {"a": 1}, {"y": 1}, name="square_plus_one")
    assert "def single(a, y):" in kernel.source
    assert "square_plus_one" in kernel.source
    assert kernel.operations == 2


def test_freshly_compiled_rows_equal_single_samples(tmp_path: Path):
    """A wide kernel in an empty cache: reassociating flags once spoilt one of its outputs, on first use only."""
    script = (
        "import numpy as np, holonom as hm\n"
        "k = hm.load_arm('puma560').kernel('regressor')\n"
        "x = np.random.default_rng(7).uniform(-1.0, 1.0, (3, 50, 6))\n"
        "rows = k(*x)\n"
        "print(np.abs(rows - [k(*row) for row in x.transpose(1, 0, 2).copy()]).max())\n"
    )
    environment = os.environ | {"HOLONOM_CACHE": str(tmp_path), "HOLONOM_CACHE_LOG": ""}
    found = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert float(found.stdout) < 1e-12
