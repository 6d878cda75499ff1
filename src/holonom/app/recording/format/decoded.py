"""Messages of one topic as arrays, block by block."""

from __future__ import annotations

import struct
from collections import defaultdict
from dataclasses import replace

import numpy as np

from holonom.app.recording.format.codecs import CODECS, transform_groups
from holonom.app.recording.format.messages import log_event
from holonom.app.recording.format.missing import Missing
from holonom.app.recording.format.topic_messages import Messages
from holonom.app.recording.tracks import FrameTrack, Track
from holonom.arrays import Array
from holonom.signals import Event, Topic

__all__ = ["Decoded", "Frames"]

Placed = tuple[tuple[str, str], Array, Array]
"""A frame by parent and name, its times (N,) and rows (N, 7)."""
MOST_BAD = 1000
"""Messages of a topic that are sorted out one by one."""
Frames = dict[tuple[str, str], FrameTrack]
"""Frames by parent and name."""
TRANSFORMS, LOG = "tf2_msgs/TFMessage", "rcl_interfaces/Log"
BROKEN = (struct.error, ValueError, IndexError)
"""What a message that is none of its type raises."""


class Decoded:
    """What came on a topic so far: its name in the table, its row there, None where it has none and is passed over."""

    __slots__ = ("_first_bad", "_last_bad", "_parts", "_tracks", "_why", "bad", "events", "name", "row")

    def __init__(self, name: str, row: Topic | None) -> None:
        self.name, self.row = name, row
        self.events: tuple[Event, ...] = ()
        self.bad = 0
        self._why = ""
        self._first_bad = self._last_bad = 0.0
        self._tracks: list[Track] = []
        self._parts: dict[tuple[str, str], list[tuple[Array, Array]]] = defaultdict(list)

    def add(self, messages: Messages) -> None:
        """Take more messages; those that are not laid out as their type is are passed over and counted."""
        if self.row is None or not len(messages):
            return
        try:
            with np.errstate(all="ignore"):  # numbers of a damaged message may be of any size
                track, frames, events = self._read(self.row, messages)
        except BROKEN as error:
            self._sort_out(messages, error)
            return
        self._tracks.append(track)
        self.events += events
        for key, time, values in frames:
            self._parts[key].append((time, values))

    @property
    def read(self) -> bool:
        """Whether any message of it was of its type."""
        return bool(self._tracks)

    def missing(self) -> Missing | None:
        """What was passed over."""
        if not self.bad:
            return None
        what = f"{self.bad} messages of {self.name} that are not laid out as their type is ({self._why})"
        return Missing(self._first_bad, self._last_bad, (what,), 0)

    def track(self) -> Track:
        """All that was `read` of it as one track; messages of other joints or fields than the first are left out."""
        first = self._tracks[0]
        same = [track for track in self._tracks if _shape(track) == _shape(first)]
        time = np.concatenate([track.time for track in same])
        if not first.fields and len(self._parts):
            return Track(np.unique(time), {})
        fields = {name: np.concatenate([track.fields[name] for track in same]) for name in first.fields}
        return Track(time, fields, first.names)

    def frames(self) -> Frames:
        """Frames that came."""
        return {key: _frame_track(parts) for key, parts in self._parts.items()}

    def _read(self, row: Topic, messages: Messages) -> tuple[Track, list[Placed], tuple[Event, ...]]:
        """Messages of a topic as a track, as poses of frames, and as events."""
        if row.type == TRANSFORMS:
            times, frames = [], []
            for names, time, values in transform_groups(messages):
                times.append(time)
                frames += [(key, time, values[:, 7 * i : 7 * i + 7]) for i, key in enumerate(names)]
            return Track(np.unique(np.concatenate(times)), {}), frames, ()
        events: tuple[Event, ...] = ()
        if row.type == LOG:  # its own stamps count from the clock's zero
            seconds = messages.seconds().tolist()
            events = tuple(replace(log_event(m), time=t) for m, t in zip(messages, seconds, strict=True))
        return CODECS[row.type].decode(row, messages), [], events

    def _sort_out(self, messages: Messages, error: Exception) -> None:
        """Take the sound ones of messages of which some are not: each half for itself."""
        if len(messages) > 1 and self.bad < MOST_BAD:
            for half in messages.halves():
                self.add(half)
            return
        if not self.bad:
            self._why = " ".join(str(error).split()) or type(error).__name__
            self._first_bad = float(messages.seconds()[0])
        self.bad += len(messages)
        self._last_bad = messages.last()


def _shape(track: Track) -> tuple[object, ...]:
    """What tracks have in common that are one."""
    return track.names, {name: values.shape[1:] for name, values in track.fields.items()}


def _frame_track(parts: list[tuple[Array, Array]]) -> FrameTrack:
    time = np.concatenate([part[0] for part in parts])
    values = np.concatenate([part[1] for part in parts])
    order = np.argsort(time, kind="stable")
    return FrameTrack(time[order], values[order, :3], values[order, 3:])
