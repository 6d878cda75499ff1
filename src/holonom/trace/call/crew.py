"""Threads that share the rows of a batch in compiled code, past Python and its interpreter lock.

A batch of 4,096 inverse dynamics is 0.13 ms of work; a thread of Python's takes a tenth of that to begin with its part.
Here a job is some numbers in memory, the board: who is free reads it there. A worker looks for the next job for a
while, as it comes at once where batches follow each other, and then sleeps.

Each thread has a part of the rows, in pieces; whose part is done helps with another one: a thread on a core that has
other work too does fewer. In the next batch the same part finds its rows in its core's cache.
"""

from __future__ import annotations

import atexit
import functools
import os
import threading

import numpy as np
from numba import types

from holonom.trace.call.atomic import acquire, add, exchange, exchange_if, load, new_lock, pause, release, store
from holonom.trace.call.pointer import call_rows
from holonom.trace.code.loops import loop

__all__ = ["Crew", "board", "run"]

PIECES, WHOLE = 8, 16
"""Pieces of a thread's part, and what their edges divide by."""
LOOKS = 10_000
"""Looks for a job, or for its end, before a thread sleeps: 0.1 to 0.5 ms."""
LINE = 64
"""Bytes apart: what different threads change lies in different lines of the cache."""
TICKETS, BUSY, DONE, WRONG, JOB, WORKERS, GIVER, PARTS = (LINE * k for k in range(8))
"""The board: places left in the job; whether there is one; how many have done theirs; whether a piece was not finite;
what the job is; how many workers there are; where its giver sleeps; and then the parts."""
ADDRESS, PLACES, COUNT, SHARED = (JOB + 8 * k for k in range(4))
NEXT, BED, PART = 0, LINE, 2 * LINE
"""Of a part: its next piece; where the worker with its number sleeps; and its size in bytes."""
ASLEEP, LOCK = 0, 8
"""Of a bed: whether somebody sleeps there, and the lock that wakes him."""
STOP = -1
"""In place of tickets: go home."""


@loop(nogil=True, error_model="numpy")
def _sleep(board: int, bed: int, value: int) -> None:
    """Sleep until woken, unless what is waited for (the number at `board` is no longer `value`) is there by now."""
    store(bed + ASLEEP, 1)
    # Whoever takes the mark back wakes: this thread itself, or another one, which then lets go of the lock.
    if load(board) == value or not exchange_if(bed + ASLEEP, 1, 0):
        acquire(load(bed + LOCK))


@loop(nogil=True, error_model="numpy")
def _wake(bed: int) -> bool:
    """Wake whoever sleeps there."""
    asleep: bool = load(bed + ASLEEP) == 1 and exchange_if(bed + ASLEEP, 1, 0)
    if asleep:
        release(load(bed + LOCK))
    return asleep


@loop(nogil=True, error_model="numpy")
def _row(edge: int, count: int, parts: int) -> int:
    """The row that a piece begins with."""
    row = count * edge // (PIECES * parts)
    return row - row % WHOLE if row < count else count


@loop(nogil=True, error_model="numpy")
def _take(board: int, own: int) -> None:
    """Evaluate pieces, first those of the own part, until none is left."""
    address, places = load(board + ADDRESS), load(board + PLACES)
    count, parts = load(board + COUNT), load(board + SHARED)
    check = 0.0
    for k in range(parts):
        part = (own + k) % parts
        while True:
            piece = add(board + PARTS + PART * part + NEXT, 1)
            if piece >= PIECES:
                break
            edge = PIECES * part + piece
            check += call_rows(address, places, _row(edge, count, parts), _row(edge + 1, count, parts))
    if check != 0.0:
        store(board + WRONG, 1)


@loop(types.void(types.int64, types.int64), nogil=True, error_model="numpy")
def _work(board: int, own: int) -> None:
    """What a worker does until it is told to stop."""
    looks = 0
    while True:
        left = load(board + TICKETS)
        if left == STOP:
            return
        if left > 0 and exchange_if(board + TICKETS, left, left - 1):
            _take(board, left)
            add(board + DONE, 1)
            _wake(board + GIVER)
            looks = 0
        elif looks < LOOKS:
            pause()
            looks += 1
        else:
            _sleep(board + TICKETS, board + PARTS + PART * own + BED, 0)
            looks = 0


@loop(nogil=True, error_model="numpy")
def _call_in(board: int, workers: int, wanted: int) -> None:
    """Wake as many workers as are wanted beside those who are awake."""
    for own in range(1, workers + 1):
        if load(board + PARTS + PART * own + BED + ASLEEP) == 0:
            wanted -= 1
    for own in range(1, workers + 1):
        if wanted > 0 and _wake(board + PARTS + PART * own + BED):
            wanted -= 1


@loop(types.boolean(*[types.int64] * 5), nogil=True, error_model="numpy")
def run(address: int, places: int, count: int, threads: int, board: int) -> bool:
    """Evaluate the `rows` of `emit_block` that are at an address; whether all inputs were finite.

    So many threads share them, if the crew at `board` has that many; while it is busy with another thread's batch, this
    thread does all by itself. For one thread there need not be a crew.
    """
    workers = load(board + WORKERS) if threads > 1 else 0
    parts = min(threads, workers + 1)
    if parts < 2 or exchange(board + BUSY, 1) != 0:
        return call_rows(address, places, 0, count) == 0.0
    store(board + ADDRESS, address)
    store(board + PLACES, places)
    store(board + COUNT, count)
    store(board + SHARED, parts)
    store(board + WRONG, 0)
    store(board + DONE, 0)
    for part in range(parts):
        store(board + PARTS + PART * part + NEXT, 0)
    store(board + TICKETS, parts - 1)
    _call_in(board, workers, parts - 1)
    _take(board, 0)
    taken = parts - 1 - exchange(board + TICKETS, 0)
    looks = 0
    while True:
        done = load(board + DONE)
        if done == taken:
            break
        if looks < LOOKS:
            pause()
            looks += 1
        else:
            _sleep(board + DONE, board + GIVER, done)
    fine: bool = load(board + WRONG) == 0
    store(board + BUSY, 0)
    return fine


@loop(types.void(types.int64, types.int64), nogil=True, error_model="numpy")
def _stop(board: int, workers: int) -> None:
    """Send all workers home after the batch that is running; from then on each is its giver's alone."""
    while exchange(board + BUSY, 1) != 0:
        pause()
    store(board + TICKETS, STOP)
    for own in range(1, workers + 1):
        _wake(board + PARTS + PART * own + BED)


class Crew:
    """The board, and workers: as many as were needed at once, at most `most`."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._memory = np.zeros((PARTS + PART * (most + 1)) // 8 + 8, np.int64)
        self.board = -(-self._memory.ctypes.data // LINE) * LINE
        self._threads: list[threading.Thread] = []
        self._growing, self._process = threading.Lock(), os.getpid()
        self._put(GIVER + LOCK, new_lock())

    def grow(self, workers: int) -> None:
        """Have so many workers, or the most."""
        if len(self._threads) >= min(workers, self.most):
            return
        with self._growing:
            while len(self._threads) < min(workers, self.most):
                own = len(self._threads) + 1
                self._put(PARTS + PART * own + BED + LOCK, new_lock())
                thread = threading.Thread(target=self._work, args=(own,), name="holonom", daemon=True)
                thread.start()
                self._threads.append(thread)
                self._put(WORKERS, own)

    def stop(self) -> None:
        """Let all workers end; batches go on without them. A forked process has none to end."""
        if os.getpid() == self._process:
            with self._growing:
                self.most = 0
            _stop(self.board, len(self._threads))
            for thread in self._threads:
                thread.join()

    def _work(self, own: int) -> None:
        _work(self.board, own)

    def _put(self, place: int, value: int) -> None:
        self._memory[(self.board + place - self._memory.ctypes.data) // 8] = value


@functools.cache
def _crew() -> Crew:
    """The crew of this process."""
    made = Crew((len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1) - 1)
    atexit.register(made.stop)
    return made


def board(threads: int) -> int:
    """The board of this process's crew, for a batch that so many threads may share."""
    crew = _crew()
    crew.grow(threads - 1)
    return crew.board


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_crew.cache_clear)  # a child has its parent's memory, and none of its threads
