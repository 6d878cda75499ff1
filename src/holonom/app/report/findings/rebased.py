"""Recordings by other tools are stamped with dates; a report counts from their beginning."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from holonom.app.recording import Recording

__all__ = ["rebased"]

DATE = 1e8
"""Seconds from which on a time is a date."""


def rebased(recording: Recording) -> Recording:
    """The recording with the time of its first record zero, if its times are dates; else itself."""
    begins = [float(track.time[0]) for track in recording.tracks.values() if len(track.time)]
    start = min([*begins, *(event.time for event in recording.events[:1])], default=0.0)
    if start < DATE:
        return recording

    def moved(record: Any) -> Any:
        return replace(record, time=record.time - start)

    return replace(
        recording,
        tracks={name: moved(track) for name, track in recording.tracks.items()},
        frames={name: moved(track) for name, track in recording.frames.items()},
        tree={name: moved(track) for name, track in recording.tree.items()},
        signals=tuple(map(moved, recording.signals)),
        events=tuple(map(moved, recording.events)),
        missing=tuple(missing.moved(-start) for missing in recording.missing),
    )
