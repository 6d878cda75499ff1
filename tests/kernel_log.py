"""What the log of kernels (`HOLONOM_CACHE_LOG`) says of a session, in all its processes."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["compile_seconds"]


def compile_seconds(spans: Iterable[tuple[int, float, float]]) -> float:
    """CPU time of spans (process, begin, end), s; what lies within another one of its process counts once."""
    total, until = 0.0, dict[int, float]()
    for process, begin, end in sorted(spans):
        begin = max(begin, until.get(process, 0.0))
        total += max(end - begin, 0.0)
        until[process] = max(end, begin)
    return total
