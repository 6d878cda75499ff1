"""Batches that threads share in compiled code; more threads than this machine has processors, to have them meet."""

import ctypes
import itertools
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from holonom import trace
from holonom.trace.call.crew import LOOKS, PIECES, WHOLE, Crew, run


@pytest.fixture(scope="module")
def kernel():
    return trace.compile(lambda a: [a[0] + 2.0 * a[1], a[1] * a[1]], {"a": 2}, {"y": 2}, name="shared_rows")


@pytest.fixture
def crew():
    made = Crew(5)
    made.grow(5)
    yield made
    made.stop()


def evaluate(kernel, crew, a, threads):
    """The results, NaN where no piece wrote, and whether all was finite."""
    y = np.full((len(a), 2), np.nan)
    places = np.array([a.ctypes.data, y.ctypes.data])
    return y, run(kernel.rows, places.ctypes.data, len(a), threads, crew.board)


@pytest.mark.parametrize("threads", [1, 2, 3, 6, 9])
def test_every_row_is_written(kernel, crew, threads):
    rng = np.random.default_rng(threads)
    edges = [WHOLE * PIECES * k + d for k in (1, 2, 3) for d in (-1, 0, 1)]
    for count in [*range(1, 40), *edges, *rng.integers(1, 5000, 100).tolist()]:
        a = rng.normal(size=(count, 2))
        y, fine = evaluate(kernel, crew, a, threads)
        assert fine
        np.testing.assert_array_equal(y, kernel(a))


def test_a_piece_that_is_not_finite_is_found_wherever_it_is(kernel, crew):
    for row in range(0, 1000, 7):
        a = np.ones((1000, 2))
        a[row, row % 2] = (np.nan, np.inf, -np.inf)[row % 3]
        assert not evaluate(kernel, crew, a, 4)[1]
        assert evaluate(kernel, crew, np.ones((1000, 2)), 4)[1]


def test_batches_of_several_threads_do_not_mix(kernel, crew):
    """Each is either shared or its giver's alone."""
    faults = []

    def give(seed):
        rng = np.random.default_rng(seed)
        for _ in range(300):
            a = rng.normal(size=(int(rng.integers(1, 3000)), 2))
            y, fine = evaluate(kernel, crew, a, int(rng.integers(1, 7)))
            if not fine or not np.array_equal(y, np.stack([a[:, 0] + 2.0 * a[:, 1], a[:, 1] * a[:, 1]], axis=1)):
                faults.append(seed)

    givers = [threading.Thread(target=give, args=(seed,)) for seed in range(4)]
    for giver in givers:
        giver.start()
    for giver in givers:
        giver.join()
    assert not faults


def test_a_crew_that_sleeps_wakes(kernel, crew):
    a = np.random.default_rng(3).normal(size=(4096, 2))
    wanted = kernel(a)
    for _ in range(30):
        time.sleep(2e-6 * LOOKS)
        np.testing.assert_array_equal(evaluate(kernel, crew, a, 6)[0], wanted)


@pytest.mark.parametrize("threads", [2, 6])
def test_pieces_run_at_the_same_time_and_each_once(crew, threads):
    """In place of a kernel, a function of Python's that waits for as many threads as there are to be."""
    met, pieces, seen = threading.Barrier(threads, timeout=20.0), [], set()

    @ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64)
    def rows(places, first, last):
        pieces.append((first, last))
        if threading.get_ident() not in seen:
            seen.add(threading.get_ident())
            met.wait()
        return 0.0

    count = 10_000
    assert run(ctypes.cast(rows, ctypes.c_void_p).value, 0, count, threads, crew.board)
    assert len(seen) == threads
    edges = [0, *(last for _, last in sorted(pieces))]
    assert sorted(pieces) == list(itertools.pairwise(edges))
    assert edges[-1] == count
    assert all(edge % WHOLE == 0 for edge in edges[:-1])


def test_after_the_end_a_batch_is_its_givers_alone(kernel):
    crew = Crew(2)
    crew.grow(2)
    a = np.random.default_rng(4).normal(size=(999, 2))
    np.testing.assert_array_equal(evaluate(kernel, crew, a, 3)[0], kernel(a))
    crew.stop()
    np.testing.assert_array_equal(evaluate(kernel, crew, a, 3)[0], kernel(a))


PROGRAM = """
import os
import numpy as np
from holonom import trace
import holonom.trace.kernel
holonom.trace.kernel.WORTH = 1
kernel = trace.compile(lambda a: [a[0] + 2.0 * a[1], a[1] * a[1]], {"a": 2}, {"y": 2}, name="shared_rows")
a = np.random.default_rng(5).normal(size=(5000, 2))
wanted = kernel(a)
def fine():
    return all(np.array_equal(kernel(a, threads=2), wanted) for _ in range(200))
"""


def python(text):
    subprocess.run([sys.executable, "-W", "ignore", "-c", PROGRAM + text], check=True, timeout=60)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_forked_process_makes_its_own_crew():
    python(
        "assert fine()\n"
        "child = os.fork()\n"
        "found = fine()\n"
        "if child == 0: os._exit(0 if found else 1)\n"
        "raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) or not found)\n"
    )


def test_a_process_ends_while_its_crew_looks_for_work():
    python("import atexit\natexit.register(lambda: print(fine()))\nassert fine()\n")
