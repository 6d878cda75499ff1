"""Numbers for the page: arrays as 32-bit floats, column by column, compressed, in base 64."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Sequence

import numpy as np

from holonom.app.recording import FrameTrack, Recording
from holonom.app.report.drawing.curves import Curve
from holonom.app.report.drawing.scene import Scene
from holonom.arrays import Array
from holonom.errors import UnknownName

__all__ = ["Blob", "add_curves", "add_frames", "replay_rate"]


REPLAY_RATE = 50.0
"""Poses per second in the page; the browser interpolates between them."""
REPLAY_POSES = 400_000
"""Poses of all frames together; the replay of a long run has fewer per second."""
SLOWEST_RATE = 1.0
MOST_POSES = 10 * REPLAY_POSES
"""However long a recording is, or says that it is."""
CURVE_SAMPLES = 8_000
"""Longer curves are thinned to so many samples: the least and the largest of each stretch."""


class Blob:
    """Named arrays in one stretch of bytes; columns stay together, so that what stands still costs nothing."""

    __slots__ = ("_parts", "_size", "index")

    def __init__(self) -> None:
        self.index: dict[str, list[int]] = {}
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, name: str, values: Array) -> None:
        """Add `values` (rows,) or (rows, columns)."""
        rows = len(values)
        table = values.reshape(rows, -1) if rows else np.empty((0, 0))
        part = np.ascontiguousarray(table.T, dtype="<f4").tobytes()
        self.index[name] = [self._size // 4, rows, table.shape[1]]
        self._parts.append(part)
        self._size += len(part)

    def text(self) -> str:
        """All of it as gzip in base 64; the same arrays always give the same text."""
        return base64.b64encode(gzip.compress(b"".join(self._parts), compresslevel=9, mtime=0)).decode()


def replay_rate(recording: Recording, scene: Scene) -> float:
    """Poses per second in the page: `REPLAY_RATE`, less for a long run with many frames."""
    moving = sum(name in recording.frames for name in scene.frames())
    poses = recording.end() * max(moving, 1) * REPLAY_RATE
    wanted = REPLAY_RATE * min(1.0, REPLAY_POSES / max(poses, 1.0))
    return min(max(wanted, SLOWEST_RATE), REPLAY_RATE * MOST_POSES / max(poses, 1.0), REPLAY_RATE)


def add_frames(blob: Blob, recording: Recording, scene: Scene, rate: float) -> int:
    """Add the poses (x y z, quaternion x y z w) of every frame of the scene; one row for one at rest.

    Returns
    -------
    int
        Number of frames missing because the run ended before the first of them was recorded: all or none.

    Raises
    ------
    UnknownName
        The scene uses a frame that the recording does not have.
    """
    if not recording.frames:
        return len(scene.frames())
    for name in scene.frames():
        if name not in recording.frames:
            raise UnknownName("frame in the recording", name, recording.frames)
        blob.add(f"frame:{name}", _resampled(recording.frames[name], recording.end(), rate))
    return 0


def add_curves(blob: Blob, curves: Sequence[Curve]) -> list[dict[str, object]]:
    """Add curves, thinned, with their times, each stretch of times once; return what the page's script is told."""
    times: dict[bytes, str] = {}
    told: list[dict[str, object]] = []
    for curve in curves:
        time, values = _thinned(curve.time, curve.values)
        name = times.setdefault(time.tobytes(), f"time:{len(times)}")
        if name not in blob.index:
            blob.add(name, time)
        blob.add(f"curve:{curve.key}", values)
        told.append({"key": curve.key, "title": curve.title, "unit": curve.unit, "names": curve.names, "time": name})
    return told


def _thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """At most `CURVE_SAMPLES` samples: of each stretch the least and the largest value, in their order."""
    if len(time) <= CURVE_SAMPLES:
        return time, values
    size = -(-len(time) // (CURVE_SAMPLES // 2))
    starts = np.arange(0, len(time), size)
    middles = np.minimum(starts + size // 2, len(time) - 1)
    rows = np.empty((2 * len(starts), values.shape[1]))
    for column, one in zip(rows.T, values.T, strict=True):
        parts = [one[start : start + size] for start in starts]
        ends = np.array([(part.min(), part.max(), part.argmin() > part.argmax()) for part in parts])
        turned = ends[:, 2] == 1.0
        column[0::2] = np.where(turned, ends[:, 1], ends[:, 0])
        column[1::2] = np.where(turned, ends[:, 0], ends[:, 1])
    return time[np.stack([starts, middles], axis=1).ravel()], rows


def _resampled(track: FrameTrack, end: float, rate: float) -> Array:
    """Rows (m, 7) at a rate, the last sample known at each time; one row for a frame at rest."""
    rows = np.hstack([track.position, track.quaternion])
    if np.all(rows == rows[0]):
        return rows[:1]
    times = np.arange(0.0, end + 1 / rate, 1 / rate)
    at = np.searchsorted(track.time, times + 1e-9, side="right") - 1
    return np.asarray(rows[np.maximum(at, 0)])
