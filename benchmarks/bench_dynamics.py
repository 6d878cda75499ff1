"""Inverse and forward dynamics in batches, from three separate (N, n) arrays; medians over the robots.

One thread beside the peer; then two threads beside one. The latter take the best of many rounds, for a core that is
busy with something else tells nothing about ours; and beside them stands what two threads reach that share nothing.
At 4,096 rows (0.15 ms) the two cores exchange as many rows as they compute.
"""

from __future__ import annotations

import ctypes
import math
import threading
import time

import numpy as np
from peers import peer, pinocchio_model
from robots import medians

from holonom import Arm
from holonom.app.about.bench import Figure, Setting, seconds

SIZES = (4096, 65536)


def measure(setting: Setting) -> list[Figure]:
    sizes = SIZES[:1] if setting.small else SIZES
    return [f for rows in sizes for f in _at(rows, setting)] + [f for rows in sizes for f in _threads(rows, setting)]


def _at(rows: int, setting: Setting) -> list[Figure]:
    inverse, rnea, forward, aba = medians(lambda arm: _times(arm, rows, setting))
    assert inverse is not None
    assert forward is not None
    return [
        Figure(f"inverse dynamics, {rows} rows", inverse, "ns", "Pinocchio rneaInParallel(1)", rnea, goal=20.0),
        Figure(f"forward dynamics, {rows} rows", forward, "ns", "Pinocchio abaInParallel(1)", aba, goal=20.0),
    ]


def _threads(rows: int, setting: Setting) -> list[Figure]:
    numbers = medians(lambda arm: _best(arm, rows, setting))
    figures = []
    for k, verb in enumerate(("inverse dynamics", "forward dynamics")):
        one, two, apart = numbers[3 * k : 3 * k + 3]
        assert two is not None
        assert apart is not None
        what = f"{verb}, {rows} rows, two threads"
        figures.append(Figure(what, two, "ns", "one thread", one, goal=1.8))
        figures.append(Figure(f"{what} that share nothing", apart, "ns", "one thread", one))
    return figures


def _best(arm: Arm, rows: int, setting: Setting) -> list[float]:
    """Nanoseconds per sample, each verb: one thread, two, and two that never wait for each other (the machine's best).

    Turns of all three alternate, of several calls each, so that every core finds its rows where it left them.
    """
    q, qd, x = setting.rng.uniform(-3.0, 3.0, (3, rows, arm.n))
    out, times = np.empty((rows, arm.n)), []
    turns = 1 if setting.small else max(8, 300_000 // rows)
    for name in ("inverse_dynamics", "forward_dynamics"):
        verb, kernel = getattr(arm, name), arm.kernel(name)
        given = [q, qd, x][: len(kernel.inputs)]
        least = [math.inf] * 3
        for _ in range(turns):
            for k, threads in enumerate((1, 2)):
                for _ in range(6):
                    begin = time.perf_counter()
                    verb(q, qd, x, out=out, threads=threads)
                    least[k] = min(least[k], time.perf_counter() - begin)
            least[2] = min(least[2], _apart(kernel.rows, (*given, out), rows))
        times += [1e9 * each / rows for each in least]
    return times


def _apart(address: int, arrays: tuple[np.ndarray, ...], rows: int) -> float:
    """Seconds for all rows by two threads that each go over their half again and again."""
    again, middle = max(4, 400_000 // rows), rows // 2
    evaluate = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64)(address)
    places = np.array([a.ctypes.data for a in arrays])

    def half(first: int, last: int) -> None:
        for _ in range(again):
            evaluate(places.ctypes.data, first, last)

    threads = [threading.Thread(target=half, args=part) for part in ((0, middle), (middle, rows))]
    begin = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return (time.perf_counter() - begin) / again


def _times(arm: Arm, rows: int, setting: Setting) -> list[float | None]:
    """Nanoseconds per sample: inverse dynamics, Pinocchio's, forward dynamics, Pinocchio's."""
    motion = setting.rng.uniform(-3.0, 3.0, (3, rows, arm.n))
    q, qd, x = motion
    out, pin = np.empty((rows, arm.n)), peer("pinocchio")
    inverse = seconds(lambda: arm.inverse_dynamics(q, qd, x, out=out), setting) / rows
    rnea = _pinocchio(pin, arm, "rneaInParallel", motion, setting)
    forward = seconds(lambda: arm.forward_dynamics(q, qd, x, out=out), setting) / rows
    return [1e9 * inverse, rnea, 1e9 * forward, _pinocchio(pin, arm, "abaInParallel", motion, setting)]


def _pinocchio(pin, arm, verb: str, rows, setting: Setting) -> float | None:
    """Nanoseconds per sample of Pinocchio's batch verb with one thread; its columns are our rows."""
    if pin is None:
        return None
    pool = pin.ModelPool(pinocchio_model(pin, arm), 1)
    columns = [np.asfortranarray(a.T) for a in rows]
    out = np.zeros_like(columns[0], order="F")
    return 1e9 * seconds(lambda: getattr(pin, verb)(1, pool, *columns, out), setting) / columns[0].shape[1]
