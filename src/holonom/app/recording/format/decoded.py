"""Messages of one topic as arrays, block by block."""

from __future__ import annotations

import struct
from collections import defaultdict
from pathlib import Path

import numpy as np

from holonom.app.recording.format.codecs import CODECS, transform_groups
from holonom.app.recording.format.messages import log_event
from holonom.app.recording.format.topic_messages import Messages
from holonom.app.recording.tracks import FrameTrack, Track
from holonom.arrays import Array
from holonom.errors import InputError
from holonom.signals import Event, Topic

__all__ = ["Decoded", "Frames"]

Frames = dict[tuple[str, str], FrameTrack]
"""Frames by parent and name."""
TRANSFORMS, LOG = "tf2_msgs/TFMessage", "rcl_interfaces/Log"
BROKEN = (struct.error, ValueError, IndexError, StopIteration)
"""What a message that is none of its type raises."""


class Decoded:
    """What came on a topic so far: its name in the table, its row there, None where it has none and is passed over."""

    __slots__ = ("_parts", "_path", "_tracks", "events", "name", "row")

    def __init__(self, path: Path, name: str, row: Topic | None) -> None:
        self.name, self.row = name, row
        self.events: tuple[Event, ...] = ()
        self._path = path
        self._tracks: list[Track] = []
        self._parts: dict[tuple[str, str], list[tuple[Array, Array]]] = defaultdict(list)

    def add(self, messages: Messages) -> None:
        """Take more messages.

        Raises
        ------
        InputError
            One of them is damaged.
        """
        if self.row is None:
            return
        try:
            if self.row.type == TRANSFORMS:
                self._add_frames(messages)
            else:
                self._tracks.append(CODECS[self.row.type].decode(self.row, messages))
            if self.row.type == LOG:
                self.events += tuple(map(log_event, messages))
        except BROKEN as error:
            raise InputError(f"{self._path} holds a message that is damaged ({error}); record it again") from error

    def track(self) -> Track:
        """All of it as one track; messages with other joints than the first are left out."""
        first = self._tracks[0]
        same = [track for track in self._tracks if track.names == first.names]
        time = np.concatenate([track.time for track in same])
        if not first.fields and len(self._parts):
            return Track(np.unique(time), {})
        fields = {name: np.concatenate([track.fields[name] for track in same]) for name in first.fields}
        return Track(time, fields, first.names)

    def frames(self) -> Frames:
        """Frames that came."""
        return {key: _frame_track(parts) for key, parts in self._parts.items()}

    def _add_frames(self, messages: Messages) -> None:
        times = []
        for frames, time, values in transform_groups(messages):
            times.append(time)
            for i, key in enumerate(frames):
                self._parts[key].append((time, values[:, 7 * i : 7 * i + 7]))
        self._tracks.append(Track(np.unique(np.concatenate(times)), {}))


def _frame_track(parts: list[tuple[Array, Array]]) -> FrameTrack:
    time = np.concatenate([part[0] for part in parts])
    values = np.concatenate([part[1] for part in parts])
    order = np.argsort(time, kind="stable")
    return FrameTrack(time[order], values[order, :3], values[order, 3:])
