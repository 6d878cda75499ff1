"""Work in parts for threads that are kept, as starting one costs as much as a thousand configurations.

The calling thread works too, and waits only for what the others have not finished. Rows of kernels are shared in
compiled code instead (`trace.call.crew`).
"""

from __future__ import annotations

import functools
import operator
import os
import sys
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, TypeVar

from holonom.errors import InputError

__all__ = ["check_threads", "share"]

T = TypeVar("T")


def check_threads(threads: Any) -> int:
    """Return a number of threads, as an int that compiled code can hold.

    Raises
    ------
    InputError
        It is no whole number of at least 1.
    """
    try:
        count = operator.index(threads)
    except TypeError:
        count = 0
    if count < 1:
        raise InputError(f"threads is {threads!r}; a whole number of at least 1 is needed")
    return min(count, sys.maxsize)


def share(part: Callable[[int], T], count: int) -> list[T]:
    """Return [part(0), ..., part(count - 1)]: part 0 in this thread, the others in kept ones.

    A part must not share anything itself: it would wait for the thread it runs in.
    """
    done: _Done = SimpleQueue()
    jobs = _crew().jobs(count - 1)
    for k in range(1, count):
        jobs.put((part, k, done))
    # From here to where part 0 lets go of the interpreter lock, every step makes the others wait.
    outcomes = [_outcome(part, 0)]
    outcomes += [done.get() for _ in range(1, count)]
    found: list[Any] = [None] * count
    for k, value, problem in outcomes:
        if problem is not None:
            raise problem
        found[k] = value
    return found


_Outcome = tuple[int, Any, BaseException | None]
_Done = SimpleQueue[_Outcome]


def _outcome(part: Callable[[int], Any], k: int) -> _Outcome:
    try:
        return k, part(k), None
    except BaseException as problem:
        return k, None, problem


class _Crew:
    """Threads that wait for work; as many as were needed at once, at most one per processor."""

    def __init__(self) -> None:
        self._jobs: SimpleQueue[tuple[Callable[[int], Any], int, _Done]] = SimpleQueue()
        self._size = 0
        self._growing = threading.Lock()

    def jobs(self, workers: int) -> SimpleQueue[tuple[Callable[[int], Any], int, _Done]]:
        """Where to put work, for so many threads at least."""
        if workers > self._size:
            with self._growing:
                while self._size < min(workers, os.cpu_count() or 1):
                    threading.Thread(target=self._work, name="holonom", daemon=True).start()
                    self._size += 1
        return self._jobs

    def _work(self) -> None:
        while True:
            part, k, done = self._jobs.get()
            done.put(_outcome(part, k))
            del part, done  # or they would keep their arrays until the next ones


@functools.cache
def _crew() -> _Crew:
    return _Crew()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_crew.cache_clear)  # a child has its parent's memory, and none of its threads
