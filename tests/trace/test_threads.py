"""Work shared among kept threads."""

import subprocess
import sys
import threading

import pytest

from holonom.trace import share


def test_results_come_in_order_and_part_0_runs_here():
    assert share(lambda k: (k, threading.current_thread() is threading.main_thread()), 1) == [(0, True)]
    found = share(lambda k: (k, threading.current_thread() is threading.main_thread()), 9)
    assert found == [(k, k == 0) for k in range(9)]


def test_parts_run_at_the_same_time():
    both = threading.Barrier(2, timeout=10.0)  # a part alone would wait in vain
    assert share(lambda k: both.wait() >= 0, 2) == [True, True]


@pytest.mark.parametrize("bad", [0, 3])
def test_what_a_part_raises_is_raised_when_all_are_done(bad):
    done = []

    def part(k):
        if k == bad:
            raise ValueError(f"part {k}")
        done.append(k)

    with pytest.raises(ValueError, match=f"part {bad}"):
        share(part, 5)
    assert sorted(done) == [k for k in range(5) if k != bad]
    assert share(lambda k: k, 5) == [0, 1, 2, 3, 4]


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="no fork here")
def test_a_forked_process_makes_its_own_threads():
    program = (
        "import os\n"
        "from holonom.trace import share\n"
        "assert share(lambda k: k, 3) == [0, 1, 2]\n"
        "child = os.fork()\n"
        "found = share(lambda k: k, 3)\n"
        "if child == 0: os._exit(0 if found == [0, 1, 2] else 1)\n"
        "raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    subprocess.run([sys.executable, "-W", "ignore", "-c", program], check=True, timeout=60)
